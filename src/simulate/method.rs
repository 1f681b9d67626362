//! The methods of a simulation: their names, the one that fits, and what each is made of.

use crate::error::{Error, Result};
use crate::flow::steps::chosen::StepChoice;
use crate::hybrid::has_series;
use crate::model::{Parameter, Ramp, RampProfile, Scene, System};
use nalgebra::DVector;

/// How the flights are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The least machinery that is exact for the scene: closed-form flights for a linear one.
    #[default]
    Auto,
    /// Closed-form flights; linear scenes only.
    Exact,
    /// Taylor series whose order grows with the tolerance's digits; pendulums with large motions.
    Taylor,
    /// The Dormand-Prince pair of orders 5 and 4; any scene.
    Rk45,
    /// The method of order 8 of Dormand and Prince, with dense output of order 7; any scene, tight tolerances.
    Dop853,
    /// The implicit Radau IIA method of order 5; any scene, stiff motions.
    Radau,
}

impl Method {
    /// Every method with its name.
    const ALL: [(Self, &str); 6] = [
        (Self::Auto, "auto"),
        (Self::Exact, "exact"),
        (Self::Taylor, "taylor"),
        (Self::Rk45, "rk45"),
        (Self::Dop853, "dop853"),
        (Self::Radau, "radau"),
    ];

    /// The name used in Python.
    pub fn name(self) -> &'static str {
        let own = Self::ALL.iter().find(|(method, _)| *method == self);
        own.map_or("auto", |(_, name)| name)
    }

    /// The method of a name, in any letter case.
    ///
    /// # Errors
    /// A name that no method has.
    pub fn from_name(name: &str) -> Result<Self> {
        let known = Self::ALL
            .iter()
            .find(|(_, own)| own.eq_ignore_ascii_case(name));
        known.map(|(method, _)| *method).ok_or_else(|| {
            let names: Vec<String> = Self::ALL
                .iter()
                .map(|(_, own)| format!("\"{own}\""))
                .collect();
            let rule = format!("it must be one of {}", names.join(", "));
            Error::bad_value("method", format!("{name:?}"), rule)
        })
    }

    /// The method that will run: the least machinery that is exact for the scene; `Auto` where that is steps, of the method that
    /// fits their tolerance, and of the implicit one from where the motion is found stiff.
    pub(crate) fn chosen_for(self, scene: &Scene) -> Self {
        match self {
            Self::Auto if scene.drifting_damping().is_some() => Self::Auto,
            Self::Auto if scene.linear_system("simulate").is_ok() => Self::Exact,
            Self::Auto if has_series(scene) => Self::Taylor,
            asked => asked,
        }
    }
}

impl Method {
    /// The method by which a scene follows ramps. Along steady ones of what acts on it a linear scene flies under the series of the force,
    /// piece by piece (theory 14), along others in closed form.
    ///
    /// # Errors
    /// Exact flights along a steady ramp of what acts, flights in closed form or by series along one of the damping.
    pub(crate) fn under(self, ramps: &[Ramp], scene: &Scene) -> Result<Self> {
        let is_steady = |ramp: &&Ramp| !matches!(ramp.profile(), RampProfile::Steps { .. });
        let of = |named: &[Parameter]| {
            let mut steady = ramps.iter().filter(is_steady).map(Ramp::parameter);
            steady.find(|parameter| named.contains(parameter))
        };
        let acts = of(&[
            Parameter::Frequency,
            Parameter::Phase,
            Parameter::ForcingScale,
        ]);
        let is_linear = scene.linear_system("simulate").is_ok();
        let refused = |parameter: Parameter, flights: &str, remedy: &str| {
            let rule = format!("{flights} cannot follow it: give levels= and dwell=, or {remedy}");
            Err(Error::bad_value(
                format!("ramp of \"{parameter}\""),
                "continuous",
                rule,
            ))
        };
        match (self, of(&[Parameter::DampingScale]), acts) {
            (Self::Exact, Some(parameter), _) => {
                refused(parameter, "exact flights", "method=\"dop853\"")
            }
            (Self::Taylor, Some(parameter), _) => refused(parameter, "series", "method=\"dop853\""),
            (Self::Exact, None, Some(parameter)) => {
                refused(parameter, "exact flights", "method=\"taylor\"")
            }
            (Self::Taylor, None, _) if is_linear => Ok(Self::Exact),
            _ => Ok(self),
        }
    }

    /// What is chosen of the steps that any motion takes; none for the pair, whose steps are made for each kind of motion.
    pub(crate) fn choice(self) -> Option<StepChoice> {
        match self {
            Self::Dop853 => Some(StepChoice::Dop853),
            Self::Radau => Some(StepChoice::Radau),
            Self::Auto => Some(StepChoice::Fitting),
            Self::Rk45 | Self::Exact | Self::Taylor => None,
        }
    }
}

/// Refuses a Jacobian of a system given by functions that is not that of its acceleration at a start, where a method uses it.
///
/// # Errors
/// A Jacobian of another shape, not finite or wrong; what the functions report.
pub(crate) fn check_jacobian(
    method: Method,
    scene: &Scene,
    t: f64,
    (q, v): (&DVector<f64>, &DVector<f64>),
) -> Result<()> {
    match (method, scene.system()) {
        (Method::Radau | Method::Auto, System::Nonlinear(system)) => {
            system.check_jacobian(t, q.as_slice(), v.as_slice())
        }
        _ => Ok(()),
    }
}

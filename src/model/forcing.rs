//! What drives a scene: forces on the coordinates and motions of the base, periodic or after a signal, one of them or several.

use crate::error::{Error, Result};
use crate::model::base_acceleration::BaseAcceleration;
use crate::model::base_motion::BaseMotion;
use crate::model::fourier::Fourier;
use crate::model::load::Load;
use crate::model::signal::Signal;
use crate::quantity::{finite, finite_complex, positive};
use crate::tolerance::{HIGHEST_MULTIPLE, WHOLE_MULTIPLE};
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;
use std::ops::Deref;

/// Harmonic force `Re(amplitude exp(i (frequency t + phase)))` on the coordinates. It is a periodic one of one harmonic.
#[derive(Debug, Clone, PartialEq)]
pub struct Harmonic(Fourier);

impl Harmonic {
    /// A harmonic force; a real `amplitude` of shape `(n,)` is a cosine.
    ///
    /// # Errors
    /// No amplitude at all, numbers that are not finite, or a frequency that is not positive.
    pub fn new(amplitude: DVector<Complex<f64>>, frequency: f64, phase: f64) -> Result<Self> {
        if amplitude.is_empty() {
            let expected = "(n,): one number for each degree of freedom";
            return Err(Error::bad_shape("amplitude", "(0,)", expected));
        }
        finite_complex("amplitude", &amplitude)?;
        Fourier::new(vec![amplitude], frequency, phase).map(Self)
    }

    /// The force amplitude, shape `(n,)`.
    pub fn amplitude(&self) -> &DVector<Complex<f64>> {
        &self.amplitudes()[0]
    }
}

impl Deref for Harmonic {
    type Target = Fourier;

    fn deref(&self) -> &Fourier {
        &self.0
    }
}

/// What drives a scene: nothing, one forcing, or several.
///
/// Several share a period where the frequencies of all are whole multiples of the lowest, to 1e-12 and up to 4096 times it. Where they
/// are not, and where there is a signal, there is no period: such scenes are simulated, and what looks for periodic motions says why it
/// does not take them.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Forcing {
    /// Nothing.
    #[default]
    Unforced,
    /// A harmonic force on the coordinates.
    Harmonic(Harmonic),
    /// A periodic displacement of the base.
    BaseMotion(BaseMotion),
    /// A periodic force on the coordinates.
    Fourier(Fourier),
    /// A force along a direction that follows a signal.
    Load(Load),
    /// A base with an acceleration that follows a signal.
    BaseAcceleration(BaseAcceleration),
    /// Several at once.
    Several(Vec<Forcing>),
}

macro_rules! forcing_from {
    ($($kind:ident),*) => {$(
        impl From<$kind> for Forcing {
            fn from(forcing: $kind) -> Self {
                Self::$kind(forcing)
            }
        }
    )*};
}
forcing_from!(Harmonic, BaseMotion, Fourier, Load, BaseAcceleration);

impl From<Vec<Forcing>> for Forcing {
    fn from(forcings: Vec<Forcing>) -> Self {
        Self::Several(forcings)
    }
}

/// How a scene depends on time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Timing {
    /// Not at all.
    Constant,
    /// Periodically, by angles of a fundamental frequency.
    Periodic { frequency: f64 },
    /// Without a period, and why.
    Aperiodic { reason: String },
}

/// How many times a frequency is another, if that is a whole number.
pub(crate) fn whole_multiple(frequency: f64, of: f64) -> Option<u32> {
    let (ratio, times) = (frequency / of, (frequency / of).round());
    let is_whole = (1.0..=HIGHEST_MULTIPLE).contains(&times)
        && (ratio - times).abs() <= WHOLE_MULTIPLE * times;
    is_whole.then_some(times as u32)
}

/// The forcings that a forcing is made of, in their order; of one alone nothing is allocated.
pub(crate) struct Parts<'a> {
    first: Option<&'a Forcing>,
    open: Vec<std::slice::Iter<'a, Forcing>>,
}

impl<'a> Iterator for Parts<'a> {
    type Item = &'a Forcing;

    fn next(&mut self) -> Option<&'a Forcing> {
        loop {
            let own = self.first.take();
            match own.or_else(|| self.open.last_mut()?.next()) {
                Some(Forcing::Unforced) => {}
                Some(Forcing::Several(forcings)) => self.open.push(forcings.iter()),
                Some(one) => return Some(one),
                None => drop(self.open.pop()?),
            }
        }
    }
}

impl Forcing {
    /// Each forcing by itself.
    pub(crate) fn parts(&self) -> Parts<'_> {
        Parts {
            first: Some(self),
            open: Vec::new(),
        }
    }

    /// The kind of forcing, as messages name it.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Unforced => "nothing",
            Self::Harmonic(_) => "a harmonic force",
            Self::BaseMotion(_) => "a base motion",
            Self::Fourier(_) => "a periodic force",
            Self::Load(_) => "a load that follows a signal",
            Self::BaseAcceleration(_) => "a base acceleration",
            Self::Several(_) => "several forcings",
        }
    }

    /// What one forcing follows in time, if that is periodic.
    pub(super) fn own_periodic(&self) -> Option<&Fourier> {
        match self {
            Self::Harmonic(Harmonic(f)) | Self::Fourier(f) | Self::BaseMotion(BaseMotion(f)) => {
                Some(f)
            }
            _ => None,
        }
    }

    /// The signal that one forcing follows.
    pub(crate) fn own_signal(&self) -> Option<&Signal> {
        match self {
            Self::Load(f) => Some(&f.signal),
            Self::BaseAcceleration(f) => Some(&f.signal),
            _ => None,
        }
    }

    /// The fundamental frequency of one forcing, and its phase; none of a signal.
    pub(super) fn own_angle(&self) -> Option<(f64, f64)> {
        self.own_periodic().map(|f| (f.frequency, f.phase))
    }

    /// The forcing with what each part follows in time changed, wherever it acts.
    fn with_sources(
        &self,
        periodic: &impl Fn(&mut Fourier),
        signal: &impl Fn(&Signal) -> Signal,
    ) -> Self {
        let mut copy = self.clone();
        match &mut copy {
            Self::Unforced => {}
            Self::Harmonic(Harmonic(f)) | Self::Fourier(f) | Self::BaseMotion(BaseMotion(f)) => {
                periodic(f);
            }
            Self::Load(f) => f.signal = signal(&f.signal),
            Self::BaseAcceleration(f) => f.signal = signal(&f.signal),
            Self::Several(all) => {
                for part in all {
                    *part = part.with_sources(periodic, signal);
                }
            }
        }
        copy
    }

    /// The frequencies and phases of those that are periodic, in their order.
    pub(super) fn angles(&self) -> impl Iterator<Item = (f64, f64)> {
        self.parts().filter_map(Self::own_angle)
    }

    /// The lowest frequency, and the phase of the first that has it.
    pub(super) fn lowest(&self) -> Option<(f64, f64)> {
        self.angles()
            .reduce(|lowest, other| if other.0 < lowest.0 { other } else { lowest })
    }

    /// How the forcing depends on time.
    pub(crate) fn timing(&self) -> Timing {
        // One forcing alone has nothing that it could be out of step with.
        if let Some((frequency, _)) = self.own_angle() {
            return Timing::Periodic { frequency };
        }
        if self.parts().any(|part| part.own_signal().is_some()) {
            let reason =
                "its forcing, or the motion of a stop, follows a signal, which has no period"
                    .to_owned();
            return Timing::Aperiodic { reason };
        }
        let Some((frequency, _)) = self.lowest() else {
            return Timing::Constant;
        };
        match self
            .angles()
            .find(|(w, _)| whole_multiple(*w, frequency).is_none())
        {
            None => Timing::Periodic { frequency },
            Some((other, _)) => Timing::Aperiodic {
                reason: format!(
                    "its forcings have no common period: the frequency {other} is no whole multiple of the lowest, {frequency}; harmonics of one frequency can be one Fourier"
                ),
            },
        }
    }

    /// The fundamental frequency, the lowest where the others are whole multiples of it; `None` without forcing, and where there is no
    /// period.
    pub fn frequency(&self) -> Option<f64> {
        match self.timing() {
            Timing::Periodic { frequency } => Some(frequency),
            Timing::Constant | Timing::Aperiodic { .. } => None,
        }
    }

    /// The phase of the fundamental frequency, that of the first forcing which has it; zero without forcing, NaN where there is no
    /// period. The number `Parameter::Phase` of a scene is that of the first part, which may be another.
    pub fn phase(&self) -> f64 {
        match self.timing() {
            Timing::Constant => 0.0,
            Timing::Periodic { .. } => self.lowest().map_or(0.0, |(_, phase)| phase),
            Timing::Aperiodic { .. } => f64::NAN,
        }
    }

    /// The period `2 pi / frequency`, `None` without forcing, and where there is none.
    pub fn period(&self) -> Option<f64> {
        self.frequency().map(|w| TAU / w)
    }

    /// The forcing shifted in time so that its first periodic part has another phase.
    pub(crate) fn with_phase(&self, phase: f64) -> Result<Self> {
        finite("phase", phase)?;
        match self.angles().next() {
            None => Err(self.no_angle("phase", phase)),
            Some(first) => Ok(self.turned(first, phase)),
        }
    }

    /// The forcing shifted in time so that the part with the fundamental frequency has another phase.
    pub(crate) fn with_fundamental_phase(&self, phase: f64) -> Result<Self> {
        finite("phase", phase)?;
        match self.lowest() {
            None => Err(self.no_angle("phase", phase)),
            Some(lowest) => Ok(self.turned(lowest, phase)),
        }
    }

    /// The forcing with other frequencies and phases of its periodic parts, by a map from the old ones.
    pub(super) fn with_angles(&self, of: &impl Fn((f64, f64)) -> (f64, f64)) -> Result<Self> {
        let turn = |f: &mut Fourier| (f.frequency, f.phase) = of((f.frequency, f.phase));
        let changed = self.with_sources(&turn, &Signal::clone);
        for part in changed.parts() {
            if let Some((frequency, _)) = part.own_angle() {
                positive("frequency", frequency)?;
            }
            if let Self::BaseMotion(base) = part {
                base.check()?;
            }
        }
        Ok(changed)
    }

    /// The forcing shifted in time so that a part with the given frequency and phase has the phase `to`.
    fn turned(&self, (frequency, from): (f64, f64), to: f64) -> Self {
        let span = (to - from) / frequency;
        let turn = |f: &mut Fourier| {
            let is_given = f.frequency == frequency && f.phase == from;
            f.phase = if is_given {
                to
            } else {
                f.phase + f.frequency * span
            };
        };
        self.with_sources(&turn, &|signal| signal.earlier(span))
    }

    /// The forcing at another fundamental frequency, or lowest one where there is no period: the other frequencies are scaled with it,
    /// signals are not.
    pub(crate) fn with_frequency(&self, frequency: f64) -> Result<Self> {
        positive("frequency", frequency)?;
        let Some((lowest, _)) = self.lowest() else {
            return Err(self.no_angle("frequency", frequency));
        };
        self.with_angles(&|(w, phase)| match whole_multiple(w, lowest) {
            Some(times) => (f64::from(times) * frequency, phase),
            None => (w * (frequency / lowest), phase),
        })
    }

    /// The same forcing with its amplitude, or its signal, multiplied by a number.
    pub(crate) fn scaled(&self, factor: f64) -> Result<Self> {
        finite("forcing_scale", factor)?;
        if *self == Self::Unforced {
            return Err(no_forcing("forcing_scale", factor));
        }
        let scaled = self.with_sources(&|f| f.scale(factor), &|signal| signal.scaled(factor));
        if scaled.is_finite() {
            return Ok(scaled);
        }
        let rule = "the amplitude times it, and the acceleration of a base, must be finite";
        Err(Error::bad_value("forcing_scale", factor, rule))
    }

    /// Whether amplitudes and signals are finite, and the accelerations of bases.
    fn is_finite(&self) -> bool {
        self.parts().all(|part| match part {
            Self::BaseMotion(f) => f.has_finite_acceleration(),
            _ => {
                part.own_periodic().is_none_or(Fourier::is_finite)
                    && part.own_signal().is_none_or(Signal::is_finite)
            }
        })
    }

    /// Whether its force grows with the square of the frequency: all of it, `None` where a part of it does.
    pub(crate) fn is_inertial(&self) -> Option<bool> {
        let is_base = |part: &Self| matches!(part, Self::BaseMotion(_));
        match self.parts().filter(|part| is_base(part)).count() {
            0 => Some(false),
            _ if self.parts().all(is_base) => Some(true),
            _ => None,
        }
    }

    fn no_angle(&self, argument: &str, value: f64) -> Error {
        if self.parts().next().is_none() {
            return no_forcing(argument, value);
        }
        let rule = "the forcing follows signals, which have none; give the scene another `forcing`";
        Error::bad_value(argument, value, rule)
    }
}

fn no_forcing(argument: &str, value: f64) -> Error {
    Error::bad_value(
        argument,
        value,
        "the scene has no forcing to change; give it one with `forcing`",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    #[test]
    fn an_amplitude_beyond_the_doubles_is_refused() {
        let force = Harmonic::new(dvector![100.0.into(), 1.0.into()], 2.0, 0.0).expect("finite");
        let base = BaseMotion::new(1.0, 1e4, 0.0).expect("finite");
        for forcing in [Forcing::from(force), base.clone().into()] {
            assert!(forcing.scaled(1e299).is_ok());
            let message = forcing.scaled(1e307).expect_err("beyond").to_string();
            assert!(
                message.starts_with("forcing_scale is 1e307, but the amplitude"),
                "{message}"
            );
        }
        let message = BaseMotion::new(1.0, 1e200, 0.0)
            .expect_err("beyond")
            .to_string();
        assert!(
            message.starts_with("frequency is 1e200, but the acceleration"),
            "{message}"
        );
        let fast = Forcing::from(base).with_frequency(1e200);
        assert_eq!(fast.expect_err("beyond").to_string(), message);
    }

    #[test]
    fn several_have_a_period_where_all_are_whole_multiples_of_the_lowest() {
        let harmonic = |w: f64, phase: f64| -> Forcing {
            Harmonic::new(dvector![1.0.into()], w, phase)
                .expect("valid")
                .into()
        };
        let pair = Forcing::from(vec![harmonic(3.0, 0.4), harmonic(1.5, 0.1)]);
        assert_eq!((pair.frequency(), pair.phase()), (Some(1.5), 0.1));
        for (w, has_period) in [
            (2.0 * (1.0 + 1e-13), true),
            (2.0 * (1.0 + 1e-11), false),
            (1.5, false),
            (1.0, true),
            (5000.0, false),
        ] {
            let pair = Forcing::from(vec![harmonic(1.0, 0.0), harmonic(w, 0.3)]);
            assert_eq!(pair.period().is_some(), has_period, "{w}");
        }
        // A phase names the first one's; all are as much earlier.
        let Forcing::Several(moved) = pair.with_phase(1.0).expect("a phase") else {
            panic!("several")
        };
        assert_eq!(moved[0].phase(), 1.0);
        assert!((moved[1].phase() - (0.1 + 0.5 * 0.6)).abs() < 1e-15);
        let Forcing::Several(moved) = pair.with_fundamental_phase(1.0).expect("a phase") else {
            panic!("several")
        };
        assert_eq!(moved[1].phase(), 1.0);
        assert!((moved[0].phase() - (0.4 + 2.0 * 0.9)).abs() < 1e-15);
        let sped = pair.with_frequency(0.7).expect("a frequency");
        assert_eq!(sped.frequency(), Some(0.7));
        assert_eq!(sped.parts().next().expect("one").frequency(), Some(1.4));
    }
}

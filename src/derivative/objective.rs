//! What an optimiser asks of a periodic orbit, followed from one set of numbers of its scene to the next: a value and its gradient.

use crate::derivative::following::follow_orbit;
use crate::derivative::of_orbit::{derivatives_but_multipliers, derivatives_of};
use crate::derivative::rates::OrbitDerivatives;
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::PeriodicOrbit;
use nalgebra::{DMatrix, DVector};

/// What an orbit has that may be differentiated by numbers of its scene, as [`OrbitDerivatives`] names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OrbitQuantity {
    Q0,
    V0,
    Phase,
    Period,
    SpeedsBefore,
    Times,
    MinGap,
    MaxDisplacement,
}

impl OrbitQuantity {
    const ALL: [(Self, &'static str); 8] = [
        (Self::Q0, "q0"),
        (Self::V0, "v0"),
        (Self::Phase, "phase"),
        (Self::Period, "period"),
        (Self::SpeedsBefore, "speeds_before"),
        (Self::Times, "times"),
        (Self::MinGap, "min_gap"),
        (Self::MaxDisplacement, "max_displacement"),
    ];

    /// Whether it is one number.
    fn is_single(self) -> bool {
        matches!(self, Self::Phase | Self::Period)
    }

    /// Its entries for an orbit.
    fn of(self, orbit: &PeriodicOrbit) -> Result<Vec<f64>> {
        let impacts = orbit.impacts().iter();
        match self {
            Self::Q0 => Ok(orbit.q0().as_slice().to_vec()),
            Self::V0 => Ok(orbit.v0().as_slice().to_vec()),
            Self::Phase => Ok(vec![orbit.phase()]),
            Self::Period => Ok(vec![orbit.period()]),
            Self::SpeedsBefore => Ok(impacts.map(|impact| impact.approach).collect()),
            Self::Times => Ok(impacts.map(|impact| impact.time).collect()),
            Self::MinGap => orbit.min_gap(),
            Self::MaxDisplacement => orbit.max_displacement(),
        }
    }

    /// The derivatives of an entry by each number.
    fn derivatives(self, found: &OrbitDerivatives, entry: usize) -> Vec<f64> {
        let row = |matrix: &DMatrix<f64>| matrix.row(entry).iter().copied().collect();
        let whole = |vector: &DVector<f64>| vector.as_slice().to_vec();
        match self {
            Self::Q0 => row(&found.q0),
            Self::V0 => row(&found.v0),
            Self::Phase => whole(&found.phase),
            Self::Period => whole(&found.period),
            Self::SpeedsBefore => row(&found.speeds_before),
            Self::Times => row(&found.times),
            Self::MinGap => row(&found.min_gap),
            Self::MaxDisplacement => row(&found.max_displacement),
        }
    }
}

/// An entry of what an orbit has: a quantity, and which of its entries, counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OrbitEntry {
    quantity: OrbitQuantity,
    entry: usize,
}

impl OrbitEntry {
    /// The entry of a name: `"period"`, `"phase"`, or with its place `"q0[0]"`, `"v0[0]"`, `"speeds_before[0]"`, `"times[0]"`, `"min_gap[0]"`,
    /// `"max_displacement[0]"`.
    ///
    /// # Errors
    /// A name that there is not, or a place that an orbit does not have.
    pub fn of(name: &str, orbit: &PeriodicOrbit) -> Result<Self> {
        let refused = |rule: String| Err(Error::bad_value("value", format!("'{name}'"), rule));
        let (own, place) = match name.strip_suffix(']').and_then(|own| own.split_once('[')) {
            Some((own, place)) => (own, Some(place)),
            None => (name, None),
        };
        let known = OrbitQuantity::ALL.iter().find(|known| known.1 == own);
        let place = place.map(str::parse::<usize>).transpose();
        let (Some((quantity, _)), Ok(place)) = (known, place) else {
            let all = OrbitQuantity::ALL.map(|known| known.1).join(", ");
            return refused(format!(
                "it must be an entry of {all}, or a callable f(orbit, derivatives)"
            ));
        };
        let count = quantity.of(orbit)?.len();
        match (quantity.is_single(), place) {
            (true, None) => Ok(Self {
                quantity: *quantity,
                entry: 0,
            }),
            (false, Some(entry)) if entry < count => Ok(Self {
                quantity: *quantity,
                entry,
            }),
            (true, Some(_)) => refused(format!("{own} of this orbit is one number")),
            (false, _) => refused(format!(
                "{own} of this orbit is of {count} entries, {own}[0] and so on"
            )),
        }
    }

    /// Its value and its derivatives by each number, shape `(d,)`, \[unit of the entry over that of the number\].
    ///
    /// # Errors
    /// As [`PeriodicOrbit::min_gap`]; an orbit that has not as many entries.
    pub fn value(
        &self,
        orbit: &PeriodicOrbit,
        derivatives: &OrbitDerivatives,
    ) -> Result<(f64, Vec<f64>)> {
        let values = self.quantity.of(orbit)?;
        let Some(value) = values.get(self.entry) else {
            let rule = format!("the orbit has {} entries of it", values.len());
            return Err(Error::bad_value("value", self.entry, rule));
        };
        Ok((*value, self.quantity.derivatives(derivatives, self.entry)))
    }
}

/// The value of an orbit that an optimiser asks for, with its gradient.
#[derive(Clone, Copy)]
pub enum ObjectiveValue<'a> {
    /// An entry of what the orbit has.
    Entry(OrbitEntry),
    /// What a function makes of the orbit and its derivatives.
    Function(&'a dyn Fn(&PeriodicOrbit, &OrbitDerivatives) -> Result<(f64, Vec<f64>)>),
}

/// A value of an orbit and its gradient as a function of numbers of its scene, for an optimiser.
#[derive(Clone)]
pub struct Objective<'a> {
    /// The scene of numbers; that of `p` is the orbit's but for the phase.
    pub make: &'a dyn Fn(&[f64]) -> Result<Scene>,
    /// What is asked of the orbit.
    pub value: ObjectiveValue<'a>,
    /// The orbit at the last numbers that it was found for.
    pub orbit: PeriodicOrbit,
    /// These numbers, shape `(d,)`, \[their own units\].
    pub p: Vec<f64>,
}

impl Objective<'_> {
    /// The value and its gradient at other numbers, to which the orbit is followed. It may break a rule of contact, and the gradient may be
    /// NaN.
    ///
    /// # Errors
    /// As many numbers as there were, finite; `Error::NoConvergence` where the orbit cannot be followed; what `make` says;
    /// `Error::Interrupted` when the observer of the thread breaks off.
    ///
    /// # Examples
    /// ```
    /// use vibroimpact::nalgebra::{dmatrix, dvector};
    /// use vibroimpact::{Harmonic, LinearSystem, Objective, ObjectiveValue, OrbitEntry, OrbitOptions, Pattern, Scene, Stop};
    /// use vibroimpact::periodic_orbits;
    /// let make = |p: &[f64]| {
    ///     let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
    ///     let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0)?;
    ///     Scene::new(system, force, [Stop::new(0, p[0], p[1])?])
    /// };
    /// let orbit = periodic_orbits(&make(&[1.0, 0.8])?, &Pattern::single(0), &OrbitOptions::default())?[0].clone();
    /// let value = ObjectiveValue::Entry(OrbitEntry::of("speeds_before[0]", &orbit)?);
    /// let mut objective = Objective { make: &make, value, orbit, p: vec![1.0, 0.8] };
    /// let (speed, gradient) = objective.at(&[1.1, 0.7])?;
    /// let (farther, _) = objective.at(&[1.1 + 1e-6, 0.7])?;
    /// assert!((gradient[0] - (farther - speed) / 1e-6).abs() < 1e-4);
    /// # Ok::<(), vibroimpact::Error>(())
    /// ```
    pub fn at(&mut self, p: &[f64]) -> Result<(f64, Vec<f64>)> {
        if p.len() != self.p.len() || p.iter().any(|x| !x.is_finite()) {
            let rule = format!("{} finite numbers are needed", self.p.len());
            return Err(Error::bad_value("p", format!("{p:?}"), rule));
        }
        let orbit = follow_orbit(&self.orbit, self.make, (&self.p, p))?;
        let found = match self.value {
            // Which is none of the multipliers.
            ObjectiveValue::Entry(entry) => {
                let derivatives = derivatives_but_multipliers(&orbit, self.make, p)?;
                entry.value(&orbit, &derivatives)?
            }
            ObjectiveValue::Function(value) => {
                let derivatives = derivatives_of(&orbit, self.make, p)?;
                value(&orbit, &derivatives)?
            }
        };
        (self.orbit, self.p) = (orbit, p.to_vec());
        Ok(found)
    }
}

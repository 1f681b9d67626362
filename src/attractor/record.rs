//! An attractor: what motions settle on, by its states at one phase of the forcing, with its orbit where it has one. States are (q, v) in
//! units of the scene, exponents are per unit of time.

use crate::attractor::kind::AttractorKind;
use crate::orbit::{Pattern, PeriodicOrbit};
use nalgebra::DMatrix;

/// An attractor of a scene of n degrees of freedom.
#[derive(Debug, Clone)]
pub struct Attractor {
    /// What it is.
    pub kind: AttractorKind,
    /// The orbit, where there is one; `None` of what does not repeat itself, and of what Newton's method does not close.
    pub orbit: Option<PeriodicOrbit>,
    /// Periods of the forcing in one of its own; zero of what does not repeat itself.
    pub n_periods: usize,
    /// Its states (q, v) at the phase, one period of the forcing after the other, shape `(p, 2n)`, \[units of q and v\]. A cycle has one
    /// for each of its periods, a set a thousand. A motion that repeats itself because it comes to rest on a stop, while rounding decides
    /// where it is in between, has those of a set: a thousand, or one less if that is its period.
    pub points: DMatrix<f64>,
    /// Its Lyapunov exponents, the largest first, shape `(2n,)`, \[1/s\]; empty where it has no multipliers.
    pub exponents: Vec<f64>,
    /// The stops hit in one of its periods; empty where it has none.
    pub pattern: Pattern,
    /// Why it has no orbit; empty where it has.
    pub reason: String,
    /// The part of the starts outside every stop that led to it \[-\].
    pub fraction: f64,
}

impl Attractor {
    /// Whether its points are all that it has, each followed by the next; else they are some of a set.
    pub(crate) fn is_cycle(&self) -> bool {
        self.n_periods > 0 && self.points.nrows() == self.n_periods
    }
}

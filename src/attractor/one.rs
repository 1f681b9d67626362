//! An attractor.

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
    /// Its states (q, v) at the phase, one after the other, of what does not repeat itself a thousand; shape `(p, 2n)`. A thousand, or one
    /// less, too of what comes to rest on a stop once in a period so long that rounding decides where it is in between.
    pub points: DMatrix<f64>,
    /// Its Lyapunov exponents; empty where it has no multipliers.
    pub exponents: Vec<f64>,
    /// The stops hit in one of its periods; empty where it has none.
    pub pattern: Pattern,
    /// Why it has no orbit; empty where it has.
    pub reason: String,
    /// The part of the starts outside every stop that led to it.
    pub fraction: f64,
}

impl Attractor {
    /// Whether its points are all that it has, each followed by the next; else they are some of a set.
    pub(crate) fn is_cycle(&self) -> bool {
        self.n_periods > 0 && self.points.nrows() == self.n_periods
    }
}

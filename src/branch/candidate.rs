//! A candidate of branch switching.

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::error::Result;
use crate::orbit::PeriodicOrbit;

/// An orbit near a special point of a branch, on another branch that meets it there. Followed by
/// [`continuation`](fn@crate::continuation) a factor counts from the scene of this orbit, one there.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The orbit.
    pub orbit: PeriodicOrbit,
    /// The number of the branch at it.
    pub parameter: f64,
    /// Whether that is above the special point's; else it is below.
    pub is_above: bool,
}

impl Candidate {
    /// The orbit of a loop that closes, at a value that differs from that of a special point.
    pub(super) fn at(
        problem: &BranchProblem<'_>,
        place: &ParametricLoop,
        special: f64,
    ) -> Result<Self> {
        Ok(Self {
            orbit: problem.orbit(place)?,
            parameter: place.value,
            is_above: place.value > special,
        })
    }
}

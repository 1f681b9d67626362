//! An orbit of another branch.

use crate::orbit::PeriodicOrbit;

/// An orbit near a special point of a branch, on another branch that meets it there; followed by [`continuation`](crate::continuation) a factor
/// counts from the scene of this orbit, one there.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The orbit.
    pub orbit: PeriodicOrbit,
    /// The number of the branch at it.
    pub parameter: f64,
    /// Whether that is above the special point; else below.
    pub is_above: bool,
}

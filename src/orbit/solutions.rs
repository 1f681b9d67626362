//! What a solver found of a periodic problem: the parts of each orbit, and what is to be said of all.

use crate::orbit::orbit_data::OrbitData;
use nalgebra::DMatrix;

/// The solutions of a problem.
pub(crate) struct Solutions {
    pub all: Vec<OrbitData>,
    /// What was found, or why nothing, in words.
    pub reason: String,
    /// How far the parameters are from the fold at which solutions meet.
    pub margin: Option<f64>,
    /// Where the solutions are of a family: the directions of the contact state (q, v) in which each may be moved, shape (2n, dimension), [m,
    /// m/s].
    pub family: Option<DMatrix<f64>>,
}

//! The derivatives of an orbit as a result.

use nalgebra::{Complex, DMatrix, DVector};

/// Derivatives of an orbit of n degrees of freedom, with k impacts in a period, by d numbers of its scene.
///
/// t = 0 is right after the first impact, wherever in time that is; not a number where one does not exist, with the reason.
#[derive(Debug, Clone)]
pub struct Derivatives {
    /// Of the position right after the first impact, shape `(n, d)`.
    pub q0: DMatrix<f64>,
    /// Of the velocity there, shape `(n, d)`.
    pub v0: DMatrix<f64>,
    /// Of the phase of the forcing there, shape `(d,)`; zero without forcing.
    pub phase: DVector<f64>,
    /// Of the period, shape `(d,)`.
    pub period: DVector<f64>,
    /// Of the speeds at which stops are approached, in the order of the impacts, shape `(k, d)`.
    pub speeds_before: DMatrix<f64>,
    /// Of the times of the impacts, shape `(k, d)`.
    pub times: DMatrix<f64>,
    /// Of the Floquet multipliers, in their order, shape `(2n, d)`.
    pub multipliers: DMatrix<Complex<f64>>,
    /// Of the least gap of every stop, shape `(stops, d)`; zero where it is that of an impact.
    pub min_gap: DMatrix<f64>,
    /// Of the largest distance of every coordinate from zero, shape `(n, d)`.
    pub max_displacement: DMatrix<f64>,
    /// Why some do not exist, in words; empty where all do.
    pub reason: String,
}

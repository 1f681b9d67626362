//! The derivatives of an orbit as a result.

use nalgebra::{Complex, DMatrix, DVector};

/// Derivatives of an orbit of n degrees of freedom, with k impacts in a period, by d numbers of its scene.
///
/// t = 0 is right after the first impact, wherever in time that is; not a number where one does not exist, with the reason.
#[derive(Debug, Clone)]
pub struct OrbitDerivatives {
    /// Of the position right after the first impact, shape `(n, d)`, \[m\] per unit of each number.
    pub q0: DMatrix<f64>,
    /// Of the velocity there, shape `(n, d)`, [m/s] per unit of each number.
    pub v0: DMatrix<f64>,
    /// Of the phase of the forcing there, shape `(d,)`, \[rad\] per unit of each number; zero without forcing.
    pub phase: DVector<f64>,
    /// Of the period, shape `(d,)`, \[s\] per unit of each number.
    pub period: DVector<f64>,
    /// Of the speeds at which stops are approached, in the order of the impacts, shape `(k, d)`, [m/s] per unit of each number.
    pub speeds_before: DMatrix<f64>,
    /// Of the times of the impacts, shape `(k, d)`, \[s\] per unit of each number.
    pub times: DMatrix<f64>,
    /// Of the Floquet multipliers, in their order, shape `(2n, d)`, [-] per unit of each number.
    pub multipliers: DMatrix<Complex<f64>>,
    /// Of the least gap of every stop, shape `(stops, d)`, \[m\] per unit of each number; zero where it is that of an impact.
    pub min_gap: DMatrix<f64>,
    /// Of the largest distance of every coordinate from zero, shape `(n, d)`, \[m\] per unit of each number.
    pub max_displacement: DMatrix<f64>,
    /// Why some do not exist, in words; empty where all do.
    pub reason: String,
}

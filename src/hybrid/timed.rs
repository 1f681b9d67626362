//! A state with its time, and first deviations of both.

use nalgebra::{DMatrix, DVector};

/// A state, its time, and deviations of both: columns `(dx, dt)`, the time's apart.
#[derive(Debug, Clone)]
pub(crate) struct Timed {
    pub time: f64,
    pub state: DVector<f64>,
    pub deviations: DMatrix<f64>,
    /// One for each deviation.
    pub delays: DVector<f64>,
}

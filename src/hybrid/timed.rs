//! A state with its time, and first deviations of both.

use nalgebra::{DMatrix, DVector};

/// A state, its time, and deviations of both: columns `(dx, dt)`, the time's apart.
#[derive(Debug, Clone)]
pub(crate) struct Timed {
    pub time: f64,
    /// The state `(q, v)`, shape `(2 n_dof,)`, \[m\] and \[m/s\].
    pub state: DVector<f64>,
    /// Deviations of the state, one in each column, shape `(2 n_dof, n_deviations)`, \[m\] and \[m/s\] per unit of what deviates.
    pub deviations: DMatrix<f64>,
    /// Deviations of the time, one for each column, shape `(n_deviations,)`, \[s\] per unit of what deviates.
    pub delays: DVector<f64>,
}

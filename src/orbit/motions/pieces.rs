//! What a periodic motion is pieced together from: smooth motion and impacts, as shooting and stability see them.

use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// Smooth motion and impacts of one scene. A state is `(q, v)`; deviations are columns of such.
pub(crate) trait Motion {
    /// Carries a state from one time to another while some stops are held, and multiplies deviations by the Jacobian of the
    /// flow; a state is first brought onto the stops held.
    fn fly(
        &self,
        held: &[usize],
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()>;
    /// The rate of change of a state while some stops are held.
    fn rate(&self, held: &[usize], t: f64, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// Applies the impacts of the stops hit together at a fixed time, and returns their impulses.
    fn collide(
        &self,
        stops: &[usize],
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>>;
    /// The gap of a stop and its gradient in q, shape `(n,)`.
    fn gap(&self, stop: usize, state: &DVector<f64>) -> Result<(f64, DVector<f64>)>;
    /// The second time derivative of a gap where the state changes at a rate.
    fn acceleration(&self, stop: usize, state: &DVector<f64>, rate: &DVector<f64>) -> Result<f64>;
    /// The reaction direction of a stop, shape `(n,)`.
    fn reaction(&self, stop: usize, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// The restitution coefficient of a stop.
    fn restitution(&self, stop: usize) -> f64;
}

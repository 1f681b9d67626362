//! A hybrid system as maps of a state with their Jacobians: what a periodic motion is pieced together from, as shooting and
//! stability see it.

use crate::error::Result;
use crate::impact::{StopsAt, project};
use nalgebra::{DMatrix, DVector};

/// The maps of a scene. A state is `(q, v)`; deviations are columns of such.
pub(crate) trait HybridMaps {
    /// Carries a state from one time to another while some stops are held, and multiplies deviations by the Jacobian of the
    /// flow; a state is first brought onto the stops held.
    fn flow(
        &self,
        held: &[usize],
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()>;
    /// The rate of change of a state while some stops are held.
    fn rate(&self, held: &[usize], t: f64, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// Applies the impacts of the stops hit together at a fixed time, and returns their impulses.
    fn impact(
        &self,
        stops: &[usize],
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>>;
    /// The gap of a stop and its gradient in q, shape `(n,)`.
    fn gap(&self, stop: usize, state: &DVector<f64>) -> Result<(f64, DVector<f64>)>;
    /// The second time derivative of a gap where the state changes at a rate.
    fn gap_acceleration(
        &self,
        stop: usize,
        state: &DVector<f64>,
        rate: &DVector<f64>,
    ) -> Result<f64>;
    /// The reaction direction of a stop, shape `(n,)`.
    fn reaction(&self, stop: usize, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// The restitution coefficient of a stop.
    fn restitution(&self, stop: usize) -> f64;
}

/// Moves a state onto some stops, along their reactions, and takes its normal speeds away.
pub(crate) fn project_onto<M: HybridMaps>(
    maps: &M,
    stops: &[usize],
    state: &mut DVector<f64>,
) -> Result<()> {
    if stops.is_empty() {
        return Ok(());
    }
    let n = state.len() / 2;
    let (mut q, mut v) = (state.rows(0, n).into_owned(), state.rows(n, n).into_owned());
    project(&mut q, &mut v, |q| {
        let mut there = state.clone();
        there.rows_mut(0, n).copy_from(q);
        let (mut gaps, mut normals, mut reactions) = (Vec::new(), Vec::new(), Vec::new());
        for &stop in stops {
            let (gap, gradient) = maps.gap(stop, &there)?;
            gaps.push(gap);
            normals.push(-gradient);
            reactions.push(maps.reaction(stop, &there)?);
        }
        Ok(StopsAt {
            speeds: DVector::zeros(gaps.len()),
            gaps: DVector::from_vec(gaps),
            normals,
            reactions,
        })
    })?;
    state.rows_mut(0, n).copy_from(&q);
    state.rows_mut(n, n).copy_from(&v);
    Ok(())
}

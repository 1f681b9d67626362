//! A hybrid system as maps of a state with their Jacobians: what a periodic motion is pieced together from, as shooting and
//! stability see it.

use crate::error::Result;
use crate::impact::{StopsAt, project};
use crate::law::{Law, Newton, Regime};
use crate::model::PhysicalState;
use crate::tolerance::ORBIT_CLOSED;
use nalgebra::{DMatrix, DVector, DVectorView};

/// A gap at a time and a position.
pub(crate) struct GapAt {
    pub gap: f64,
    /// Its gradient in q, minus the normal of the stop, shape `(n_dof,)`, [-].
    pub gradient: DVector<f64>,
    /// Its derivative by time: the speed of a stop that moves.
    pub slope: f64,
}

impl GapAt {
    /// The speed at which it opens, from the velocity.
    pub fn speed(&self, velocity: DVectorView<'_, f64>) -> f64 {
        let along = self.gradient.dot(&velocity);
        if self.slope == 0.0 {
            along
        } else {
            along + self.slope
        }
    }

    /// Its first-order deviations, from those of the state.
    pub fn deviations(&self, deviations: &DMatrix<f64>) -> DVector<f64> {
        let n = self.gradient.len();
        deviations.rows(0, n).tr_mul(&self.gradient)
    }

    /// The same from deviations of the state and of the time.
    pub fn timed_deviations(
        &self,
        deviations: &DMatrix<f64>,
        delays: &DVector<f64>,
    ) -> DVector<f64> {
        let along = self.deviations(deviations);
        if self.slope == 0.0 {
            along
        } else {
            along + delays * self.slope
        }
    }
}

/// The times \[s\] at which a signal passes from one polynomial to the next, ascending: flights stop at them.
#[derive(Debug, Clone)]
pub(crate) struct Breaks(pub Vec<f64>);

impl Breaks {
    /// The parts between breaks of a span of time, which may be of no length.
    pub fn parts(&self, (start, end): (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
        let first = self.0.partition_point(|t| *t <= start);
        let count = self.0[first..].partition_point(|t| *t < end);
        let within = self.0[first..first + count].iter().copied();
        let mut from = start;
        within
            .chain([end])
            .map(move |to| (std::mem::replace(&mut from, to), to))
    }
}

/// The maps of a scene. A state is `(q, v)`; deviations are columns of such.
pub(crate) trait HybridMaps {
    /// Carries a state from one time to another in a regime, and multiplies deviations by the Jacobian of the flow; a state is first
    /// brought to where the regime keeps it.
    fn flow(
        &self,
        regime: &Regime,
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()>;
    /// The same, with the Jacobian where it is made on the way.
    fn flow_by_jacobian(
        &self,
        regime: &Regime,
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Option<DMatrix<f64>>> {
        self.flow(regime, span, state, deviations)?;
        Ok(None)
    }
    /// The largest scaled mismatch of what counts as closed.
    fn closes_to(&self) -> f64 {
        ORBIT_CLOSED
    }
    /// The rate of change of a state in a regime.
    fn rate(&self, regime: &Regime, t: f64, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// Applies the impacts of the stops hit together at a fixed time, and returns their impulses.
    fn impact(
        &self,
        stops: &[usize],
        t: f64,
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>>;
    /// The velocity that the impacts of stops hit together take away at some approach speeds, `B (N^T B)^-1 (I + E) s`.
    fn kick(&self, stops: &[usize], state: &DVector<f64>, s: DVector<f64>) -> Result<DVector<f64>>;
    /// The derivative of the state after those impacts by their time, for a fixed state before; `None` where the stops rest.
    fn recoil(
        &self,
        stops: &[usize],
        t: f64,
        state: &DVector<f64>,
    ) -> Result<Option<DVector<f64>>> {
        let bends = stops.iter().map(|&stop| self.stop_motion(stop, t)[2]);
        let bends = DVector::from_iterator(stops.len(), bends);
        if bends.iter().all(|bend| *bend == 0.0) {
            return Ok(None);
        }
        let (n, mut rate) = (state.len() / 2, DVector::zeros(state.len()));
        rate.rows_mut(n, n)
            .copy_from(&self.kick(stops, state, bends)?);
        Ok(Some(rate))
    }
    /// What the own motion of a stop adds to its gap, with speed and acceleration.
    fn stop_motion(&self, stop: usize, t: f64) -> [f64; 3];
    /// The gap of a stop.
    fn gap(&self, stop: usize, t: f64, state: &DVector<f64>) -> Result<GapAt>;
    /// The second time derivative of a gap where the state changes at a rate.
    fn gap_acceleration(
        &self,
        stop: usize,
        t: f64,
        state: &DVector<f64>,
        rate: &DVector<f64>,
    ) -> Result<f64>;
    /// The reaction direction of a stop, shape `(n,)`.
    fn reaction(&self, stop: usize, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// The law of impact of a stop.
    fn law(&self, stop: usize) -> Newton;
    /// The law of contact of an element.
    fn contact_law(&self, element: usize) -> &Law;
}

/// The state to which another one is carried in a regime over a span of time.
pub(crate) fn carried<M: HybridMaps + ?Sized>(
    maps: &M,
    regime: &Regime,
    span: (f64, f64),
    state: &DVector<f64>,
) -> Result<DVector<f64>> {
    let (mut state, none) = (state.clone(), &mut DMatrix::zeros(state.len(), 0));
    maps.flow(regime, span, &mut state, none)?;
    Ok(state)
}

/// Moves a state at a time to where a regime keeps it: onto the stops that it holds, along their reactions, without normal speeds relative
/// to them.
pub(crate) fn project_onto<M: HybridMaps + ?Sized>(
    maps: &M,
    regime: &Regime,
    t: f64,
    state: &mut DVector<f64>,
) -> Result<()> {
    if regime.constrained().is_empty() {
        return Ok(());
    }
    let n = state.len() / 2;
    let (mut q, mut v) = halves(state);
    project(&mut q, &mut v, |q| {
        state.rows_mut(0, n).copy_from(q);
        let (mut gaps, mut speeds) = (Vec::new(), Vec::new());
        let (mut normals, mut reactions) = (Vec::new(), Vec::new());
        for &stop in regime.constrained() {
            let at = maps.gap(stop, t, state)?;
            gaps.push(at.gap);
            speeds.push(at.slope);
            normals.push(-at.gradient);
            reactions.push(maps.reaction(stop, state)?);
        }
        Ok(StopsAt {
            gaps: DVector::from_vec(gaps),
            speeds: DVector::from_vec(speeds),
            normals,
            reactions,
        })
    })?;
    state.rows_mut(0, n).copy_from(&q);
    state.rows_mut(n, n).copy_from(&v);
    Ok(())
}

/// Position and velocity of a state.
pub(crate) fn halves(state: &DVector<f64>) -> PhysicalState {
    let n = state.len() / 2;
    (state.rows(0, n).into_owned(), state.rows(n, n).into_owned())
}

/// Position and velocity as one state.
pub(crate) fn joined((q, v): &PhysicalState) -> DVector<f64> {
    DVector::from_iterator(2 * q.len(), q.iter().chain(v.iter()).copied())
}

//! What becomes of first deviations where stops come to be held (theory 9, 16): the directions that would leave the stops are projected away, along their reactions.

use crate::error::Result;
use crate::hybrid::maps::{HybridMaps, project_onto};
use crate::hybrid::timed::Timed;
use crate::law::Regime;
use crate::linalg::rank::pseudo_inverse;
use crate::tolerance::{CENTRAL_DIFFERENCE_STEP, DEPENDENT};
use nalgebra::{DMatrix, DVector};

/// The linearised gaps and gap speeds of some stops, and the projection of deviations onto those that keep them at zero.
pub(crate) struct Landing {
    /// Derivatives `C` of the gaps and of their speeds by (q, v).
    rows: DMatrix<f64>,
    /// Derivatives of the gaps and of their speeds by time.
    slopes: DVector<f64>,
    /// `K (C K)^+`, K the reactions on positions and on velocities.
    taken: DMatrix<f64>,
}

impl Landing {
    /// The projection at a state on what a regime holds.
    pub fn new<M: HybridMaps + ?Sized>(
        maps: &M,
        regime: &Regime,
        t: f64,
        state: &DVector<f64>,
    ) -> Result<Self> {
        let stops = regime.constrained();
        let (count, n) = (stops.len(), state.len() / 2);
        let mut rows = DMatrix::zeros(2 * count, 2 * n);
        let mut reactions = DMatrix::zeros(2 * n, 2 * count);
        let mut slopes = DVector::zeros(2 * count);
        let mut at_rest = state.clone();
        at_rest.rows_mut(n, n).fill(0.0);
        let still = DVector::zeros(2 * n);
        for (k, &stop) in stops.iter().enumerate() {
            let at = maps.gap(stop, t, state)?;
            let reaction = maps.reaction(stop, state)?;
            let reach = state.rows(0, n).amax();
            let step = CENTRAL_DIFFERENCE_STEP * if reach > 0.0 { reach } else { 1.0 };
            for j in 0..n {
                let speed = |step: f64| -> Result<f64> {
                    let mut there = state.clone();
                    there[j] += step;
                    Ok(maps.gap(stop, t, &there)?.gradient.dot(&state.rows(n, n)))
                };
                rows[(count + k, j)] = (speed(step)? - speed(-step)?) / (2.0 * step);
                rows[(k, j)] = at.gradient[j];
                rows[(count + k, n + j)] = at.gradient[j];
                reactions[(j, k)] = reaction[j];
                reactions[(n + j, count + k)] = reaction[j];
            }
            slopes[k] = at.slope;
            slopes[count + k] = maps.gap_acceleration(stop, t, &at_rest, &still)?;
        }
        let give = &rows * &reactions;
        let inverse = pseudo_inverse(&give, DEPENDENT * give.amax())?;
        Ok(Self {
            rows,
            slopes,
            taken: reactions * inverse,
        })
    }

    /// The number of directions of the state space that the projection takes away [-].
    pub fn n_lost_directions(&self) -> usize {
        (&self.rows * &self.taken).trace().round() as usize
    }

    /// Projects deviations at a fixed time.
    pub fn take(&self, deviations: &mut DMatrix<f64>) {
        let left = &self.rows * &*deviations;
        *deviations -= &self.taken * left;
    }

    /// Projects deviations of a state whose time deviates as well.
    pub fn take_timed(&self, deviations: &mut DMatrix<f64>, delays: &DVector<f64>) {
        let left = &self.rows * &*deviations + &self.slopes * delays.transpose();
        *deviations -= &self.taken * left;
    }
}

/// Brings a state to where the regime from its time on keeps it, and deviations from it.
pub(crate) fn land<M: HybridMaps + ?Sized>(maps: &M, regime: &Regime, y: &mut Timed) -> Result<()> {
    if regime.constrained().is_empty() {
        return Ok(());
    }
    project_onto(maps, regime, y.time, &mut y.state)?;
    if y.deviations.ncols() > 0 {
        let landing = Landing::new(maps, regime, y.time, &y.state)?;
        landing.take_timed(&mut y.deviations, &y.delays);
    }
    Ok(())
}

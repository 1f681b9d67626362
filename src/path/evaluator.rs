//! Evaluates an arc that was kept from its numbers: modal pairs, dense output or Taylor coefficients.

use crate::flow::steps::dense_output::{written_state, written_width};
use crate::flow::{
    ModalScene, RegimeMotion, SceneFlow, propagate, read_series, series_width, with_flow,
};
use crate::hybrid::clock::Clock;
use crate::law::Regime;
use crate::modal::ModalState;
use crate::model::PhysicalState;
use nalgebra::DVector;
use std::sync::Arc;

/// How the numbers of an arc give the motion along it.
#[derive(Debug, Clone)]
pub(crate) enum Evaluator {
    /// Exact flights: the numbers are the modal pairs at the start of the arc.
    Exact {
        modal: Arc<ModalScene>,
        flow: Arc<SceneFlow>,
        /// The motions in regimes that are not free.
        regimes: Vec<Arc<RegimeMotion>>,
        /// The forcing phase at time zero, where the modes do not have it.
        phase: f64,
    },
    /// Steps: the numbers are the step's length and its dense output, polynomials of a degree.
    Steps { degree: usize },
    /// Taylor series of the velocities to an order: the numbers are the unit of time and the coefficients of the positions
    /// in it, one after the other for each, in free motion; in other regimes Runge-Kutta steps.
    Series { order: usize },
}

/// Degree of the dense output of the Runge-Kutta steps that stand beside Taylor series. [exact]
const QUARTIC: usize = 4;

impl Evaluator {
    /// The same with the motions in regimes that a run has met.
    pub fn with_regimes(mut self, all: &[Arc<RegimeMotion>]) -> Self {
        if let Self::Exact { regimes, .. } = &mut self {
            *regimes = all.to_vec();
        }
        self
    }

    /// How many numbers an arc in a regime has for n degrees of freedom.
    #[inline]
    pub fn width(&self, regime: &Regime, n: usize) -> usize {
        match self {
            Self::Exact { .. } => 2 * n,
            Self::Series { order } if regime.is_free() => series_width(*order, n),
            Self::Steps { degree } => written_width(*degree, n),
            Self::Series { .. } => written_width(QUARTIC, n),
        }
    }

    /// Position and velocity a time after the start of an arc in a regime.
    #[inline]
    pub fn state(
        &self,
        regime: &Regime,
        clock: Clock,
        numbers: &[f64],
        local: f64,
    ) -> PhysicalState {
        match self {
            Self::Exact {
                modal,
                flow,
                regimes,
                phase,
            } => {
                let mut state: ModalState = numbers.chunks(2).map(|z| [z[0], z[1]]).collect();
                let at = clock.moment(*phase);
                let is_its = |own: &&Arc<RegimeMotion>| own.regime == *regime;
                if let Some(own) = regimes.iter().find(is_its) {
                    let (q, v) = modal.form.to_physical(&state);
                    return own.propagate(at, local, &q, &v);
                }
                with_flow!(&**flow, f => propagate(f, at, local, &mut state));
                modal.form.to_physical(&state)
            }
            Self::Series { order } if regime.is_free() => read_series(numbers, *order, local),
            Self::Steps { degree } => parted(&written_state(numbers, *degree, local)),
            Self::Series { .. } => parted(&written_state(numbers, QUARTIC, local)),
        }
    }
}

/// Position and velocity of a state.
fn parted(x: &[f64]) -> PhysicalState {
    let (q, v) = x.split_at(x.len() / 2);
    (DVector::from_column_slice(q), DVector::from_column_slice(v))
}

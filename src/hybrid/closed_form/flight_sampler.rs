//! The buffers in which states of a free flight are evaluated.

use crate::flow::{LinearFlow, PropagatorCache};
use crate::modal::{ModalState, Pair};
use crate::model::PhysicalState;
use nalgebra::DVector;

/// Buffers and a propagator for states along free flights, kept from one evaluation to the next.
pub(super) struct FlightSampler<F: LinearFlow> {
    pub state: Vec<Pair>,
    pub modal_state: ModalState,
    pub physical: PhysicalState,
    /// The propagator from one sample to the next.
    pub propagator_cache: PropagatorCache<F>,
}

impl<F: LinearFlow> FlightSampler<F> {
    /// Those at a motion of n coordinates.
    pub fn new(n: usize) -> Self {
        Self {
            state: Vec::new(),
            modal_state: ModalState::default(),
            physical: (DVector::zeros(n), DVector::zeros(n)),
            propagator_cache: PropagatorCache::default(),
        }
    }
}

//! The room in which a free flight is looked at, again and again.

use crate::flow::{Carrier, LinearFlow};
use crate::modal::{ModalState, Pair};
use crate::model::PhysicalState;
use nalgebra::DVector;

/// What looks at free flights are made with, kept from one to the next.
pub(super) struct FreeLooks<F: LinearFlow> {
    pub state: Vec<Pair>,
    pub modal_state: ModalState,
    pub physical: PhysicalState,
    /// From look to look.
    pub carrier: Carrier<F>,
}

impl<F: LinearFlow> FreeLooks<F> {
    /// Those at a motion of n coordinates.
    pub fn new(n: usize) -> Self {
        Self {
            state: Vec::new(),
            modal_state: ModalState::default(),
            physical: (DVector::zeros(n), DVector::zeros(n)),
            carrier: Carrier::default(),
        }
    }
}

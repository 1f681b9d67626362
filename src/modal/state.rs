//! The state of a motion in modal coordinates.

use crate::linalg::plane::Pair;

/// A pair of numbers for each block of the modal form: a flow moves a state of its own, which it makes of this.
pub(crate) type ModalState = Vec<Pair>;

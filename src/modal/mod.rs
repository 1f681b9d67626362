//! Modal transformation (theory 4): a linear system as uncoupled blocks of two first-order equations, or, where no such
//! form is well conditioned, as one dense block.

mod block;
mod complex;
mod form;
mod modes;
mod real;

pub(crate) use crate::linalg::plane::{Pair, times};
pub(crate) use block::{Block, Propagation, Response};
pub(crate) use form::{Form, ModalForm};
pub use modes::{Modes, modes};

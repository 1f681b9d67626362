//! Modal transformation (theory 4): a linear system as uncoupled blocks of two first-order equations, or, where no such
//! form is well conditioned, as one dense block.

mod block;
mod complex;
mod form;
mod modes;
mod oscillator_roots;
mod propagation;
mod ramped;
mod real;
mod regime_modes;
mod state;

pub(crate) use crate::linalg::plane::{Pair, times};
pub(crate) use block::{Block, Response};
pub(crate) use complex::check_range;
pub(crate) use form::{Form, ModalForm, pairs, rate_bound};
pub use modes::{Modes, Spectrum, modes, spectrum};
pub(crate) use propagation::Propagation;
pub use regime_modes::{modes_in, spectrum_in};
pub(crate) use state::ModalState;

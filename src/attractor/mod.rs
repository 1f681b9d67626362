//! What the motions of a scene settle on (theory 17).

mod at_phase;
mod attractors;
mod finding;
mod gathering;
mod kind;
mod one;
mod options;
mod rests;
mod state_box;
mod unsettled;

pub(crate) use at_phase::{points_at, quiet_phase};
pub use attractors::{Attractors, find_attractors};
#[cfg(feature = "python")]
pub(crate) use attractors::{gathered_seeds, settle_seeds};
#[cfg(feature = "python")]
pub(crate) use finding::Found;
pub use kind::AttractorKind;
pub use one::Attractor;
pub use options::AttractorOptions;
pub use state_box::StateBox;

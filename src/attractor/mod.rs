//! What the motions of a scene settle on (theory 17).

mod at_phase;
mod attractors;
mod finding;
mod gathering;
mod kind;
mod list;
mod one;
mod options;
mod rests;
mod state_box;
mod unsettled;

pub(crate) use at_phase::{points_at, quiet_phase};
pub use attractors::find_attractors;
#[cfg(feature = "python")]
pub(crate) use attractors::{gathered_seeds, settle_seeds};
#[cfg(feature = "python")]
pub(crate) use finding::Found;
pub use kind::AttractorKind;
pub use list::Attractors;
pub use one::Attractor;
pub use options::AttractorOptions;
pub use state_box::StateBox;

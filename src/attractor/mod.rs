//! What the motions of a scene settle on (theory 17).

mod attractors;
mod finding;
mod kind;
mod one;
mod options;
mod same;
mod state_box;
mod unsettled;

#[cfg(feature = "python")]
pub(crate) use attractors::settle_seeds;
pub use attractors::{Attractors, find_attractors};
#[cfg(feature = "python")]
pub(crate) use finding::Found;
pub use kind::AttractorKind;
pub use one::Attractor;
pub use options::AttractorOptions;
#[cfg(feature = "python")]
pub(crate) use same::groups;
pub(crate) use same::spacing;
pub use state_box::StateBox;

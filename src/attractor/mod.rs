//! What the motions of a scene settle on (theory 17).

mod attractors;
mod finding;
mod kind;
mod same;

#[cfg(feature = "python")]
pub(crate) use attractors::settle_seeds;
pub use attractors::{Attractor, AttractorOptions, Attractors, StateBox, find_attractors};
#[cfg(feature = "python")]
pub(crate) use finding::Found;
pub use kind::AttractorKind;
#[cfg(feature = "python")]
pub(crate) use same::groups;
pub(crate) use same::spacing;

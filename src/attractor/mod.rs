//! Attractors: what the motions of a scene with a period of the forcing settle on, found from many starts in a box of states. Unknown are
//! the states (q, v), in units of the scene, at one phase of the forcing \[rad\]; distances are parts of the box. `finding.rs` follows one
//! motion, `unsettled.rs` and `rests.rs` classify those without a short period, `same_attractor.rs` says which are one, `gathering.rs`
//! makes the list. Source: docs/theory.md, section 17.

mod at_phase;
mod attractors;
mod finding;
mod gathering;
mod kind;
mod list;
mod options;
mod record;
mod rests;
mod same_attractor;
mod state_box;
mod unsettled;

pub(crate) use at_phase::{orbit_points, points_at, quiet_phase};
pub use attractors::find_attractors;
#[cfg(feature = "python")]
pub(crate) use attractors::{gathered_seeds, settle_seeds};
#[cfg(feature = "python")]
pub(crate) use finding::SeedOutcome;
pub use kind::AttractorKind;
pub use list::Attractors;
pub use options::AttractorOptions;
pub use record::Attractor;
pub(crate) use same_attractor::are_one;
pub use state_box::StateBox;

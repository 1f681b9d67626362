//! Motions that are kept, and what is had of them: states on both sides of an instant, segments, samples, the energy ledger.

mod drawing;
mod energy;
mod evaluator;
mod fading;
mod parts;
#[allow(clippy::module_inception, reason = "the type that the folder is about")]
mod path;
mod segments;

pub(crate) use drawing::Point;
pub use drawing::Samples;
pub use energy::Energy;
pub(crate) use energy::energy_along;
pub(crate) use evaluator::Evaluator;
pub(crate) use parts::{PathArc, PathParts, PathSegment};
pub(crate) use path::Path;
pub use segments::{ImpactSide, Segment};

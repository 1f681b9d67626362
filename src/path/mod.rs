//! Motions that are kept, and what is had of them: states on both sides of an instant, segments, samples, accelerations, contact
//! forces, impulses, the energy ledger.

mod consistent;
mod drawing;
mod energy;
mod equations;
mod evaluator;
mod fading;
mod fast_forces;
mod impulses;
mod outputs;
mod parts;
#[allow(clippy::module_inception, reason = "the type that the folder is about")]
mod path;
mod quadrature;
mod segments;

pub(crate) use consistent::{ORBIT, check_motion};
pub use drawing::Samples;
pub use energy::Energy;
pub(crate) use energy::energy_along;
pub(crate) use evaluator::Evaluator;
pub(crate) use impulses::{Impulses, Window, check_order};
pub(crate) use outputs::{Component, Located, accelerations, check_stop, contact_forces, gaps};
pub(crate) use parts::{PathArc, PathParts, PathPoint, PathSegment};
pub(crate) use path::{Path, check_time};
pub(crate) use segments::Stretch;
pub use segments::{ImpactSide, Segment};

//! Motions that are kept, and what is had of them: states on both sides of an instant, segments, samples, accelerations, contact
//! forces, impulses, the energy ledger.

mod chapter;
mod consistent;
mod contacts;
mod drawing;
mod energy;
mod equations;
mod evaluator;
mod fading;
mod fast_forces;
mod impulses;
mod motion;
mod outputs;
mod parts;
#[allow(clippy::module_inception, reason = "the type that the folder is about")]
mod path;
mod quadrature;
mod segments;

pub(crate) use chapter::PathChapter;
pub(crate) use consistent::{ORBIT, check_motion};
pub use contacts::ContactRecord;
pub use drawing::Samples;
pub(crate) use drawing::joined;
pub use energy::Energy;
pub(crate) use evaluator::Evaluator;
pub(crate) use impulses::{Window, check_order};
pub(crate) use motion::KeptMotion;
pub use motion::Motion;
pub(crate) use outputs::Located;
pub(crate) use parts::{AccumulationStart, PathArc, PathParts, PathPoint, PathSegment};
pub(crate) use path::{Path, check_time};
pub(crate) use segments::Stretch;
pub use segments::{ImpactSide, RegimeRow, Segment};

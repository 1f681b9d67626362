//! From a scene to a trajectory: flights, contacts, impacts (theory 8, 9).

mod clock;
mod event_loop;
mod options;
mod plan;
mod saved;
mod trajectory;

pub(crate) use event_loop::Run;
pub use event_loop::{simulate, simulate_checked};
pub use options::{Keep, Method, SimulateOptions, Stats, Status};
pub use plan::plan;
pub use saved::SavedTrajectory;
pub use trajectory::{Graze, Samples, Segment, SegmentKind, Side as ImpactSide, Trajectory};

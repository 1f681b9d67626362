//! From a scene to a trajectory: flights, contacts, impacts (theory 8, 9).

mod batch;
mod event_loop;
pub(crate) mod method;
mod options;
mod plan;
mod record;
mod restore;
mod run;
mod saved;
mod saved_rules;
mod trajectory;

pub use crate::hybrid::{Graze, SegmentKind};
pub use crate::path::{Energy, ImpactSide, Samples, Segment};
pub(crate) use batch::Batch;
pub use method::Method;
pub(crate) use method::{with_state, with_steps};
pub use options::{Keep, SimulateOptions, Stats, Status};
pub use plan::plan;
pub(crate) use run::{Done, Run, with_series};
pub use run::{simulate, simulate_observed};
pub use saved::SavedTrajectory;
pub use trajectory::Trajectory;

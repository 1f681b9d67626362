//! From a scene to a trajectory: flights, contacts, impacts (theory 8, 9).

#[cfg(test)]
mod another_law;
mod batch;
mod by_method;
mod chapters;
mod contact_parts;
mod event_loop;
mod gathered;
mod kept;
mod kept_motion;
pub(crate) mod method;
mod monitor;
mod motion_state;
mod on_stops;
mod options;
mod pieces;
mod plan;
mod record;
mod restore;
mod run;
mod saved;
mod saved_mechanics;
mod saved_rules;
mod schedule;
mod simulation;
mod solver;
mod trajectory;

pub use crate::hybrid::{Graze, SegmentKind};
pub use crate::path::{ContactRecord, Energy, ImpactSide, Motion, RegimeRow, Samples, Segment};
pub(crate) use batch::Batch;
pub(crate) use by_method::{RunMaker, RunVisitor, SeriesRun, visit_runs};
pub(crate) use event_loop::Ending;
pub(crate) use gathered::whole_run;
pub use method::Method;
pub(crate) use monitor::RunMonitor;
pub use motion_state::MotionState;
pub(crate) use on_stops::put_onto;
pub use options::{Keep, SimulateOptions, Stats, Status};
pub(crate) use pieces::RunPiece;
pub use plan::{plan, plan_under};
pub(crate) use run::{AnyRun, Done};
pub use saved::{SavedLeft, SavedTrajectory};
pub use simulation::{simulate, simulate_from};
pub use solver::Solver;
pub use trajectory::Trajectory;

//! From a scene to a trajectory: flights, contacts, impacts (theory 8, 9).

mod abreast;
mod clock;
mod energy;
mod event_loop;
mod exact;
mod fading;
mod held;
mod kept;
mod mover;
mod options;
mod plan;
mod record;
mod restore;
mod run;
mod saved;
mod saved_rules;
mod stepping;
mod trajectory;

pub(crate) use abreast::Batch;
pub use energy::Energy;
pub(crate) use event_loop::RATIO_TOL;
pub(crate) use held::HeldMotion;
pub use kept::SegmentKind;
pub(crate) use mover::Looped;
pub use options::{Keep, Method, SimulateOptions, Stats, Status};
pub use plan::plan;
pub(crate) use run::{Done, Run, choose, with_series, with_state, with_steps};
pub use run::{simulate, simulate_checked};
pub use saved::SavedTrajectory;
pub(crate) use stepping::{Pendulum, StepMover, Taylor};
pub use trajectory::{Graze, ImpactSide, Samples, Segment, Trajectory};

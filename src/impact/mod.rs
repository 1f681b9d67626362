//! What happens at one instant: recovery matrices and their audit, several stops at once, contact forces (theory 1, 9).

mod audit;
mod chatter;
mod contact_force;
mod event;
mod multiple;
mod projection;
mod recovery;
mod saltation;

pub use audit::{RecoveryAudit, audit_recovery};
pub(crate) use chatter::CompleteChatter;
pub use contact_force::{ContactForce, Release, contact_forces};
pub use event::Impact;
pub(crate) use event::wrapped;
pub use multiple::{ResolvedImpacts, resolve_impacts};
pub(crate) use projection::{StopsAt, project, put_onto_stops};
pub use recovery::recovery_matrix;
pub(crate) use recovery::{check_stops, impulse_matrix};
pub(crate) use saltation::saltation;

//! What happens at one instant: recovery matrices, their audit, saltation matrices (theory 1, 7, 9).

mod audit;
mod event;
mod recovery;

pub use audit::{RecoveryAudit, audit_recovery};
pub use event::Impact;
pub(crate) use event::wrapped;
pub use recovery::recovery_matrix;
pub(crate) use recovery::{check_stops, impulse_matrix};

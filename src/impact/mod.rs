//! What happens at one instant: recovery matrices, their audit, saltation matrices (theory 1, 7, 9).

mod audit;
mod recovery;

pub use audit::{RecoveryAudit, audit_recovery};
pub(crate) use recovery::check_stops;
pub use recovery::recovery_matrix;

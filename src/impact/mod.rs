//! The laws of one instant, as mathematics (theory 1, 9): recovery matrices and their audit, impacts of several stops, contact
//! forces, the sum of impacts that accumulate, projection onto stops, saltation. The law of one stop is `law/newton.rs`;
//! `NormalImpacts::strike` in `hybrid/system.rs` applies it to a scene, its stop at rest or moving. When accumulating impacts are
//! completed is decided in `hybrid/resolver/chatter.rs`.

mod audit;
mod chatter_sum;
mod contact_force;
mod event;
mod projection;
mod recovery;
mod saltation;
mod several_stops;

pub use audit::{RecoveryAudit, audit_recovery};
pub(crate) use chatter_sum::CompleteChatter;
pub use contact_force::{ContactForce, Release, contact_forces};
pub use event::Impact;
pub(crate) use event::wrapped;
pub(crate) use projection::{StopsAt, project, put_onto_stops};
pub use recovery::recovery_matrix;
pub(crate) use recovery::{check_stops, impulse_matrix};
pub(crate) use saltation::{GapRate, saltation};
pub use several_stops::{ResolvedImpacts, resolve_impacts};

//! Poincare sections: a motion looked at once in a while, and what it has settled on.

mod events;
mod plane;
mod points;
mod settled;

pub(crate) use events::contacts_begun;
pub use points::{PoincarePoints, Section, poincare_points};
pub(crate) use points::{points_of, wait};
pub(crate) use settled::{Settled, farthest_from, settled, settled_by_impacts};

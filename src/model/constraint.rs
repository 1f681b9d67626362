//! One stop of a scene, of any form.

use crate::model::nonlinear_stop::NonlinearStop;
use crate::model::stop::{Stop, Wall};

/// One stop of a scene, of any form.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// A plane stop.
    Stop(Stop),
    /// A wall for a pendulum's bob.
    Wall(Wall),
    /// A stop with any gap.
    Nonlinear(NonlinearStop),
}

impl From<Stop> for Constraint {
    fn from(stop: Stop) -> Self {
        Self::Stop(stop)
    }
}

impl From<NonlinearStop> for Constraint {
    fn from(stop: NonlinearStop) -> Self {
        Self::Nonlinear(stop)
    }
}

impl From<Wall> for Constraint {
    fn from(wall: Wall) -> Self {
        Self::Wall(wall)
    }
}

//! One stop of a scene, of any form.

use crate::law::Law;
use crate::model::nonlinear_stop::NonlinearStop;
use crate::model::reaction::Reaction;
use crate::model::stop::{Stop, Wall, WallSide};
use crate::model::stop_motion::StopMotion;
use crate::quantity::Restitution;

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

impl Constraint {
    /// The motion of its own.
    pub fn motion(&self) -> Option<&StopMotion> {
        match self {
            Self::Stop(stop) => stop.motion(),
            Self::Wall(wall) => wall.motion(),
            Self::Nonlinear(stop) => stop.motion(),
        }
    }

    /// The same stop with another motion.
    pub(super) fn with_motion(self, motion: Option<StopMotion>) -> Self {
        match self {
            Self::Stop(stop) => stop.with_motion(motion).into(),
            Self::Wall(wall) => wall.with_motion(motion).into(),
            Self::Nonlinear(stop) => stop.with_motion(motion).into(),
        }
    }

    /// The law of contact.
    pub fn contact(&self) -> &Law {
        match self {
            Self::Stop(stop) => &stop.law,
            Self::Wall(wall) => &wall.law,
            Self::Nonlinear(stop) => &stop.law,
        }
    }

    pub(super) fn law_mut(&mut self) -> &mut Law {
        match self {
            Self::Stop(stop) => &mut stop.law,
            Self::Wall(wall) => &mut wall.law,
            Self::Nonlinear(stop) => &mut stop.law,
        }
    }

    /// Whether its reaction is that of inertia.
    pub(crate) fn reacts_by_inertia(&self) -> bool {
        match self {
            Self::Stop(stop) => *stop.reaction() == Reaction::Inertia,
            Self::Wall(_) => true,
            Self::Nonlinear(stop) => *stop.reaction() == Reaction::Inertia,
        }
    }

    /// The restitution coefficient, NaN of one that gives way.
    pub(crate) fn restitution(&self) -> f64 {
        self.contact()
            .restitution()
            .map_or(f64::NAN, Restitution::value)
    }

    /// The clearance, NaN of one that has a position or a gap function instead.
    pub(crate) fn clearance(&self) -> f64 {
        match self {
            Self::Stop(stop) => stop.clearance(),
            Self::Wall(_) | Self::Nonlinear(_) => f64::NAN,
        }
    }

    /// By how much of its motion its gap widens.
    pub(crate) fn widens_by(&self) -> f64 {
        match self {
            Self::Wall(wall) if wall.side() == WallSide::Left => -1.0,
            _ => 1.0,
        }
    }
}

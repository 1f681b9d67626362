//! Stops: rigid one-sided constraints `gap(q) >= 0`. A plane stop has `gap = clearance - n.q` (`Side::Upper`) or
//! `clearance + n.q` (`Side::Lower`); a wall stops one bob of a pendulum at a vertical plane; a nonlinear stop has any gap.

use crate::error::{Error, Result};
use crate::law::{IntoLaw, Law};
use crate::model::normal::Normal;
use crate::model::reaction::Reaction;
use crate::model::stop_motion::StopMotion;
use crate::quantity::{Restitution, finite, finite_vector};
use nalgebra::DVector;

/// On which side of the motion a stop stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// `n.q <= clearance`.
    #[default]
    Upper,
    /// `n.q >= -clearance`.
    Lower,
}

/// Plane stop with gap `clearance - n.q >= 0` (upper side) or `clearance + n.q >= 0` (lower side).
#[derive(Debug, Clone, PartialEq)]
pub struct Stop {
    normal: Normal,
    clearance: f64,
    pub(super) law: Law,
    side: Side,
    reaction: Reaction,
    motion: Option<StopMotion>,
}

impl Stop {
    /// An upper stop with the inertial reaction; `clearance` is the gap at q = 0, negative when preloaded, `contact` the law of contact,
    /// or the restitution of a rigid stop.
    ///
    /// # Errors
    /// A normal that is zero or not finite, a clearance that is not finite, a restitution outside [0, 1].
    pub fn new(normal: impl Into<Normal>, clearance: f64, contact: impl IntoLaw) -> Result<Self> {
        let normal = normal.into();
        if let Normal::Vector(n) = &normal {
            finite_vector("normal", n, n.len())?;
            if n.amax() == 0.0 {
                return Err(Error::bad_value(
                    "normal",
                    "zero",
                    "a normal needs an entry that is not zero",
                ));
            }
        }
        Ok(Self {
            normal,
            clearance: finite("clearance", clearance)?,
            law: contact.into_law()?,
            side: Side::Upper,
            reaction: Reaction::Inertia,
            motion: None,
        })
    }

    /// The same stop on the given side.
    #[must_use]
    pub fn on_side(mut self, side: Side) -> Self {
        self.side = side;
        self
    }

    /// The same stop with the given reaction.
    ///
    /// # Errors
    /// A reaction direction that is not finite.
    pub fn with_reaction(mut self, reaction: Reaction) -> Result<Self> {
        if let Reaction::Direction(b) = &reaction {
            finite_vector("reaction", b, b.len())?;
        }
        self.reaction = reaction;
        Ok(self)
    }

    /// The same stop with a motion of its own, which is added to its clearance; without where it is `None`.
    #[must_use]
    pub fn with_motion(mut self, motion: Option<StopMotion>) -> Self {
        self.motion = motion;
        self
    }

    /// The motion of its own.
    pub fn motion(&self) -> Option<&StopMotion> {
        self.motion.as_ref()
    }

    /// The normal as given.
    pub fn normal(&self) -> &Normal {
        &self.normal
    }

    /// The gap at q = 0.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The restitution coefficient; `None` of a stop that gives way.
    pub fn restitution(&self) -> Option<Restitution> {
        self.law.restitution()
    }

    /// The law of contact.
    pub fn contact(&self) -> &Law {
        &self.law
    }

    /// The side.
    pub fn side(&self) -> Side {
        self.side
    }

    /// The reaction.
    pub fn reaction(&self) -> &Reaction {
        &self.reaction
    }

    /// The normal as a vector of n entries, as given (not turned by the side).
    ///
    /// # Errors
    /// A coordinate that the system does not have, or a vector of another length; `label` names the stop.
    pub fn normal_vector(&self, n: usize, label: &str) -> Result<DVector<f64>> {
        self.normal.vector(n, &format!("{label}.normal"))
    }

    /// The normal towards the stop: `gap = clearance - outward.q` on either side.
    pub(crate) fn outward(&self, n: usize) -> DVector<f64> {
        let normal = self
            .normal_vector(n, "stop")
            .expect("a scene's stops fit its system");
        match self.side {
            Side::Upper => normal,
            Side::Lower => -normal,
        }
    }

    pub(crate) fn set_clearance(&mut self, clearance: f64) -> Result<()> {
        self.clearance = finite("clearance", clearance)?;
        Ok(())
    }
}

/// On which side of a pendulum's bob a wall stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WallSide {
    /// The bob stays left of the wall.
    #[default]
    Right,
    /// The bob stays right of the wall.
    Left,
}

/// Vertical plane wall that one bob of a pendulum may not cross; it moves with the base. It may move relative to that by a motion
/// of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    bob: usize,
    position: f64,
    pub(super) law: Law,
    side: WallSide,
    motion: Option<StopMotion>,
}

impl Wall {
    /// A wall at the horizontal `position` for bob number `bob`, counted from 0; `contact` is the law of contact, or the restitution of a
    /// rigid wall.
    ///
    /// # Errors
    /// A position that is not finite, a restitution outside [0, 1].
    pub fn new(bob: usize, position: f64, contact: impl IntoLaw, side: WallSide) -> Result<Self> {
        Ok(Self {
            bob,
            position: finite("position", position)?,
            law: contact.into_law()?,
            side,
            motion: None,
        })
    }

    /// The same wall with a motion of its own, which is added to its position; without where it is `None`.
    #[must_use]
    pub fn with_motion(mut self, motion: Option<StopMotion>) -> Self {
        self.motion = motion;
        self
    }

    /// The motion of its own.
    pub fn motion(&self) -> Option<&StopMotion> {
        self.motion.as_ref()
    }

    /// The bob, counted from 0.
    pub fn bob(&self) -> usize {
        self.bob
    }

    /// The horizontal position.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// The restitution coefficient; `None` of a stop that gives way.
    pub fn restitution(&self) -> Option<Restitution> {
        self.law.restitution()
    }

    /// The law of contact.
    pub fn contact(&self) -> &Law {
        &self.law
    }

    /// The side.
    pub fn side(&self) -> WallSide {
        self.side
    }

    /// The gap `position - sum l_i sin q_i` over the links up to the bob (left wall: the opposite sign).
    pub(crate) fn gap(&self, lengths: &DVector<f64>, q: &DVector<f64>) -> f64 {
        let reach: f64 = (0..=self.bob).map(|i| lengths[i] * q[i].sin()).sum();
        match self.side {
            WallSide::Right => self.position - reach,
            WallSide::Left => reach - self.position,
        }
    }

    /// The stop that the wall is for small angles.
    pub(crate) fn linearise(&self, lengths: &DVector<f64>) -> Result<Stop> {
        let normal = DVector::from_fn(
            lengths.len(),
            |i, _| if i <= self.bob { lengths[i] } else { 0.0 },
        );
        let (clearance, side) = match self.side {
            WallSide::Right => (self.position, Side::Upper),
            WallSide::Left => (-self.position, Side::Lower),
        };
        let motion = match self.side {
            WallSide::Right => self.motion.clone(),
            WallSide::Left => self.motion.as_ref().map(StopMotion::opposite),
        };
        let stop = Stop::new(normal, clearance, self.law.clone())?;
        Ok(stop.on_side(side).with_motion(motion))
    }
}

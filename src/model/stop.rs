//! Stops: rigid one-sided constraints `gap(q) >= 0`. A plane stop has `gap = clearance - n.q` (`Side::Upper`) or
//! `clearance + n.q` (`Side::Lower`); a wall stops one bob of a pendulum at a vertical plane; a nonlinear stop has any gap.

use crate::error::{Error, Result};
use crate::model::reaction::Reaction;
use crate::quantity::{Restitution, finite, finite_vector};
use nalgebra::DVector;

/// The normal of a stop: one coordinate, or a vector of any length.
#[derive(Debug, Clone, PartialEq)]
pub enum Normal {
    /// The unit vector of one coordinate, counted from 0.
    Coordinate(usize),
    /// Any vector that is not zero, shape `(n,)`.
    Vector(DVector<f64>),
}

impl From<usize> for Normal {
    fn from(index: usize) -> Self {
        Self::Coordinate(index)
    }
}

impl From<DVector<f64>> for Normal {
    fn from(normal: DVector<f64>) -> Self {
        Self::Vector(normal)
    }
}

impl Normal {
    /// The normal as a vector of n entries.
    ///
    /// # Errors
    /// A coordinate that the system does not have, a vector of another length or not finite; `argument` names it.
    pub fn vector(&self, n: usize, argument: &str) -> Result<DVector<f64>> {
        match self {
            Self::Coordinate(i) if *i < n => {
                Ok(DVector::from_fn(n, |row, _| f64::from(u8::from(row == *i))))
            }
            Self::Coordinate(i) => Err(Error::bad_value(
                argument,
                i,
                format!("the system has coordinates 0 to {}", n - 1),
            )),
            Self::Vector(v) => {
                finite_vector(argument, v, n)?;
                Ok(v.clone())
            }
        }
    }
}

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
    restitution: Restitution,
    side: Side,
    reaction: Reaction,
}

impl Stop {
    /// An upper stop with the inertial reaction; `clearance` is the gap at q = 0, negative when preloaded.
    ///
    /// # Errors
    /// A normal that is zero or not finite, a clearance that is not finite, a restitution outside [0, 1].
    pub fn new(normal: impl Into<Normal>, clearance: f64, restitution: f64) -> Result<Self> {
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
            restitution: Restitution::new(restitution)?,
            side: Side::Upper,
            reaction: Reaction::Inertia,
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

    /// The normal as given.
    pub fn normal(&self) -> &Normal {
        &self.normal
    }

    /// The gap at q = 0.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The restitution coefficient.
    pub fn restitution(&self) -> Restitution {
        self.restitution
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

    pub(crate) fn set_restitution(&mut self, restitution: f64) -> Result<()> {
        self.restitution = Restitution::new(restitution)?;
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

/// Vertical plane wall that one bob of a pendulum may not cross; it moves with the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    bob: usize,
    position: f64,
    restitution: Restitution,
    side: WallSide,
}

impl Wall {
    /// A wall at the horizontal `position` for bob number `bob`, counted from 0.
    ///
    /// # Errors
    /// A position that is not finite, a restitution outside [0, 1].
    pub fn new(bob: usize, position: f64, restitution: f64, side: WallSide) -> Result<Self> {
        Ok(Self {
            bob,
            position: finite("position", position)?,
            restitution: Restitution::new(restitution)?,
            side,
        })
    }

    /// The bob, counted from 0.
    pub fn bob(&self) -> usize {
        self.bob
    }

    /// The horizontal position.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// The restitution coefficient.
    pub fn restitution(&self) -> Restitution {
        self.restitution
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
        Ok(Stop::new(normal, clearance, self.restitution.value())?.on_side(side))
    }

    pub(crate) fn set_restitution(&mut self, restitution: f64) -> Result<()> {
        self.restitution = Restitution::new(restitution)?;
        Ok(())
    }
}

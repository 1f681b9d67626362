//! What is watched of the gap of an element along a motion, positive while its element stays in its state: the gap itself, the approach of one
//! that is met, or the distance of one that relaxes, whose place is known at all times.

use crate::law::{ElementState, GuardKind, Relaxation};
use crate::model::contact::GapValue;

/// What is watched of a gap h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum WatchedGap {
    /// h
    Gap,
    /// p = -h
    Approach,
    /// r - p, of an element that relaxes and has a place r now.
    Distance { relaxation: Relaxation, place: f64 },
}

impl WatchedGap {
    /// What is watched of an element in a state that does not relax.
    pub fn of(state: ElementState) -> Self {
        match state {
            ElementState::Pressed | ElementState::Idle => Self::Approach,
            _ => Self::Gap,
        }
    }

    /// The guard that it is.
    pub fn kind(self) -> GuardKind {
        match self {
            Self::Gap => GuardKind::Gap,
            Self::Approach => GuardKind::Approach,
            Self::Distance { .. } => GuardKind::Distance,
        }
    }

    /// What the gap is multiplied by.
    pub fn sign(self) -> f64 {
        match self {
            Self::Approach => -1.0,
            _ => 1.0,
        }
    }

    /// The place that is added to it a time from now on, with its speed and acceleration.
    pub fn place(self, time: f64) -> [f64; 3] {
        match self {
            Self::Distance { relaxation, place } => relaxation.along(place, time),
            _ => [0.0; 3],
        }
    }

    /// Its value, where the gap has one a time from now on.
    pub fn at(self, gap: f64, time: f64) -> f64 {
        self.sign() * gap + self.place(time)[0]
    }

    /// Makes it of a gap with its derivatives, a time from now on.
    pub fn turn(self, value: &mut GapValue, time: f64) {
        match self {
            Self::Gap => {}
            Self::Approach => value.reverse(),
            Self::Distance { .. } => {
                let [place, speed, acceleration] = self.place(time);
                value.gap += place;
                value.speed += speed;
                value.acceleration += acceleration;
                value.size += place;
            }
        }
    }

    /// Makes the gap of it again, now.
    pub fn turn_back(self, value: &mut GapValue) {
        match self {
            Self::Gap => {}
            Self::Approach => value.reverse(),
            Self::Distance { .. } => {
                let [place, speed, acceleration] = self.place(0.0);
                value.gap -= place;
                value.speed -= speed;
                value.acceleration -= acceleration;
                value.size -= place;
            }
        }
    }
}

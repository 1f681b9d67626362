//! The parts of a motion that meets stops.

use crate::error::{Error, Result};
use crate::law::Regime;
use std::borrow::Cow;

/// What a part of a trajectory is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SegmentKind {
    /// Free motion.
    Flight,
    /// The end of an infinite sequence of impacts that accumulate at a finite time, on the first of the stops; others are held.
    Chatter,
    /// Lasting contact.
    Stick,
}

impl SegmentKind {
    /// The kind of a part of a motion in a regime.
    pub(crate) fn of(regime: &Regime) -> Self {
        if regime.constrained().is_empty() {
            Self::Flight
        } else {
            Self::Stick
        }
    }

    /// The element whose impacts accumulate along a part of this kind, which is drawn in a regime.
    pub(crate) fn accumulation(self, regime: &Regime) -> Option<usize> {
        let first = regime.constrained().first().copied();
        first.filter(|_| self == Self::Chatter)
    }

    /// The regime that lasts along a part of this kind, which is drawn in another: without what is held where impacts accumulate.
    pub(crate) fn lasting(self, regime: &Regime) -> Cow<'_, Regime> {
        match self {
            Self::Chatter => Cow::Owned(regime.holding_instead(&[])),
            Self::Flight | Self::Stick => Cow::Borrowed(regime),
        }
    }

    /// The kind for one of the elements in contact: beside impacts that accumulate on the first, others are held.
    pub(crate) fn at_place(self, place: usize) -> Self {
        match self {
            Self::Chatter if place > 0 => Self::Stick,
            kind => kind,
        }
    }

    const ALL: [Self; 3] = [Self::Flight, Self::Chatter, Self::Stick];

    /// The name used in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flight => "flight",
            Self::Chatter => "chatter",
            Self::Stick => "stick",
        }
    }

    /// The kind of a name.
    pub(crate) fn from_name(name: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| Error::bad_value("segment", name, "there is no such kind"))
    }

    /// The regime of a part of this kind that was written as plain numbers, if it can have that.
    pub(crate) fn read(self, numbers: &[usize]) -> Option<Regime> {
        let regime = Regime::read(numbers)?;
        let is_free = regime.constrained().is_empty();
        (is_free == (self == Self::Flight)).then_some(regime)
    }
}

/// A touch without impact: a gap whose minimum lies within its rounding of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Graze {
    /// Time \[s\].
    pub time: f64,
    /// The stop.
    pub stop: usize,
    /// How far the stop is passed; negative where it is not quite reached.
    pub depth: f64,
}

//! The parts of a motion that meets stops.

use crate::error::{Error, Result};
use crate::law::Regime;

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

    /// The regime that lasts along a part of this kind, which is drawn in another: the free one where impacts accumulate.
    pub(crate) fn lasting(self, regime: &Regime) -> &Regime {
        match self {
            Self::Chatter => Regime::free(),
            Self::Flight | Self::Stick => regime,
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

    /// Whether these can be the stops in contact on a part of this kind.
    pub(crate) fn can_have(self, stops: &[usize]) -> bool {
        let fits = match self {
            Self::Flight => stops.is_empty(),
            Self::Chatter | Self::Stick => !stops.is_empty(),
        };
        fits && (1..stops.len()).all(|i| !stops[..i].contains(&stops[i]))
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

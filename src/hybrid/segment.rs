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

//! The parts of a motion, and the sides of its instants.

use crate::hybrid::SegmentKind;
use crate::law::{Law, Regime};
use std::borrow::Cow;

/// Which velocity is meant at an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ImpactSide {
    /// The one after it.
    #[default]
    After,
    /// The one before it.
    Before,
}

/// A part of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The kind of motion.
    pub kind: SegmentKind,
    /// The stop it stays on or chatters against, `None` for a flight.
    pub stop: Option<usize>,
    /// Start \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
    /// What the stop gives on it: the force of lasting contact over its time, the sum of the impacts that accumulate. Those of
    /// the impacts that are listed are not in it: zero for a flight.
    pub impulse: f64,
}

/// A part of a motion along which each element of the scene stays in one state.
#[derive(Debug, Clone, PartialEq)]
pub struct RegimeRow {
    /// Start \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
    /// The state of each element, in the order of the scene's stops: "free", "held", "pressed", "relaxing", "idle" or
    /// "seated".
    pub states: Vec<&'static str>,
}

impl RegimeRow {
    /// That of a part of a motion with elements of some laws.
    pub(crate) fn of<'l>(stretch: &Stretch<'_>, laws: impl Iterator<Item = &'l Law>) -> Self {
        let lasting = stretch.lasting();
        let states = laws.enumerate();
        let states = states.map(|(i, law)| lasting.state(i).name(law.is_rigid()));
        Self {
            start: stretch.start,
            end: stretch.end,
            states: states.collect(),
        }
    }
}

/// A part of a motion with all the stops in contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch<'a> {
    /// Its number among the segments of the path.
    pub segment: usize,
    pub kind: SegmentKind,
    pub regime: &'a Regime,
    pub start: f64,
    pub end: f64,
}

impl<'a> Stretch<'a> {
    /// The element whose impacts accumulate along it: it is the rest of them.
    pub fn accumulation(&self) -> Option<usize> {
        self.kind.accumulation(self.regime)
    }

    /// The regime that lasts along it: the free one where impacts accumulate.
    pub fn lasting(&self) -> Cow<'a, Regime> {
        self.kind.lasting(self.regime)
    }

    /// The stops in contact.
    pub fn stops(&self) -> &'a [usize] {
        self.regime.constrained()
    }

    /// A row for each stop in contact, with what it gives; one without any for a flight.
    pub fn rows(self, impulses: &'a [f64]) -> impl Iterator<Item = Segment> + 'a {
        let Self {
            kind, start, end, ..
        } = self;
        let row = move |(place, (stop, impulse))| Segment {
            kind: kind.at_place(place),
            stop,
            start,
            end,
            impulse,
        };
        let free = self.stops().is_empty().then_some((None, 0.0));
        let each = self.stops().iter().zip(impulses);
        let each = each.map(|(&stop, &impulse)| (Some(stop), impulse));
        free.into_iter().chain(each).enumerate().map(row)
    }
}

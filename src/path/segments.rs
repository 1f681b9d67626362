//! The parts of a motion, and the sides of its instants.

use crate::hybrid::SegmentKind;

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
    /// What it is.
    pub kind: SegmentKind,
    /// The stop it stays on or chatters against, `None` for a flight.
    pub stop: Option<usize>,
    /// Start \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
}

impl Segment {
    /// A part with several stops in contact as one row for each.
    pub(crate) fn rows(self, stops: &[usize]) -> impl Iterator<Item = Self> {
        let free = stops.is_empty().then_some(self);
        let each = stops.iter().map(move |&stop| Self {
            stop: Some(stop),
            ..self
        });
        free.into_iter().chain(each)
    }
}

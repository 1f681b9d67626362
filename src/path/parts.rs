//! The stored form of a motion: arcs that follow each other in time, grouped in segments, and for each arc the numbers from which it can
//! be evaluated at any of its times.

use crate::hybrid::SegmentKind;
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::{ArcSpan, Written};
use crate::law::Regime;

/// One arc: its clock and span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathArc {
    pub clock: Clock,
    pub span: f64,
}

impl PathArc {
    /// How far along it a time is, as the doubles that a user sees: at its start, the start.
    pub fn local(&self, t: f64) -> f64 {
        if t == self.clock.time() {
            return 0.0;
        }
        self.clock.until(self.clock.at(t)).clamp(0.0, self.span)
    }
}

/// A point of a path: an arc, and how far along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathPoint {
    pub time: f64,
    pub arc: usize,
    pub local: f64,
}

/// A segment: its kind, the stops in contact and its first arc.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PathSegment {
    pub kind: SegmentKind,
    pub regime: Regime,
    pub first: usize,
    /// Where the numbers of its arcs begin.
    pub offset: usize,
}

/// The motion that `keep` asks for.
#[derive(Debug, Clone, Default)]
pub(crate) struct PathParts {
    pub arcs: Vec<PathArc>,
    pub segments: Vec<PathSegment>,
    /// The numbers from which the arcs can be evaluated, one arc after the other, as many for each arc of a segment: shape `(n_numbers,)`,
    /// [mixed]; their meaning and units are those of [`Evaluator`](crate::path::Evaluator).
    pub numbers: Vec<f64>,
    /// Whether there may be arcs between them that are not kept.
    pub has_gaps: bool,
}

/// Where impacts on a stop begin to accumulate: the time, the stop and its approach speed.
pub(crate) type AccumulationStart = (f64, usize, f64);

impl PathSegment {
    /// The element whose impacts accumulate along it: it is the rest of them.
    pub fn accumulation(&self) -> Option<usize> {
        self.kind.accumulation(&self.regime)
    }
}

impl PathParts {
    /// Begins a segment.
    pub fn begin(&mut self, kind: SegmentKind, regime: &Regime) {
        self.segments.push(PathSegment {
            kind,
            regime: regime.clone(),
            first: self.arcs.len(),
            offset: self.numbers.len(),
        });
    }

    /// Adds an arc.
    pub fn push(&mut self, span: &ArcSpan, motion: &(impl Written + ?Sized)) {
        self.arcs.push(PathArc {
            clock: span.start,
            span: span.span,
        });
        motion.write(&mut self.numbers);
    }

    /// Adds an arc that is a later part of another one.
    pub fn push_later(&mut self, span: &ArcSpan, write: impl FnOnce(&mut Vec<f64>)) {
        self.arcs.push(PathArc {
            clock: span.start,
            span: span.span,
        });
        write(&mut self.numbers);
    }

    /// Takes back a segment that has no arcs.
    pub fn take_back(&mut self) {
        let count = self.arcs.len();
        self.segments.pop_if(|last| last.first == count);
    }

    /// The segment that an arc belongs to.
    pub fn segment_of(&self, arc: usize) -> &PathSegment {
        let later = self.segments.partition_point(|s| s.first <= arc);
        &self.segments[later - 1]
    }

    /// The numbers of an arc of a segment, so many for each.
    pub fn numbers_of(&self, segment: &PathSegment, arc: usize, width: usize) -> &[f64] {
        let start = segment.offset + (arc - segment.first) * width;
        &self.numbers[start..start + width]
    }

    /// Whether an arc begins where the one before it ends.
    pub fn follows(&self, arc: usize) -> bool {
        let Some((before, own)) = arc
            .checked_sub(1)
            .and_then(|k| Some((self.arcs.get(k)?, self.arcs.get(arc)?)))
        else {
            return false;
        };
        let (end, start) = (before.clock.after(before.span).time(), own.clock.time());
        !self.has_gaps || (end - start).abs() <= 4.0 * f64::EPSILON * start.abs()
    }

    /// The arcs of a segment.
    pub fn arcs_of(&self, segment: usize) -> std::ops::Range<usize> {
        let end = self
            .segments
            .get(segment + 1)
            .map_or(self.arcs.len(), |next| next.first);
        self.segments[segment].first..end
    }
}

//! What a hybrid system hands on of the motion that it passes through: arcs, in segments, and touches. What is kept of them is not
//! its business.

use crate::flow::steps::{Dense, DenseOutput, State};
use crate::hybrid::clock::Clock;
use crate::hybrid::segment::{Graze, SegmentKind};
use crate::modal::Pair;
use crate::model::PhysicalState;
use std::ops::ControlFlow;

/// What a recorder wants to be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wanted {
    /// Impacts and touches.
    pub events: bool,
    /// The motion between them.
    pub arcs: bool,
}

impl Wanted {
    /// Whether nothing is but the end of a run.
    #[inline]
    pub fn is_nothing(self) -> bool {
        !(self.events || self.arcs)
    }
}

/// The span of an arc.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArcSpan {
    pub start: Clock,
    pub span: f64,
    /// The time at which the run ends with it, if it does.
    pub last: Option<f64>,
}

/// What can be written as the numbers from which it can be had again.
pub(crate) trait Written {
    /// Adds the numbers.
    fn write(&self, numbers: &mut Vec<f64>);
}

/// The motion on an arc, in the form in which its flow knows it.
pub(crate) trait ArcMotion: Written {
    /// Position and velocity a time after the start.
    fn state(&mut self, local: f64) -> PhysicalState;

    /// The same from a time on, every so often, for as long as who looks goes on.
    fn strobe(
        &mut self,
        [first, every]: [f64; 2],
        look: &mut dyn FnMut(&PhysicalState) -> ControlFlow<()>,
    ) {
        let mut count = 0.0;
        while look(&self.state(first + count * every)).is_continue() {
            count += 1.0;
        }
    }
}

/// Modal pairs.
impl Written for [Pair] {
    fn write(&self, numbers: &mut Vec<f64>) {
        numbers.extend_from_slice(self.as_flattened());
    }
}

/// A step.
impl<S: State, const P: usize> Written for Dense<S, P> {
    fn write(&self, numbers: &mut Vec<f64>) {
        DenseOutput::write(self, numbers);
    }
}

/// Takes note of a motion as it is passed through.
pub(crate) trait Recorder {
    /// What it wants to be told.
    fn wanted(&self) -> Wanted;
    /// Begins a segment, with the stops in contact; the arcs that follow are its.
    fn begin_segment(&mut self, kind: SegmentKind, stops: &[usize]);
    /// Whether it wants an arc.
    fn wants_arc(&self, span: &ArcSpan) -> bool;
    /// An arc of the motion.
    fn arc(&mut self, span: &ArcSpan, motion: &mut dyn ArcMotion);
    /// Whether it has seen enough: the run may end.
    fn is_satisfied(&self) -> bool {
        false
    }
    /// A touch.
    fn graze(&mut self, graze: Graze);
}

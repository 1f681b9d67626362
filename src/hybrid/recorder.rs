//! The interface by which a hybrid system hands on its motion: arcs, in segments, and touches. The recorder decides what is kept.

use crate::flow::steps::{Dense, DenseOutput, State};
use crate::hybrid::clock::Clock;
use crate::hybrid::segment::{Graze, SegmentKind};
use crate::impact::Impact;
use crate::law::Regime;
use crate::modal::Pair;
use crate::model::PhysicalState;
use std::ops::ControlFlow;

/// The kinds of things that a recorder wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wanted {
    /// Impacts and touches.
    pub events: bool,
    /// The motion between them.
    pub arcs: bool,
    /// The motion along which stops are met.
    pub contacts: bool,
}

impl Wanted {
    /// Whether the motion in a regime is wanted.
    pub fn motion_in(self, regime: &Regime) -> bool {
        self.arcs || (self.contacts && regime.pushing().next().is_some())
    }

    /// Whether nothing is wanted but the end of a run.
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

/// A motion that can be written as plain numbers, from which it can be restored.
pub(crate) trait Written {
    /// Adds the numbers.
    fn write(&self, numbers: &mut Vec<f64>);
}

/// The motion on an arc, in the form of its flow.
pub(crate) trait ArcMotion: Written {
    /// Position and velocity a time after the start.
    fn state(&mut self, local: f64) -> PhysicalState;

    /// Adds the numbers of what is left of it a time after the start, of an exact flight that is gone again.
    fn write_later(&mut self, _local: f64, _numbers: &mut Vec<f64>) {
        unreachable!("exact flights alone are gone again");
    }

    /// Position and velocity from a time `first` on, at intervals `every`, until `look` breaks off.
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

/// Receives a motion as it is computed.
pub(crate) trait Recorder {
    /// The kinds of things that it wants.
    fn wanted(&self) -> Wanted;
    /// Begins a segment, along which the motion is that of a regime; the arcs that follow belong to it.
    fn begin_segment(&mut self, kind: SegmentKind, regime: &Regime);
    /// Whether it wants an arc.
    fn wants_arc(&self, span: &ArcSpan) -> bool;
    /// An arc of the motion.
    fn arc(&mut self, span: &ArcSpan, motion: &mut dyn ArcMotion);
    /// Whether it has enough: the run may end.
    fn is_satisfied(&self) -> bool {
        false
    }
    /// A touch.
    fn graze(&mut self, graze: Graze);
    /// An impact.
    fn impact(&mut self, _impact: Impact) {}
    /// Impacts on a stop begin to accumulate, at a time and with an approach speed.
    fn accumulation(&mut self, _time: f64, _stop: usize, _approach: f64) {}
    /// The segment that begins next is a part of the last one, where it is of the same kind and regime.
    fn continue_segment(&mut self) {}
}

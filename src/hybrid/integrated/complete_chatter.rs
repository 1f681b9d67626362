//! The completion of impacts that accumulate (theory 9).

use super::scene::Integrated;
use crate::error::Result;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::recorder::Recorder;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::{Contacts, Gaps};
use crate::impact::CompleteChatter;
use crate::model::{Dynamics, GapValue};

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Takes the present state to where the impacts on a stop that accumulate come to rest. What they give in all is what holding
    /// the stop gives meanwhile, so that is how the motion goes on: the rest of it moves over the time they take, or that is left.
    pub(super) fn complete(
        &mut self,
        stop: usize,
        left: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        self.evaluate_gaps()?;
        let GapValue {
            speed,
            acceleration,
            ..
        } = self.gaps[stop];
        let chatter = CompleteChatter {
            restitution: self.restitution(stop),
            speed,
            acceleration,
        };
        let span = chatter.span().min(left);
        recorder.begin_segment(SegmentKind::Chatter, &[stop]);
        self.settle(&[stop])?;
        self.advance_without_events(&self.motion_with(vec![stop]), span, recorder)?;
        self.settle(&[stop])?;
        self.evaluate_gaps()
    }
}

//! The completion of impacts that accumulate (theory 9).

use super::scene::Integrated;
use crate::error::Result;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::recorder::Recorder;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::Gaps;
use crate::model::Dynamics;

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Takes the present state to where the impacts on the first of some stops that accumulate come to rest, while the others are held.
    /// What they give in all is what holding the stop gives meanwhile, so that is how the motion goes on: the rest of it moves over the time they take.
    pub(super) fn complete(
        &mut self,
        stops: &[usize],
        span: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        recorder.begin_segment(SegmentKind::Chatter, stops);
        self.settle(stops)?;
        self.advance_without_events(&self.motion_with(stops.to_vec()), span, recorder)?;
        self.settle(stops)?;
        self.evaluate_gaps()
    }
}

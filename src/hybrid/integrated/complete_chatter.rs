//! The completion of impacts that accumulate (theory 9).

use super::scene::Integrated;
use crate::error::Result;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::recorder::Recorder;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::Gaps;
use crate::law::Regime;
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
        let regime = Regime::holding(stops);
        recorder.begin_segment(SegmentKind::Chatter, &regime);
        self.settle_in(&regime)?;
        self.advance_without_events(&self.motion_in(&regime), span, recorder)?;
        self.settle_in(&regime)?;
        self.evaluate_gaps()
    }
}

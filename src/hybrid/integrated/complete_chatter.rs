//! The completion of impacts that accumulate, of integrated scenes (theory 9). In closed form it is `complete_chatter` in
//! `closed_form/system.rs`.

use super::scene::Integrated;
use crate::error::Result;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::recorder::Recorder;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::Gaps;
use crate::model::Dynamics;

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Takes the present state to where the impacts on the first of some stops that accumulate come to rest, while the others are held.
    /// Their impulses add up to what the force of lasting contact gives in the same time: the motion goes on for that time with all of the
    /// stops held, and so everything else moves as far as it does during the impacts.
    pub(super) fn complete(
        &mut self,
        stops: &[usize],
        span: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        let regime = self.regime.holding_instead(stops);
        recorder.begin_segment(SegmentKind::Chatter, &regime);
        self.settle_in(&regime)?;
        self.advance_without_events(&self.motion_in(&regime), span, recorder)?;
        self.settle_in(&regime)?;
        self.evaluate_gaps()
    }
}

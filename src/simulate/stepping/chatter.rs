//! The completion of impacts that accumulate (theory 9).

use super::StepMover;
use super::free::FreeFlight;
use crate::error::Result;
use crate::flow::steps::State;
use crate::impact::CompleteChatter;
use crate::model::{Dynamics, GapValue};
use crate::simulate::kept::SegmentKind;
use crate::simulate::mover::Mover;
use crate::simulate::record::Record;

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'_, S, D, F> {
    /// Takes the present state to where the impacts on a stop that accumulate come to rest. What they give in all is what holding
    /// the stop gives meanwhile, so that is how the motion goes on: the rest of it moves over the time they take, or that is left.
    pub(super) fn complete(&mut self, stop: usize, left: f64, record: &mut Record) -> Result<()> {
        self.look()?;
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
        if let Some(kept) = &mut self.kept {
            kept.begin(SegmentKind::Chatter, &[stop]);
        }
        self.settle(&[stop])?;
        self.stay_along(&self.motion_with(vec![stop]), span, record)?;
        self.settle(&[stop])?;
        self.look()
    }
}

//! Free flights of a motion in steps: what moves it where no stop is held.

use super::StepMover;
use crate::error::Result;
use crate::flow::steps::{State, Stepper};
use crate::model::Dynamics;
use crate::simulate::kept::SegmentKind;
use crate::simulate::mover::Arrival;
use crate::simulate::record::Record;
use crate::watch::Watch;

/// What moves a motion where no stop is held.
pub(crate) trait FreeFlight<S: State, D: Dynamics>: Sized {
    /// The steps of a motion with stops held.
    type Steps: Stepper<S>;

    /// Forgets the run before.
    fn reset(&mut self);

    /// A flight, as [`crate::simulate::Mover::fly`].
    fn fly(
        mover: &mut StepMover<'_, S, D, Self>,
        starts: &[usize],
        ends: (f64, f64),
        record: &mut Record,
        watch: &mut Watch<'_>,
    ) -> Result<Arrival>;

    /// Keeps a piece of no length at the present state; `last` is the time at which the run ends with it.
    fn keep_nothing(
        mover: &mut StepMover<'_, S, D, Self>,
        last: Option<f64>,
        record: &mut Record,
    ) -> Result<()>;
}

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'_, S, D, F> {
    /// Begins a segment of the motion that is kept.
    pub(super) fn keep_segment(&mut self, kind: SegmentKind) {
        if let Some(kept) = &mut self.kept {
            kept.begin(kind, &self.holding);
        }
    }
}

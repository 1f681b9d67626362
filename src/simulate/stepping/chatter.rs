//! The completion of impacts that accumulate (theory 9).

use super::normal::dot;
use super::{FreeFlight, StepMover};
use crate::error::Result;
use crate::flow::runge_kutta::{Dense, State};
use crate::model::{Dynamics, GapValue};
use crate::simulate::kept::SegmentKind;
use crate::simulate::mover::Mover;
use crate::simulate::record::Record;

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'_, S, D, F> {
    /// Takes the present state to where the impacts on a stop that accumulate come to rest, as a straight line.
    pub(super) fn complete(&mut self, stop: usize, record: &mut Record) -> Result<()> {
        self.look()?;
        let GapValue {
            speed,
            acceleration,
            ..
        } = self.gaps[stop];
        let e = self.restitution(stop);
        let part = speed / (1.0 - e);
        let span = 2.0 * e * part / acceleration;
        let n = self.n();
        // Y* = Y + ((2e/a) (f, 1) + (W, 0)) h'/(1 - e)
        let directions = self.directions(stop)?;
        let (normal, reaction) = directions.both();
        let give = dot(normal, reaction);
        let drift = 2.0 * e / acceleration * part;
        let kick = (1.0 + e) * part / give;
        let start = self.x.clone();
        let rate = self.stepper.start_rate().clone();
        for (x, rate) in self.x.slice_mut().iter_mut().zip(rate.slice()) {
            *x += drift * rate;
        }
        self.push_along(reaction, -kick);
        self.settle(&[stop])?;
        if let Some(kept) = &mut self.kept {
            kept.begin(SegmentKind::Chatter, &[stop]);
        }
        // The impacts are over in no time: the line begins without normal speed.
        let mut rest = start.clone();
        let (_, v) = rest.slice_mut().split_at_mut(n);
        for (v, b) in v.iter_mut().zip(reaction) {
            *v += b * speed / give;
        }
        let line = Dense::line(&rest, &self.x, span);
        self.keep_dense(&line, span, None, record);
        self.clock = self.clock.after(span);
        self.look()
    }
}

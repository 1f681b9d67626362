//! What is kept of exact flights: segments, samples, touches to rounding.

use super::ExactMover;
use crate::contact::next::Grazed;
use crate::error::Result;
use crate::flow::{ConstrainedMotion, LinearFlow};
use crate::modal::Pair;
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Piece, SegmentKind};
use crate::simulate::options::Keep;
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use nalgebra::DVector;
use std::sync::Arc;

impl<F: LinearFlow> ExactMover<'_, F> {
    /// Keeps what is asked for of a flight from the present state; `last` is the time at which the run ends with it.
    #[inline]
    pub(super) fn keep(&mut self, span: f64, last: Option<f64>, record: &mut Record) {
        if !record.keeps_nothing() {
            self.keep_flight(span, last, record);
        }
    }

    fn keep_flight(&mut self, span: f64, last: Option<f64>, record: &mut Record) {
        if record.keep != Keep::Final {
            for i in 0..self.grazed.len() {
                let (grazed, gap) = (self.grazed[i], self.search.gap(self.grazed[i].stop));
                let grazed = grazed.sharpened(self.flow, gap, &self.state, span);
                record.grazes.push(reported(grazed, self.clock));
            }
        }
        self.keep_piece(SegmentKind::Flight, &[], span);
        let Self {
            search,
            state,
            scene,
            flow,
            clock,
            ..
        } = self;
        let mut whole = Vec::new();
        record.sample(*clock, span, last, |local| {
            let mut there = state.clone();
            search.forward(&mut there, local);
            flow.leave(&there, &mut whole);
            scene.form.to_physical(&whole)
        });
    }

    /// Keeps the rest of impacts on a stop that accumulate, over a span: the motion along it, with position and velocity where it
    /// begins. Of the normal speed none is left, and in the sum the impulses give what the force of lasting contact gives.
    pub(super) fn keep_chatter(
        &mut self,
        stop: usize,
        span: f64,
        record: &mut Record,
    ) -> Result<(Arc<ConstrainedMotion>, (DVector<f64>, DVector<f64>))> {
        let motion = self.motion_of(&[stop])?;
        let (q, v) = self.settled(&[stop])?;
        if self.kept.is_some() {
            let whole = self.scene.form.to_modal(&q, &v);
            self.keep_whole(&whole, SegmentKind::Chatter, &[stop], span);
        }
        let angle = self.clock.angle();
        record.sample(self.clock, span, None, |local| {
            motion.carry(angle, local, &q, &v)
        });
        Ok((motion, (q, v)))
    }

    /// Keeps a segment of one piece from the present state.
    pub(super) fn keep_piece(&mut self, kind: SegmentKind, stops: &[usize], span: f64) {
        if self.kept.is_some() {
            self.keep_whole(&self.whole(&self.state), kind, stops, span);
        }
    }

    fn keep_whole(&mut self, whole: &[Pair], kind: SegmentKind, stops: &[usize], span: f64) {
        if let Some(kept) = &mut self.kept {
            let clock = self.clock;
            kept.begin(kind, stops);
            kept.pieces.push(Piece { clock, span });
            kept.numbers.extend(whole.iter().flatten());
        }
    }
}

/// A touch on a flight that began at a time, as it is reported.
pub(super) fn reported(grazed: Grazed, start: Clock) -> Graze {
    Graze {
        time: start.after(grazed.time).time(),
        stop: grazed.stop,
        depth: -grazed.gap,
    }
}

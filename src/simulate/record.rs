//! What is kept of a run: impacts, touches, the motion at the times asked for.

use crate::impact::Impact;
use crate::simulate::clock::Clock;
use crate::simulate::options::{Keep, SimulateOptions};
use crate::simulate::trajectory::{Graze, Samples};
use crate::watch::is_broken_off;
use nalgebra::{DMatrix, DVector};

/// What is kept of a run, beside the motion itself.
pub(crate) struct Record {
    pub keep: Keep,
    pub impacts: Vec<Impact>,
    pub grazes: Vec<Graze>,
    samples: Option<Sampler>,
}

/// The motion at the times asked for, filled in flight by flight.
struct Sampler {
    times: Vec<f64>,
    next: usize,
    q: DMatrix<f64>,
    v: DMatrix<f64>,
}

impl Record {
    /// An empty record for a motion of n coordinates.
    pub fn new(options: &SimulateOptions, n: usize) -> Self {
        let sampler = |times: &Vec<f64>| Sampler {
            times: times.clone(),
            next: 0,
            q: DMatrix::zeros(times.len(), n),
            v: DMatrix::zeros(times.len(), n),
        };
        Self {
            keep: options.keep,
            impacts: Vec::new(),
            grazes: Vec::new(),
            samples: options.t_eval.as_ref().map(sampler),
        }
    }

    /// Whether nothing is kept beside the end of the run.
    #[inline]
    pub fn keeps_nothing(&self) -> bool {
        self.keep == Keep::Final && self.samples.is_none()
    }

    /// Whether the motion itself is kept, or samples of it.
    #[inline]
    pub fn keeps_motion(&self) -> bool {
        self.keep == Keep::Motion || self.samples.is_some()
    }

    /// The record, if it keeps anything of the motion itself.
    #[inline]
    pub fn keeping_motion(&mut self) -> Option<&mut Self> {
        self.keeps_motion().then_some(self)
    }

    /// Whether samples are wanted before the end of a piece, or at it if the run ends there, at `last`.
    pub fn wants_samples(&self, end: f64, last: Option<f64>) -> bool {
        let next = self.samples.as_ref().and_then(|s| s.times.get(s.next));
        next.is_some_and(|&t| t < end || last.is_some_and(|last| t <= last))
    }

    /// Takes the samples that fall into a piece of the motion: those before its end, and those at its end if the run ends
    /// there, at `last`. `state` gives the motion a time after the start of the piece. A piece of no length has no time
    /// before its end, whatever rounding makes of a time counted in periods.
    pub fn sample(
        &mut self,
        start: Clock,
        span: f64,
        last: Option<f64>,
        mut state: impl FnMut(f64) -> (DVector<f64>, DVector<f64>),
    ) {
        let Some(samples) = &mut self.samples else {
            return;
        };
        let end = if span > 0.0 {
            start.after(span).time()
        } else {
            f64::NEG_INFINITY
        };
        while let Some(&t) = samples
            .times
            .get(samples.next)
            .filter(|&&t| t < end || last.is_some_and(|last| t <= last))
        {
            if is_broken_off() {
                return;
            }
            let (q, v) = state(start.until(start.at(t)).clamp(0.0, span));
            samples.q.set_row(samples.next, &q.transpose());
            samples.v.set_row(samples.next, &v.transpose());
            samples.next += 1;
        }
    }

    /// The samples taken, fewer than asked for where the run ended early.
    pub fn finish(self) -> (Vec<Impact>, Vec<Graze>, Option<Samples>) {
        let taken = |mut s: Sampler| {
            s.times.truncate(s.next);
            (
                s.times,
                s.q.resize_vertically(s.next, 0.0),
                s.v.resize_vertically(s.next, 0.0),
            )
        };
        (self.impacts, self.grazes, self.samples.map(taken))
    }
}

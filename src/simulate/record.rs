//! What is kept of a run by its `keep` (`options.rs`): impacts, touches, the motion, or the motion at the times asked for.

use crate::hybrid::recorder::{ArcMotion, ArcSpan, Recorder, Wanted};
use crate::hybrid::{Graze, SegmentKind};
use crate::impact::Impact;
use crate::law::Regime;
use crate::observer::is_broken_off;
use crate::path::{AccumulationStart, PathParts, PathSegment, Samples};
use crate::simulate::contact_parts::ContactParts;
use crate::simulate::monitor::MonitorSlot;
use crate::simulate::options::{Keep, SimulateOptions};
use nalgebra::DMatrix;
use std::ops::ControlFlow;

/// What is kept of a run.
pub(crate) struct Record {
    pub keep: Keep,
    pub impacts: Vec<Impact>,
    grazes: Vec<Graze>,
    kept: Option<PathParts>,
    contacts: Option<ContactParts>,
    samples: Option<Sampler>,
    /// What inspects the run while it goes on, and may end it.
    pub monitor: MonitorSlot,
    /// Whether the next segment is a part of the last one.
    goes_on: bool,
    /// The time at which the run begins, of one that goes the flight again in which it does: what came before is known.
    pub since: f64,
}

/// What has been kept of a run that has ended.
pub(crate) struct Recorded {
    pub impacts: Vec<Impact>,
    pub grazes: Vec<Graze>,
    pub samples: Option<Samples>,
    pub kept: Option<PathParts>,
    /// What its contacts are read from, of a run that keeps its impacts alone.
    pub contacts: Option<(PathParts, Vec<AccumulationStart>)>,
}

/// The motion at the times asked for, filled in flight by flight.
struct Sampler {
    times: Vec<f64>,
    next: usize,
    q: DMatrix<f64>,
    v: DMatrix<f64>,
}

impl Record {
    /// An empty record for a motion of n coordinates; whether what comes before contacts counts.
    pub fn new(options: &SimulateOptions, (n, has_sides): (usize, bool)) -> Self {
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
            kept: (options.keep == Keep::Motion).then(PathParts::default),
            contacts: (options.keep == Keep::Impacts).then(|| ContactParts::new(has_sides)),
            samples: options.t_eval.as_ref().map(sampler),
            monitor: MonitorSlot::default(),
            goes_on: false,
            since: f64::NEG_INFINITY,
        }
    }

    /// The part of an arc from where the run begins on, and how far along it that begins; none of one that ends before.
    fn part_of_run(&self, arc: &ArcSpan) -> Option<(ArcSpan, f64)> {
        if arc.start.time() >= self.since {
            return Some((*arc, 0.0));
        }
        let end = arc.start.after(arc.span);
        (end.time() > self.since || arc.last.is_some()).then(|| {
            let start = arc.start.at(self.since);
            let span = start.until(end).max(0.0);
            let local = arc.start.until(start).min(arc.span);
            (
                ArcSpan {
                    start,
                    span,
                    ..*arc
                },
                local,
            )
        })
    }

    /// Keeps what is wanted of an arc.
    fn keep_arc(&mut self, arc: &ArcSpan, motion: &mut dyn ArcMotion) {
        if let Some((part, local)) = self.part_of_run(arc) {
            let mut write = |numbers: &mut Vec<f64>| {
                if local > 0.0 {
                    motion.write_later(local, numbers);
                } else {
                    motion.write(numbers);
                }
            };
            if let Some(kept) = &mut self.kept {
                kept.push_later(&part, &mut write);
            }
            if let Some(contacts) = &mut self.contacts {
                contacts.push(&part, &mut write);
            }
        } else if let Some(kept) = &mut self.kept {
            kept.take_back();
        }
    }

    /// Takes the samples that fall into a piece of the motion: those before its end, and those at its end if the run ends
    /// there. A piece of no length has no time before its end, whatever rounding makes of a time counted in periods.
    fn sample(&mut self, &ArcSpan { start, span, last }: &ArcSpan, motion: &mut dyn ArcMotion) {
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
            let (q, v) = motion.state(start.until(start.at(t)).clamp(0.0, span));
            let row = samples.next;
            for (j, (q, v)) in q.iter().zip(&v).enumerate() {
                (samples.q[(row, j)], samples.v[(row, j)]) = (*q, *v);
            }
            samples.next += 1;
        }
    }

    /// Shows the monitor the states of an arc at the times that it asked for.
    fn inspect_arc(&mut self, &ArcSpan { start, span, .. }: &ArcSpan, motion: &mut dyn ArcMotion) {
        let MonitorSlot { monitor, is_done } = &mut self.monitor;
        let Some(monitor) = monitor else {
            return;
        };
        let end = start.after(span).time();
        if span <= 0.0 || *is_done || monitor.next() >= end {
            return;
        }
        let first = start.until(start.at(monitor.next())).clamp(0.0, span);
        motion.strobe([first, monitor.every()], &mut |state| {
            *is_done = monitor.inspect(state).is_break();
            if *is_done || monitor.next() >= end {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
    }

    /// What has been kept; samples are fewer than asked for where the run ended early.
    pub fn finish(self) -> Recorded {
        let taken = |mut s: Sampler| {
            s.times.truncate(s.next);
            (
                s.times,
                s.q.resize_vertically(s.next, 0.0),
                s.v.resize_vertically(s.next, 0.0),
            )
        };
        Recorded {
            impacts: self.impacts,
            grazes: self.grazes,
            samples: self.samples.map(taken),
            kept: self.kept,
            contacts: self.contacts.map(ContactParts::finish),
        }
    }
}

impl Recorder for Record {
    fn wanted(&self) -> Wanted {
        Wanted {
            events: self.keep != Keep::Final,
            arcs: self.kept.is_some()
                || self.samples.is_some()
                || self.monitor.monitor.is_some()
                || self.contacts.as_ref().is_some_and(ContactParts::wants_free),
            contacts: self.contacts.is_some(),
        }
    }

    fn begin_segment(&mut self, kind: SegmentKind, regime: &Regime) {
        let goes_on = std::mem::take(&mut self.goes_on);
        if let Some(contacts) = &mut self.contacts {
            contacts.begin(kind, regime, goes_on);
        }
        if let Some(kept) = &mut self.kept {
            let is_same = |last: &PathSegment| last.kind == kind && last.regime == *regime;
            if !(goes_on && kept.segments.last().is_some_and(is_same)) {
                kept.begin(kind, regime);
            }
        }
    }

    fn impact(&mut self, impact: Impact) {
        self.impacts.push(impact);
        if let Some(contacts) = &mut self.contacts {
            contacts.note_impact();
        }
    }

    fn accumulation(&mut self, time: f64, stop: usize, approach: f64) {
        if let Some(contacts) = &mut self.contacts {
            contacts.note_accumulation((time, stop, approach));
        }
    }

    fn continue_segment(&mut self) {
        self.goes_on = true;
    }

    fn wants_arc(&self, ArcSpan { start, span, last }: &ArcSpan) -> bool {
        let next = || self.samples.as_ref().and_then(|s| s.times.get(s.next));
        let is_sampled =
            |&t: &f64| t < start.after(*span).time() || last.is_some_and(|last| t <= last);
        self.kept.is_some()
            || self.contacts.as_ref().is_some_and(ContactParts::wants_arc)
            || next().is_some_and(is_sampled)
            || self.monitor.wants_before(start.after(*span).time())
    }

    fn arc(&mut self, arc: &ArcSpan, motion: &mut dyn ArcMotion) {
        self.keep_arc(arc, motion);
        self.sample(arc, motion);
        self.inspect_arc(arc, motion);
    }

    fn is_satisfied(&self) -> bool {
        self.monitor.is_done
    }

    fn graze(&mut self, graze: Graze) {
        if graze.time > self.since {
            self.grazes.push(graze);
        }
    }
}

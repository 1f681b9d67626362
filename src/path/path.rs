//! A motion that is kept: arcs in time, and what evaluates them; of a trajectory, or one period of an orbit.

use crate::error::{Error, Result};
use crate::law::Regime;
use crate::model::PhysicalState;
use crate::path::evaluator::Evaluator;
use crate::path::parts::{PathArc, PathParts, PathPoint};
use crate::path::segments::{ImpactSide, Stretch};

/// Refuses a time outside the span of a motion.
pub(crate) fn check_time(t: f64, (start, end): (f64, f64)) -> Result<()> {
    let slack = 4.0 * f64::EPSILON * start.abs().max(end.abs());
    if (start - slack..=end + slack).contains(&t) {
        return Ok(());
    }
    let rule = format!("it must lie in the span [{start}, {end}] of the trajectory");
    Err(Error::bad_value("t", t, rule))
}

/// A motion that is kept.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    pub evaluator: Evaluator,
    pub parts: PathParts,
    pub span: (f64, f64),
    pub n_dof: usize,
}

impl Path {
    /// The parts of the motion, each once, with the stops in contact.
    pub fn stretches(&self) -> Vec<Stretch<'_>> {
        let parts = &self.parts;
        let within = |time: f64| time.clamp(self.span.0, self.span.1);
        let mut all = Vec::with_capacity(parts.segments.len());
        for (k, segment) in parts.segments.iter().enumerate() {
            let range = parts.arcs_of(k);
            let arcs = &parts.arcs[range.clone()];
            let next = parts
                .arcs
                .get(range.end)
                .filter(|_| parts.follows(range.end));
            let (Some(first), Some(last)) = (arcs.first(), arcs.last()) else {
                continue;
            };
            // A flight of no length is a side of an impact, but where there is nothing else.
            let is_last = k + 1 == parts.segments.len() && all.is_empty();
            let is_side = arcs.iter().all(|p| p.span == 0.0) && !is_last;
            if segment.regime.is_free() && is_side {
                continue;
            }
            // A part ends where the next one begins, to the last digit.
            let end = next.map_or_else(|| last.clock.after(last.span), |next| next.clock);
            all.push(Stretch {
                segment: k,
                kind: segment.kind,
                regime: &segment.regime,
                start: within(first.clock.time()),
                end: within(end.time()),
            });
        }
        // The last one ends with the run, of which its clock knows the time to rounding.
        let end = self.span.1;
        let is_rounding = |t: f64| (t - end).abs() <= 4.0 * f64::EPSILON * end.abs();
        let is_last = |last: &&mut Stretch<'_>| !parts.has_gaps || is_rounding(last.end);
        if let Some(last) = all.last_mut().filter(is_last) {
            last.end = end;
        }
        all
    }

    /// Where a time inside the span is.
    ///
    /// # Errors
    /// A time outside the span.
    pub fn point(&self, t: f64, side: ImpactSide) -> Result<PathPoint> {
        let parts = &self.parts;
        check_time(t, self.span)?;
        let start_of = |index: usize| parts.arcs[index].clock.time();
        let (now, mut arc) = self.arc_at(t);
        if side == ImpactSide::Before {
            // Stops hit one after the other at one instant leave arcs of no length: go back to the first.
            while arc > 0 && start_of(arc) == now {
                arc -= 1;
                if start_of(arc) < now {
                    return Ok(self.end_of(arc, t));
                }
            }
        }
        let local = parts.arcs[arc].local(t);
        Ok(PathPoint {
            time: t,
            arc,
            local,
        })
    }

    /// The end of an arc, at a time.
    pub fn end_of(&self, arc: usize, time: f64) -> PathPoint {
        let local = self.parts.arcs[arc].span;
        PathPoint { time, arc, local }
    }

    /// The last arc that begins no later than a time, and that time on the clock of the arcs, whose ends may be off those of
    /// the span by rounding.
    #[inline]
    pub fn arc_at(&self, t: f64) -> (f64, usize) {
        let parts = &self.parts;
        let ends = (parts.arcs[0], parts.arcs[parts.arcs.len() - 1]);
        let t = if t >= self.span.1 && t > self.span.0 {
            ends.1.clock.after(ends.1.span).time()
        } else if t <= self.span.0 {
            ends.0.clock.time()
        } else {
            t
        };
        let first_later = parts.arcs.partition_point(|p| p.clock.time() <= t);
        (t, first_later.max(1) - 1)
    }

    /// Position and velocity a time after the start of an arc.
    #[inline]
    pub fn state_in(&self, arc: usize, local: f64) -> PhysicalState {
        let segment = self.parts.segment_of(arc);
        let width = self.evaluator.width(&segment.regime, self.n_dof);
        let numbers = self.parts.numbers_of(segment, arc, width);
        self.evaluator
            .state(&segment.regime, self.parts.arcs[arc].clock, numbers, local)
    }

    /// Where a time after the start of a segment is.
    pub fn point_along(&self, segment: usize, local: f64) -> PathPoint {
        let range = self.parts.arcs_of(segment);
        let arcs = &self.parts.arcs[range.clone()];
        let start = arcs[0].clock;
        let within = |arc: &PathArc| start.until(arc.clock) <= local;
        let k = arcs.partition_point(within).max(1) - 1;
        let rest = local - start.until(arcs[k].clock);
        PathPoint {
            time: start.after(local).time(),
            arc: range.start + k,
            local: rest.min(arcs[k].span),
        }
    }

    /// An arc.
    pub fn arc(&self, arc: usize) -> PathArc {
        self.parts.arcs[arc]
    }

    /// The regime of the motion along an arc.
    pub fn regime_of(&self, arc: usize) -> &Regime {
        &self.parts.segment_of(arc).regime
    }

    /// Whether an arc is the rest of impacts that accumulate.
    pub fn is_rest(&self, arc: usize) -> bool {
        self.parts.segment_of(arc).accumulation().is_some()
    }
}

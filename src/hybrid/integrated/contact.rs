//! Contacts along one Runge-Kutta step: the first one on the quintics of the gaps, and the step to it.

use super::scene::{Integrated, MOST_POLISHES};
use crate::contact::curvature::{BoundedGap, first_crossing};
use crate::contact::first_root::{FirstEvent, FirstRoot};
use crate::contact::polynomial::{EndValues, Judgement, Quintic};
use crate::error::Result;

use crate::flow::steps::{DenseOutput, State, Stepper};
use crate::hybrid::segment::Graze;
use crate::hybrid::system::Gaps;
use crate::model::{Dynamics, GapValue};
use crate::tolerance::{SAME_TOUCH, TERM_ROUNDINGS};
use std::sync::Arc;

/// A correction below this part of the step, times the root of the relative tolerance, moves the state by its Taylor series
/// of second order: the velocity is then wrong by 5e-5 of the tolerance.
const TAYLOR_PART: f64 = 1e-2;

/// A minimum is where the interpolation says, but for this part of the step.
const LOWEST_NEAR: f64 = 0.25;

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// The earliest contact along the step last taken, as a part of the step, or before it a minimum that the interpolation cannot
    /// tell from one; touches before that are noted.
    #[allow(
        clippy::inline_always,
        reason = "the innermost loop of flights with and without stops held"
    )]
    #[inline(always)]
    pub(super) fn contact_along<E: Dynamics, const IS_HELD: bool>(
        &mut self,
        dynamics: &E,
        orders: Option<&[usize]>,
        h: f64,
    ) -> Result<FirstEvent> {
        let mut first = FirstEvent::NONE;
        let noted = self.grazes.len();
        for stop in 0..self.contacts.len() {
            if IS_HELD && self.is_bound[stop] {
                continue;
            }
            let (start, end) = (self.gaps[stop], self.ahead[stop]);
            let known = |g: GapValue| [g.gap, g.speed, g.acceleration];
            let order = orders.map_or(0, |orders| orders[stop]);
            let mut ends = [known(start), known(end)];
            ends[1][0] -= self.departed(stop, order);
            let ends = EndValues::new(ends[0], ends[1], h, order);
            // The error of the interpolation is of the size of the step's tolerance, a tenth of the margin.
            let margin = self.margin_of(start).max(self.margin_of(end));
            let is_clear = if P::HAS_QUINTIC {
                ends.are_clear(order, 2.0 * margin)
            } else {
                order == 0 && ends.are_far(2.0 * margin)
            };
            if is_clear && self.contacts[stop].surface.bounded().is_none() {
                continue;
            }
            let root = self.judge(dynamics, (stop, order), &ends, (is_clear, margin), h)?;
            first.note(stop, root);
        }
        if first.root != FirstRoot::None {
            let time = self.clock.after(first.root.at() * h).time();
            let mut at = 0;
            self.grazes.retain(|graze| {
                at += 1;
                at <= noted || graze.time < time
            });
        }
        Ok(first)
    }

    /// What a gap that is not clear at once does along the step last taken.
    #[inline(never)]
    fn judge<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, order): (usize, usize),
        ends: &EndValues,
        (is_clear, margin): (bool, f64),
        h: f64,
    ) -> Result<FirstRoot> {
        let quintic = Quintic::new(ends);
        let along = if is_clear {
            FirstRoot::None
        } else {
            let size = self.gaps[stop].size.max(self.ahead[stop].size);
            let judgement = Judgement {
                rounding: TERM_ROUNDINGS * size,
                error: self.interpolation_error(dynamics, stop, &quintic, h)?,
            };
            self.touches.clear();
            let along = quintic.first_contact(order, judgement, &mut self.touches);
            self.note_touches(stop, h);
            // Of a stop left more slowly than a quintic tells it counts that it stays within the tolerance.
            let is_near = |x: f64| quintic.value(x).abs() <= self.tolerance(stop, size);
            let is_late = order > 0 && matches!(along, FirstRoot::Undecided { .. });
            if is_late && [0.0, 0.5, 1.0].into_iter().all(is_near) {
                FirstRoot::None
            } else {
                along
            }
        };
        self.proved(dynamics, (stop, along), margin, h)
    }

    /// Notes the touches along the step last taken; one that was noted where the step before ended is the same.
    fn note_touches(&mut self, stop: usize, h: f64) {
        for &(x, gap) in &self.touches {
            let time = self.clock.after(x * h).time();
            let is_same = |g: &Graze| g.stop == stop && (time - g.time).abs() <= SAME_TOUCH * h;
            if !self.grazes.iter().any(is_same) {
                let depth = -gap;
                self.grazes.push(Graze { time, stop, depth });
            }
        }
    }

    /// What the quintic of a gap says of the step last taken, put right where the gap has a bound that proves it.
    fn proved<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, along): (usize, FirstRoot),
        margin: f64,
        h: f64,
    ) -> Result<FirstRoot> {
        let contacts = Arc::clone(&self.contacts);
        let Some((nonlinear, curvature)) = contacts[stop].surface.bounded() else {
            return Ok(along);
        };
        let until = along.at().min(1.0);
        let dense = self.dense(dynamics, h)?;
        let path: Vec<Vec<f64>> = (0..self.n()).map(|i| dense.powers(i)).collect();
        let begun = self.moment();
        let motion = contacts[stop].motion.as_ref();
        let moved = |x: f64| {
            let [value, speed, _] = motion?.along(begun.after(x * h));
            Some([value, h * speed])
        };
        let gap = BoundedGap {
            stop: nonlinear,
            curvature,
            moved: &moved,
            bend: motion.map_or(0.0, |motion| h * h * motion.bend_bound(begun, h)),
        };
        // The path itself is known to the tolerance, a tenth of the margin.
        let found = first_crossing(&gap, &path, 0.1 * margin, until)?;
        Ok(found.map_or(along, |x| FirstRoot::Crossing { at: x, passed: 1.0 }))
    }

    /// The difference of the quintic to the dense output half-way.
    fn interpolation_error<E: Dynamics>(
        &mut self,
        dynamics: &E,
        stop: usize,
        quintic: &Quintic,
        h: f64,
    ) -> Result<f64> {
        let n = self.n();
        let mut x = S::zeros(2 * n);
        let dense = self.dense(dynamics, h)?;
        dense.state(0.5 * h, x.slice_mut());
        self.n_gap_evaluations += 1;
        let half_way = self.moment().after(0.5 * h);
        let there = self.contacts[stop].gap(&x.slice()[..n], half_way)?;
        Ok((there - quintic.value(0.5)).abs())
    }

    /// The gap that a flight left with, where it left a stop: rounding, or up to the margin where the run began so deep. It
    /// returns to that: to zero it would have no way, if it is lower.
    fn departed(&self, stop: usize, order: usize) -> f64 {
        if order > 0 { self.gaps[stop].gap } else { 0.0 }
    }

    /// Steps to the contact itself: the step is taken again, its length corrected until the gap vanishes, whose root of some order
    /// at the start is not meant; the stop is `passed` at a length beyond. Returns the length, none where no step can be taken; the
    /// stepper's end is the state there.
    pub(super) fn land<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, order): (usize, usize),
        (guess, passed): (f64, f64),
        h: f64,
    ) -> Result<Option<f64>> {
        let n = self.n();
        let mut s = guess;
        let (mut open, mut closed) = (0.0, passed);
        let departed = self.departed(stop, order);
        let small = TAYLOR_PART * self.tolerance.relative.sqrt() * h;
        for _ in 0..MOST_POLISHES {
            if !self.step(dynamics, s)? {
                return Ok(None);
            }
            self.evaluate_gaps_ahead(s, h)?;
            let GapValue {
                gap,
                speed,
                acceleration,
                size,
                ..
            } = self.ahead[stop];
            let gap = gap - departed;
            if gap > 0.0 {
                open = s;
            } else {
                closed = s;
            }
            let correction = if order == 0 {
                -gap / (speed - 0.5 * acceleration * gap / speed)
            } else {
                // The root at the start is divided out: else a low flight would land where it began, or before.
                -gap / (speed - order as f64 * gap / s)
            };
            let is_inside = speed < 0.0 && (open..=closed).contains(&(s + correction));
            if is_inside && correction.abs() <= small {
                let rate = self.stepper.end_rate().clone();
                let (q, v) = self.stepper.end_mut().slice_mut().split_at_mut(n);
                for i in 0..n {
                    let a = rate.slice()[n + i];
                    q[i] += correction * (v[i] + 0.5 * correction * a);
                    v[i] += correction * a;
                }
                return Ok(Some(s + correction));
            }
            // Half the way is no sign that the contact is near, but where nothing is left of it.
            let next = if is_inside {
                s + correction
            } else {
                0.5 * (open + closed)
            };
            if next == s || gap.abs() <= f64::EPSILON * size {
                return Ok(Some(s));
            }
            s = next;
        }
        Ok(self.step(dynamics, s)?.then_some(s))
    }

    /// The length of the step at whose end a gap is lowest, by Newton's method on its speed with steps of their own; none where it
    /// is not found near the guess.
    #[cold]
    pub(super) fn descend<E: Dynamics>(
        &mut self,
        dynamics: &E,
        stop: usize,
        guess: f64,
        h: f64,
    ) -> Result<Option<f64>> {
        let mut s = guess;
        for _ in 0..MOST_POLISHES {
            if !self.step(dynamics, s)? {
                return Ok(None);
            }
            self.evaluate_gaps_ahead(s, h)?;
            let GapValue {
                speed,
                acceleration,
                size,
                ..
            } = self.ahead[stop];
            let correction = -speed / acceleration;
            let is_near = acceleration > 0.0 && correction.abs() <= LOWEST_NEAR * h;
            let next = s + correction;
            if !is_near || next <= 0.0 || next > h {
                return Ok(None);
            }
            if (speed * correction).abs() <= f64::EPSILON * size {
                return Ok(Some(s));
            }
            s = next;
        }
        Ok(None)
    }
}

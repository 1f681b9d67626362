//! Contacts along one Runge-Kutta step: the first one on the quintics of the gaps, and the step to it.

use super::FreeFlight;
use super::{MOST_POLISHES, StepMover};
use crate::contact::curvature::first_crossing;
use crate::contact::polynomial::{Along, Ends, Judgement, Quintic};
use crate::error::Result;
use crate::flow::runge_kutta::State;
use crate::model::{Dynamics, GapValue};
use crate::simulate::trajectory::Graze;

/// A correction below this part of the step, times the root of the relative tolerance, moves the state by its Taylor series
/// of second order: the velocity is then wrong by 5e-5 of the tolerance.
const TAYLOR_PART: f64 = 1e-2;

/// What the gaps do along a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Found {
    Nothing,
    /// The earliest contact, at a part x of the step.
    Contact {
        stop: usize,
        x: f64,
    },
    /// The interpolation cannot tell contact from none.
    Undecided,
}

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'_, S, D, F> {
    /// The earliest contact along the step last taken, as a part of the step; touches before it are noted.
    #[allow(
        clippy::inline_always,
        reason = "the innermost loop of flights with and without stops held"
    )]
    #[inline(always)]
    pub(super) fn contact_along<const IS_HELD: bool>(
        &mut self,
        starts: Option<&[usize]>,
        h: f64,
    ) -> Result<Found> {
        let mut earliest: Option<(usize, f64)> = None;
        let noted = self.grazes.len();
        for stop in 0..self.contacts.len() {
            if IS_HELD && self.holding.contains(&stop) {
                continue;
            }
            let (start, end) = (self.gaps[stop], self.ahead[stop]);
            let known = |g: GapValue| [g.gap, g.speed, g.acceleration];
            let margin = self.margin_of(start).max(self.margin_of(end));
            let order = starts.map_or(0, |orders| orders[stop]);
            let mut ends = [known(start), known(end)];
            ends[1][0] -= self.departed(stop, order);
            let ends = Ends::new(ends[0], ends[1], h, order);
            // The error of the interpolation is of the size of the step's tolerance, a tenth of the margin.
            let is_clear = ends.are_clear(order, 2.0 * margin);
            if is_clear && self.contacts[stop].surface.bounded().is_none() {
                continue;
            }
            let quintic = Quintic::new(&ends);
            let along = if is_clear {
                Along::Clear
            } else if order > 0 {
                quintic.after_contact(order)
            } else {
                let error = self.interpolation_error(stop, &quintic, h)?;
                self.touches.clear();
                let along = quintic.when_open(Judgement { margin, error }, &mut self.touches);
                for &(x, gap) in &self.touches {
                    self.grazes.push(Graze {
                        time: self.clock.after(x * h).time(),
                        stop,
                        depth: -gap,
                    });
                }
                along
            };
            match self.proved(stop, along, margin, h)? {
                Along::Unsure => {
                    self.grazes.truncate(noted);
                    return Ok(Found::Undecided);
                }
                Along::Contact { x } if earliest.is_none_or(|(_, first)| x < first) => {
                    earliest = Some((stop, x));
                }
                Along::Clear | Along::Contact { .. } => {}
            }
        }
        if let Some((_, x)) = earliest {
            let time = self.clock.after(x * h).time();
            let mut at = 0;
            self.grazes.retain(|graze| {
                at += 1;
                at <= noted || graze.time < time
            });
        }
        Ok(earliest.map_or(Found::Nothing, |(stop, x)| Found::Contact { stop, x }))
    }

    /// What the quintic of a gap says of the step last taken, put right where the gap has a bound that proves it.
    fn proved(&self, stop: usize, along: Along, margin: f64, h: f64) -> Result<Along> {
        let Some((nonlinear, curvature)) = self.contacts[stop].surface.bounded() else {
            return Ok(along);
        };
        let until = match along {
            Along::Contact { x } => x,
            Along::Clear | Along::Unsure => 1.0,
        };
        let dense = self.stepper.dense(&self.x, h);
        let path: Vec<[f64; 5]> = (0..self.n()).map(|i| dense.powers(i)).collect();
        Ok(
            match first_crossing(nonlinear, curvature, &path, margin, until)? {
                Some(x) => Along::Contact { x },
                None if along == Along::Unsure => Along::Clear,
                None => along,
            },
        )
    }

    /// The difference of the quintic to the dense output half-way.
    fn interpolation_error(&mut self, stop: usize, quintic: &Quintic, h: f64) -> Result<f64> {
        let n = self.n();
        let mut x = S::zeros(2 * n);
        self.stepper.dense(&self.x, h).state(0.5 * h, x.slice_mut());
        self.n_gap_evaluations += 1;
        let there = self.contacts[stop].surface.gap(&x.slice()[..n])?;
        Ok((there - quintic.value(0.5)).abs())
    }

    /// The gap that a flight left with, where it left a stop: rounding, or up to the margin where the stop had been passed
    /// before it was found. It returns to that: to zero it would have no way, if it is lower.
    fn departed(&self, stop: usize, order: usize) -> f64 {
        if order > 0 { self.gaps[stop].gap } else { 0.0 }
    }

    /// Steps to the contact itself: the step is taken again, its length corrected until the gap vanishes, whose root of some order
    /// at the start is not meant. Returns the length; the stepper's end is the state there.
    pub(super) fn land<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, order): (usize, usize),
        guess: f64,
        h: f64,
    ) -> Result<f64> {
        let n = self.n();
        // Time does not go back for a stop that was passed by less than its margin when the step began.
        let mut s = guess.max(0.0);
        let departed = self.departed(stop, order);
        let small = TAYLOR_PART * self.tolerance.relative.sqrt() * h;
        for _ in 0..MOST_POLISHES {
            self.step(dynamics, s)?;
            self.look_ahead(h)?;
            let GapValue {
                gap,
                speed,
                acceleration,
                ..
            } = self.ahead[stop];
            if speed >= 0.0 {
                return Ok(s);
            }
            let gap = gap - departed;
            let correction = if order == 0 {
                -gap / (speed - 0.5 * acceleration * gap / speed)
            } else {
                // The root at the start is divided out: else a low flight would land where it began, or before.
                -gap / (speed - order as f64 * gap / s)
            };
            if !correction.is_finite() {
                return Ok(s);
            }
            // Time does not go back for a stop that was passed by less than its margin when the step began.
            let correction = correction.max(-s);
            s += correction;
            if correction.abs() <= small {
                let rate = self.stepper.end_rate().clone();
                let (q, v) = self.stepper.end.slice_mut().split_at_mut(n);
                for i in 0..n {
                    let a = rate.slice()[n + i];
                    q[i] += correction * (v[i] + 0.5 * correction * a);
                    v[i] += correction * a;
                }
                return Ok(s);
            }
        }
        Ok(s)
    }
}

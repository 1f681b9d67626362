//! Locating an event on the step last taken: the step is taken again with another length \[s\], to a contact, a release, or the minimum of a
//! gap.

use super::scene::{Integrated, MOST_RETAKEN_STEPS};
use crate::error::Result;
use crate::event::certified::SearchFailure;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::flow::Arrival;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::Gaps;
use crate::model::{Dynamics, GapValue};
use crate::tolerance::{LOWEST_NEAR_GUESS, TAYLOR_STEP_PART};

/// The result of locating a contact.
enum ContactLocation {
    /// The gap is zero at this length of the step.
    At(f64),
    /// No step can be taken to it.
    NoStep,
    /// The gap is zero nowhere there.
    Nowhere,
}

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Widens the extent of a gap by its value half-way to a contact at the end of a step of length s, from the cubic with the speeds at both
    /// ends.
    fn note_extent(&mut self, stop: usize, s: f64, speed: f64) {
        let start = self.gaps[stop];
        let far = 0.5 * start.gap + 0.125 * s * (start.speed - speed);
        self.extents[stop] = self.extents[stop].max(far.abs());
    }

    /// Steps to where a force that is watched is zero, near a part x of the step last taken.
    pub(super) fn arrive_at_release<E: Dynamics>(
        &mut self,
        dynamics: &E,
        guard: usize,
        (x, h): (f64, f64),
        recorder: &mut dyn Recorder,
    ) -> Result<Arrival> {
        let Some(s) = self.let_go(dynamics, guard, x * h, h)? else {
            return Ok(Arrival::Underflow);
        };
        self.record(dynamics, s, None, recorder)?;
        self.arrive(s);
        self.settle()?;
        self.evaluate_gaps()?;
        Ok(Arrival::Event {
            guard: self.force_guards[guard],
        })
    }

    /// Steps to the contact of a stop, near a part x of the step last taken and before another, `passed`; `orders` are those of the
    /// zeros of the gaps where the step began. None where the gap is zero nowhere.
    pub(super) fn arrive_at_contact<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (mut stop, orders): (usize, Option<&[usize]>),
        (x, passed, h): (f64, f64, f64),
        recorder: &mut dyn Recorder,
    ) -> Result<Option<Arrival>> {
        let order = |stop: usize| orders.map_or(0, |orders| orders[stop]);
        // The speed that a contact will have is known from the ends of the step, but where these say little.
        let (from, to) = (self.gaps[stop].speed, self.ahead[stop].speed);
        let is_known = !self.says_little(stop, h);
        if is_known {
            self.note_extent(stop, x * h, from + x * (to - from));
        }
        let mut landed = self.land(dynamics, (stop, order(stop)), (x * h, passed * h), h)?;
        let s = loop {
            match landed {
                ContactLocation::NoStep => return Ok(Some(Arrival::Underflow)),
                ContactLocation::Nowhere => {
                    self.doubt = Some((stop, SearchFailure::Jumps));
                    return Ok(None);
                }
                ContactLocation::At(s) => match self.passed_beside(stop, orders) {
                    None => break s,
                    Some(other) => {
                        stop = other;
                        landed = self.land(dynamics, (stop, order(stop)), (0.5 * s, s), h)?;
                    }
                },
            }
        };
        if !is_known {
            self.note_extent(stop, s, self.ahead[stop].speed);
        }
        self.record(dynamics, s, None, recorder)?;
        self.arrive(s);
        if !self.regime.is_free() {
            self.settle()?;
        }
        self.evaluate_gaps_on_arrival()?;
        Ok(Some(Arrival::Event {
            guard: self.watched_guard(stop),
        }))
    }

    /// Steps to the contact itself: the step is taken again, its length corrected until the gap vanishes, whose root of some order
    /// at the start is not meant; the stop is `passed` at a length beyond. The stepper's end is the state there.
    fn land<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, order): (usize, usize),
        (guess, passed): (f64, f64),
        h: f64,
    ) -> Result<ContactLocation> {
        let n = self.n();
        let mut s = guess;
        // Until the gap has been seen to be passed it may be so a little later.
        let (mut open, mut closed, mut limit) = (0.0, passed, h.min(2.0 * passed - guess));
        let departed = self.departed(stop, order);
        let small = TAYLOR_STEP_PART * self.tolerance.relative.sqrt() * h;
        let is_nonlinear = self.contacts[stop].surface.is_nonlinear();
        for _ in 0..MOST_RETAKEN_STEPS {
            if !self.step(dynamics, s)? {
                return Ok(ContactLocation::NoStep);
            }
            self.evaluate_gaps_ahead(s, h)?;
            let value = self.ahead[stop];
            let GapValue {
                speed,
                acceleration,
                size,
                ..
            } = value;
            let gap = value.gap - departed;
            if gap > 0.0 {
                open = s;
            } else {
                (closed, limit) = (s, s);
            }
            let correction = if order == 0 {
                -gap / (speed - 0.5 * acceleration * gap / speed)
            } else {
                // The root at the start is divided out: else a low flight would land where it began, or before.
                -gap / (speed - order as f64 * gap / s)
            };
            let is_inside = speed < 0.0 && (open..=limit).contains(&(s + correction));
            let margin = self.margin_of(value);
            // A step says nothing of how soon a nonlinear gap bends.
            let is_near = !is_nonlinear || gap.abs() <= 0.1 * margin;
            if is_inside && correction.abs() <= small && is_near {
                let rate = self.stepper.end_rate().clone();
                let (q, v) = self.stepper.end_mut().slice_mut().split_at_mut(n);
                for i in 0..n {
                    let a = rate.slice()[n + i];
                    q[i] += correction * (v[i] + 0.5 * correction * a);
                    v[i] += correction * a;
                }
                return Ok(ContactLocation::At(s + correction));
            }
            // Half the way is no sign that the contact is near, but where nothing is left of it.
            let next = if is_inside {
                s + correction
            } else {
                0.5 * (open + closed.max(open))
            };
            if next == s || gap.abs() <= f64::EPSILON * size {
                return Ok(if gap.abs() <= margin {
                    ContactLocation::At(s)
                } else {
                    ContactLocation::Nowhere
                });
            }
            s = next;
        }
        if !self.step(dynamics, s)? {
            return Ok(ContactLocation::NoStep);
        }
        self.evaluate_gaps_ahead(s, h)?;
        let gap = self.ahead[stop].gap - departed;
        Ok(if gap.abs() <= self.margin_of(self.ahead[stop]) {
            ContactLocation::At(s)
        } else {
            ContactLocation::Nowhere
        })
    }

    /// A stop that is passed where the step last taken, of length s, has landed on another: it was reached before. `orders` are those of
    /// the zeros at the start.
    fn passed_beside(&self, stop: usize, orders: Option<&[usize]>) -> Option<usize> {
        (0..self.contacts.len()).find(|&other| {
            let value = self.ahead[other];
            let order = orders.map_or(0, |orders| orders[other]);
            let is_unwatched = !self.regime.is_free() && self.is_unwatched[other];
            let fallen = value.gap - self.departed(other, order) + self.margin_of(value);
            other != stop && !is_unwatched && fallen < 0.0 && self.gaps[other].gap > value.gap
        })
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
        for _ in 0..MOST_RETAKEN_STEPS {
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
            let is_near = acceleration > 0.0 && correction.abs() <= LOWEST_NEAR_GUESS * h;
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

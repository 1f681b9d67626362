//! The second and third derivative of a gap of any scene in a regime, the third by differences.

use super::scene::Integrated;

use crate::error::Result;
use crate::flow::RegimeDynamics;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::clock::Clock;
use crate::hybrid::system::{Accelerations, Contacts};
use crate::law::Regime;
use crate::model::Dynamics;
use crate::tolerance::{GAP_ROUNDING, JERK_ROUNDING, JERK_STEP, JERK_STEPS};

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// The acceleration of a gap in a regime, and what rounding leaves unknown of it.
    pub(super) fn drawn(&self, stop: usize, regime: &Regime) -> Result<[f64; 2]> {
        let motion = self.motion_in(regime);
        let (_, acceleration) = self.bend(&motion, stop, self.x.slice(), self.clock)?;
        let unknown = GAP_ROUNDING * self.acceleration_sizes(&[stop])?[0];
        Ok([acceleration, unknown])
    }

    /// The acceleration of a motion at a state, and that of a gap.
    fn bend(
        &self,
        motion: &RegimeDynamics<'_, D>,
        stop: usize,
        x: &[f64],
        clock: Clock,
    ) -> Result<(Vec<f64>, f64)> {
        let (q, v) = x.split_at(self.n());
        let mut a = vec![0.0; q.len()];
        motion.acceleration(clock.moment(self.phase), q, v, &mut a)?;
        let at = || clock.moment(self.phase);
        let gap = self.contacts[stop].along(at, (q, v, &a), JERK_STEP * self.slow_time())?;
        Ok((a, gap.acceleration))
    }

    /// The present state a short time later, along a motion.
    pub(super) fn drifted(&self, motion: &RegimeDynamics<'_, D>, step: f64) -> Result<S> {
        let n = self.n();
        let (q, v) = self.x.slice().split_at(n);
        let mut a = vec![0.0; n];
        motion.acceleration(self.moment(), q, v, &mut a)?;
        Ok(self.moved(&a, step))
    }

    /// The present state a short time later, under an acceleration.
    fn moved(&self, a: &[f64], step: f64) -> S {
        let mut ahead = self.x.clone();
        let n = a.len();
        let (q, v) = ahead.slice_mut().split_at_mut(n);
        for i in 0..n {
            q[i] += step * (v[i] + 0.5 * step * a[i]);
            v[i] += step * a[i];
        }
        ahead
    }

    /// The third derivative of a gap in a regime, and what rounding leaves unknown of it.
    pub(super) fn jerk(&self, stop: usize, regime: &Regime) -> Result<[f64; 2]> {
        let motion = self.motion_in(regime);
        let slow = self.slow_time();
        let n = self.n();
        let bend = |x: &[f64], clock: Clock| self.bend(&motion, stop, x, clock);
        let (a, now) = bend(self.x.slice(), self.clock)?;
        let least = JERK_ROUNDING * self.acceleration_sizes(&[stop])?[0];
        // Rounding of the accelerations passes on to their rates through the damping.
        let mut shaken = self.x.clone();
        let all: Vec<usize> = (0..self.n_stops()).collect();
        let most = self.acceleration_sizes(&all)?;
        let most = most.into_iter().fold(0.0, f64::max);
        for (v, a) in shaken.slice_mut()[n..].iter_mut().zip(&a) {
            *v += if *a == 0.0 { 0.0 } else { GAP_ROUNDING * most };
        }
        let shaken = (bend(shaken.slice(), self.clock)?.1 - now).abs();
        let change = |step: f64| -> Result<f64> {
            let ahead = self.moved(&a, step);
            Ok(bend(ahead.slice(), self.clock.after(step))?.1 - now)
        };
        // A difference is as long as it must be for rounding to leave something of it; one that does not grow as its step is none.
        for step in JERK_STEPS.map(|s| s * JERK_STEP * slow) {
            let once = change(step)?;
            if once.abs() > least {
                let is_even = (change(2.0 * step)? - 2.0 * once).abs() < once.abs();
                let jerk = if is_even { once } else { 0.0 };
                return Ok([jerk / step, (least / step).max(shaken)]);
            }
        }
        Ok([0.0, shaken])
    }
}

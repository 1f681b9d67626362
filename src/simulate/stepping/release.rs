//! Steps while stops are held: the contact forces along a step, and the step to the release of one.

use super::FreeFlight;
use super::{MOST_POLISHES, StepMover};
use crate::contact::polynomial::Quartic;
use crate::contact::walk::ROUNDING;
use crate::error::Result;
use crate::flow::runge_kutta::{State, later};
use crate::model::Dynamics;
use crate::simulate::held::HeldMotion;
use crate::simulate::mover::Mover;
use std::sync::Arc;

/// The quartic through a contact force is off by no more than this, relative to the force.
const FORCE_TOL: f64 = 1e-4;

/// What the contact forces do along a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Release {
    None,
    /// One falls through zero, at a part x of the step.
    At {
        stop: usize,
        x: f64,
    },
    /// The step is too long for the quartic.
    Undecided,
}

impl<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'a, S, D, F> {
    /// The motion while the stops of `holding` are held.
    pub(super) fn held_motion(&self) -> HeldMotion<'a, D> {
        self.motion_with(self.holding.clone())
    }

    /// The motion while some stops are held.
    pub(super) fn motion_with(&self, stops: Vec<usize>) -> HeldMotion<'a, D> {
        HeldMotion {
            dynamics: self.dynamics,
            system: self.scene.system(),
            contacts: Arc::clone(&self.contacts),
            stops,
        }
    }

    /// The contact forces at a state of the step last taken.
    fn forces_at(&self, held: &HeldMotion<'a, D>, s: f64, x: &[f64]) -> Result<Vec<f64>> {
        let (q, v) = x.split_at(self.n());
        let mut a = vec![0.0; q.len()];
        held.forces(later(self.moment(), s, self.frequency), q, v, &mut a)
    }

    /// The first stop held whose contact force falls through zero along the step last taken: on the quartic through the
    /// force at five times, checked at two more. Where nothing but the force changes, no error holds the step down. A force that
    /// falls below zero by less than what the tolerance leaves of it touches zero, and lets nothing go.
    pub(super) fn release_along(&mut self, h: f64) -> Result<Release> {
        let held = self.held_motion();
        let dense = self.stepper.dense(&self.x, h);
        let mut x = S::zeros(2 * self.n());
        let mut forces = |part: f64| {
            dense.state(part * h, x.slice_mut());
            self.forces_at(&held, part * h, x.slice())
        };
        let nodes: Vec<_> = (0..5)
            .map(|k| forces(0.25 * f64::from(k)))
            .collect::<Result<_>>()?;
        let checks = [(0.375, forces(0.375)?), (0.875, forces(0.875)?)];
        let mut first = Release::None;
        for (k, &stop) in self.holding.iter().enumerate() {
            let force = Quartic::through(std::array::from_fn(|i| nodes[i][k]));
            let miss = |(x, found): &(f64, Vec<f64>)| (force.value(*x) - found[k]).abs();
            let spread = (0..5).map(|i| nodes[i][k].abs()).fold(0.0, f64::max);
            let miss = checks.iter().map(miss).fold(0.0, f64::max);
            let depth = -force.lowest().1;
            self.pressed[k] = spread.max(self.pressed[k]);
            let slack = 10.0 * self.tolerance.relative * self.pressed[k];
            if miss > FORCE_TOL * spread || (depth > slack && depth <= 10.0 * miss) {
                // The rounding of a force has no shape.
                let size = self.acceleration_sizes(&[stop])?[0];
                let push = self.delassus(&[stop])?[(0, 0)];
                if push * spread <= ROUNDING * size {
                    continue;
                }
                return Ok(Release::Undecided);
            }
            let is_later = |x: f64| matches!(first, Release::At { x: known, .. } if known <= x);
            let falls = (depth > slack).then(|| force.first_fall().unwrap_or(0.0));
            if let Some(x) = falls.filter(|&x| !is_later(x)) {
                first = Release::At { stop, x };
            }
        }
        Ok(first)
    }

    /// Steps to the release itself, by the secant method on the length of the step.
    pub(super) fn let_go<E: Dynamics>(
        &mut self,
        dynamics: &E,
        stop: usize,
        guess: f64,
        h: f64,
    ) -> Result<f64> {
        let held = self.held_motion();
        let k = self.holding.iter().position(|&s| s == stop).unwrap_or(0);
        let force = |mover: &mut Self, s: f64| -> Result<f64> {
            mover.step(dynamics, s)?;
            let end = mover.stepper.end.clone();
            Ok(mover.forces_at(&held, s, end.slice())?[k])
        };
        let at_start = force(self, 0.0)?;
        if guess == 0.0 {
            return Ok(0.0);
        }
        zero_near(guess, h, at_start, |s| force(self, s))
    }
}

/// The zero of a force that falls along a step of length h, near a guess, by the secant method from its value at the start;
/// the force is asked for last where it is found.
fn zero_near(
    guess: f64,
    h: f64,
    at_start: f64,
    mut force: impl FnMut(f64) -> Result<f64>,
) -> Result<f64> {
    let (mut s0, mut f0) = (0.0, at_start);
    let (mut s, mut f) = (guess, force(guess)?);
    for _ in 0..MOST_POLISHES {
        let next = (s - f * (s - s0) / (f - f0)).clamp(0.0, h);
        if next.is_nan() || (next - s).abs() <= 4.0 * f64::EPSILON * h {
            break;
        }
        let there = force(next)?;
        // A force that falls no further is rounding, on which a secant would lead anywhere: back to the step before.
        if there.abs() >= f.abs() {
            force(s)?;
            break;
        }
        (s0, f0) = (s, f);
        (s, f) = (next, there);
    }
    Ok(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_that_rounding_holds_off_zero_has_its_zero_where_it_is_least() {
        let (zero, h, slope) = (0.003, 0.004, -20.0);
        for rounding in [3e-16, 1e-14, -1e-14] {
            for seed in 1..40 {
                let (mut asked, mut last) = (0, 0.0);
                let mut force = |s: f64| {
                    (asked, last) = (asked + 1, s);
                    let x = s - zero;
                    let value = slope * x * (1.0 + 10.0 * x);
                    // Near the zero only rounding is left, which differs a little from time to time.
                    let noise = rounding * (1.0 + 1e-14 * f64::from(asked * seed % 5));
                    let is_lost = value.abs() <= rounding.abs();
                    Ok(if is_lost { noise } else { value })
                };
                let at_start = force(0.0).expect("finite");
                let found = zero_near(0.9 * zero, h, at_start, force).expect("finite");
                let lost = 2.0 * (rounding / slope).abs() + 1e-17;
                assert!((found - zero).abs() <= lost, "{rounding:e} {seed} {found}");
                assert_eq!(last, found);
            }
        }
    }
}

//! Where a force that is watched falls through zero along a step: of a stop that is held, or of one that gives way; and the step to that instant. What happens then:
//! `resolver/hold_or_release.rs`.

use super::scene::{Integrated, MOST_RETAKEN_STEPS};
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::polynomial::Quartic;
use crate::law::{Guard, GuardKind, Regime};
use crate::root::{Bracket, Secant, bisected};

use crate::error::Result;
use crate::flow::steps::{DenseOutput, State, Stepper};
use crate::flow::{GuardDerivatives, RegimeDynamics};
use crate::hybrid::system::{Accelerations, Contacts, Gaps};
use crate::linalg::rank::pseudo_inverse;
use crate::model::Dynamics;
use crate::tolerance::{DEPENDENT, FORCE_TOL, GAP_ROUNDING, JERK_STEP};
use std::sync::Arc;

/// The first secant towards the zero of a force begins at this part of the guess. [work]
const SECANT_START: f64 = 0.99;

impl<'a, S: State, D: Dynamics, P: Stepper<S>> Integrated<'a, S, D, P> {
    /// The motion in a regime.
    pub(super) fn motion_in(&self, regime: &Regime) -> RegimeDynamics<'a, D> {
        RegimeDynamics {
            dynamics: self.dynamics,
            system: self.scene.system(),
            contacts: Arc::clone(&self.contacts),
            regime: regime.clone(),
        }
    }

    /// The forces that are watched, at a state of the step last taken.
    fn forces_at(&self, motion: &RegimeDynamics<'a, D>, s: f64, x: &[f64]) -> Result<Vec<f64>> {
        let state = x.split_at(self.n());
        motion.guards(&self.force_guards, self.moment().after(s), state)
    }

    /// The first force that is watched and falls through zero along the step last taken, by its place among these, undecided where the step
    /// is too long for that: on the quartic through the
    /// force at five times, checked at two more. Where nothing but the force changes, no error holds the step down. A force that
    /// falls below zero by less than what the tolerance leaves of it touches zero, and ends nothing.
    pub(super) fn release_along(&mut self, h: f64) -> Result<FirstEvent> {
        let motion = self.motion_in(&self.regime);
        let dense = self.dense(&motion, h)?;
        let mut x = S::zeros(2 * self.n());
        let mut forces = |part: f64| {
            dense.state(part * h, x.slice_mut());
            self.forces_at(&motion, part * h, x.slice())
        };
        let nodes: Vec<_> = (0..5)
            .map(|k| forces(0.25 * f64::from(k)))
            .collect::<Result<_>>()?;
        let checks = [(0.375, forces(0.375)?), (0.875, forces(0.875)?)];
        let mut first = FirstEvent::NONE;
        for k in 0..self.force_guards.len() {
            let force = Quartic::through(std::array::from_fn(|i| nodes[i][k]));
            let miss = |(x, found): &(f64, Vec<f64>)| (force.value(*x) - found[k]).abs();
            let spread = (0..5).map(|i| nodes[i][k].abs()).fold(0.0, f64::max);
            let miss = checks.iter().map(miss).fold(0.0, f64::max);
            let depth = -force.lowest().1;
            self.peak_forces[k] = spread.max(self.peak_forces[k]);
            let mut slack = 10.0 * self.tolerance.relative * self.peak_forces[k];
            if depth > slack {
                slack = slack.max(self.force_rounding(k)?);
                // A force that has been no more than the tolerance of the state may not have begun.
                let unknown = 10.0 * self.force_tolerance(&motion, k)?;
                if self.peak_forces[k] <= unknown {
                    slack = slack.max(unknown);
                }
            }
            if miss > FORCE_TOL * spread || (depth > slack && depth <= 10.0 * miss) {
                // The rounding of a force has no shape, nor has what the tolerance of the state leaves of one.
                let rounding = self.force_rounding(k)?;
                let unknown = rounding.max(self.force_tolerance(&motion, k)?);
                if spread <= unknown {
                    continue;
                }
                if miss > unknown {
                    let root = FirstRoot::Undecided { at: 0.0 };
                    return Ok(FirstEvent { stop: k, root });
                }
            }
            if depth > slack {
                let at = force.first_fall().unwrap_or(0.0);
                first.note(k, FirstRoot::Crossing { at, passed: 1.0 });
            }
        }
        Ok(first)
    }

    /// What rounding leaves unknown of a force that is watched: of one that holds, that of the accelerations that it and others take away
    /// together.
    fn force_rounding(&self, k: usize) -> Result<f64> {
        let guard = self.force_guards[k];
        let constrained = self.regime.constrained();
        let Some(place) = constrained.iter().position(|own| *own == guard.element) else {
            let own = self.gap(guard.element);
            let law = self.contacts[guard.element].law.by_state();
            let grip = law.grip(-own.gap, -own.speed);
            let size = grip.size_at(own.size, self.speed_size(guard.element));
            return Ok(GAP_ROUNDING * size);
        };
        let sizes = self.acceleration_sizes(constrained)?;
        let delassus = self.delassus(constrained)?;
        let forces = pseudo_inverse(&delassus, DEPENDENT * delassus.amax())?;
        let taken = sizes.iter().enumerate();
        let taken: f64 = taken.map(|(j, size)| forces[(place, j)].abs() * size).sum();
        let seat = || self.contacts[guard.element].law.by_state().seat();
        let borne = match guard.kind {
            GuardKind::Excess => seat().unwrap_or(0.0),
            _ => 0.0,
        };
        Ok(GAP_ROUNDING * (taken + borne))
    }

    /// What the absolute tolerance of the state leaves unknown of a force that is watched: of one that begins from zero that is all.
    fn force_tolerance(&self, motion: &RegimeDynamics<'a, D>, k: usize) -> Result<f64> {
        let here = self.forces_at(motion, 0.0, self.x.slice())?[k];
        let mut x = self.x.clone();
        let mut unknown = 0.0;
        for i in 0..x.slice().len() {
            let own = x.slice()[i];
            x.slice_mut()[i] = own + self.tolerance.absolute;
            let change = self.forces_at(motion, 0.0, x.slice())?[k] - here;
            x.slice_mut()[i] = own;
            unknown += change.abs();
        }
        Ok(unknown)
    }

    /// What is left of the preload of an element that is held, and how fast that goes, by a difference.
    pub(super) fn excess(&self, guard: Guard) -> Result<GuardDerivatives> {
        let motion = self.motion_in(&self.regime);
        let left = |x: &[f64], s: f64| -> Result<f64> {
            let state = x.split_at(self.n());
            Ok(motion.guards(&[guard], self.moment().after(s), state)?[0])
        };
        let step = JERK_STEP * self.slow_time();
        let (ahead, now) = (self.drifted(&motion, step)?, left(self.x.slice(), 0.0)?);
        let rate = (left(ahead.slice(), step)? - now) / step;
        let place = self.force_guards.iter().position(|own| *own == guard);
        let lost = place.map_or(Ok(0.0), |k| self.force_rounding(k))?;
        let unknown = [0.0, f64::INFINITY];
        Ok([[now, lost], [rate, lost / step], unknown, unknown])
    }

    /// Steps to the zero of a force that is watched, by the secant method on the length of the step; none where no step can be taken.
    pub(super) fn let_go<E: Dynamics>(
        &mut self,
        dynamics: &E,
        k: usize,
        guess: f64,
        h: f64,
    ) -> Result<Option<f64>> {
        let motion = self.motion_in(&self.regime);
        let rounding = self.force_rounding(k)?;
        let mut is_taken = true;
        let mut force = |s: f64| -> Result<f64> {
            is_taken &= self.step(dynamics, s)?;
            Ok(self.forces_at(&motion, s, self.stepper.end().slice())?[k])
        };
        let s = if guess == 0.0 {
            force(0.0)?;
            0.0
        } else {
            zero_near(guess, h, rounding, force)?
        };
        Ok(is_taken.then_some(s))
    }
}

/// The zero of a force that falls along a step of length h, near a guess, by the secant method from a little before that: where
/// the step begins the force may begin from zero, too. The force is asked for last where it is found; `rounding` is what is left
/// of one that is zero.
fn zero_near(
    guess: f64,
    h: f64,
    rounding: f64,
    mut force: impl FnMut(f64) -> Result<f64>,
) -> Result<f64> {
    let before = SECANT_START * guess;
    let mut secant = Secant {
        at: before,
        value: force(before)?,
    };
    let (mut s, mut f) = (guess, force(guess)?);
    for _ in 0..MOST_RETAKEN_STEPS {
        let next = (s + secant.step(s, f)).clamp(0.0, h);
        if next.is_nan() || (next - s).abs() <= 4.0 * f64::EPSILON * h {
            break;
        }
        let there = force(next)?;
        if there.abs() >= f.abs() {
            // One that falls through zero almost without slope leads a secant beyond it.
            if f > rounding && there < 0.0 && next > s {
                let last_places = 4.0 * f64::EPSILON * h;
                let found = bisected(Bracket::new([s, next]), last_places, |x| -> Result<bool> {
                    Ok(force(x)? > 0.0)
                })?;
                force(found.after)?;
                return Ok(found.after);
            }
            // One that falls no further is rounding, on which a secant would lead anywhere: back to the step before.
            force(s)?;
            break;
        }
        (s, f) = (next, there);
    }
    Ok(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_that_falls_through_zero_almost_without_slope_has_its_zero_there() {
        // The quartic through it knows nothing of so little: its guess is where the step begins.
        for (left, h) in [(2.8e-11, 0.3), (1e-9, 0.05), (1e-14, 0.7)] {
            let zero = (left / 2.0_f64).cbrt();
            for guess in [1.8e-7, 1e-6 * h, 1e-5 * h] {
                let mut last = 0.0;
                let force = |s: f64| {
                    last = s;
                    Ok(left - 2.0 * s * s * s)
                };
                let found = zero_near(guess, h, 1e-16, force).expect("finite");
                let lost = 1e-16 * left / (6.0 * zero * zero) + 1e-15 * h;
                assert!((found - zero).abs() <= lost, "{left:e} {guess:e} {found}");
                assert_eq!(last, found);
            }
        }
    }

    #[test]
    fn a_force_that_rounding_holds_off_zero_has_its_zero_where_it_is_least() {
        let (zero, h, slope) = (0.003, 0.004, -20.0);
        for rounding in [3e-16, 1e-14, -1e-14] {
            for seed in 1..40 {
                let (mut asked, mut last) = (0, 0.0);
                let force = |s: f64| {
                    (asked, last) = (asked + 1, s);
                    let x = s - zero;
                    let value = slope * x * (1.0 + 10.0 * x);
                    // Near the zero only rounding is left, which differs a little from time to time.
                    let noise = rounding * (1.0 + 1e-14 * f64::from(asked * seed % 5));
                    let is_lost = value.abs() <= rounding.abs();
                    Ok(if is_lost { noise } else { value })
                };
                let found = zero_near(0.9 * zero, h, rounding.abs(), force).expect("finite");
                let lost = 2.0 * (rounding / slope).abs() + 1e-17;
                assert!((found - zero).abs() <= lost, "{rounding:e} {seed} {found}");
                assert_eq!(last, found);
            }
        }
    }

    #[test]
    fn a_force_that_begins_from_zero_is_let_go_where_it_falls() {
        // As good a guess as can be: a secant from the start, zero but for rounding, would lead back there.
        for rounding in [-1e-16, 0.0, 1e-16] {
            for guess in [0.5, 0.5 + 1e-13, 0.5 - 1e-13, 0.499] {
                let force = |s: f64| Ok(s * (0.5 - s) + rounding);
                let found = zero_near(guess, 0.7, 1e-16, force).expect("finite");
                assert!((found - 0.5).abs() < 1e-14, "{rounding:e} {guess} {found}");
            }
        }
    }
}

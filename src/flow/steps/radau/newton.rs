//! When the simplified Newton iteration stops (Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8).
//!
//! The increments `d_k` of the iteration shrink by a factor `theta`, and what is left after one of them is `eta |d_k|` with
//! `eta = theta/(1 - theta)`. The iteration stops when this is below a goal; it gives up when it foresees that this will not be
//! so after the last increment, `eta theta^(K-k) |d_k| > goal`.

use crate::flow::steps::stepper::Tolerance;
use crate::tolerance::{FIRST_INCREMENT_LEFT, NEWTON_DIVERGENCE};

/// Iterations of one step at most, that of RADAU5. [work]
pub(super) const RADAU_ITERATIONS: i32 = 7;
/// Factor between increments up to which an iteration converges so fast that its Jacobian serves for the next step as well; that of RADAU5.
/// [work]
const FAST_CONVERGENCE: f64 = 1e-3;

/// What to do after an increment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Iteration {
    Continue,
    Converged,
    Failed,
}

/// How fast the iteration converges.
#[derive(Debug, Clone)]
pub(super) struct Convergence {
    /// What may be left, in units of the tolerance.
    goal: f64,
    /// The part of an increment that is left after it.
    eta: f64,
    /// The mean factor of the last two increments, and the last one.
    theta: f64,
    factor: f64,
    size: f64,
    increments: i32,
}

impl Convergence {
    pub fn new(tolerance: Tolerance) -> Self {
        let rounding = (10.0 * f64::EPSILON / tolerance.relative).min(0.1);
        Self {
            goal: rounding.max(tolerance.relative.sqrt().min(0.03)),
            eta: 1.0,
            theta: 0.0,
            factor: 0.0,
            size: 0.0,
            increments: 0,
        }
    }

    /// What may be left, in units of the tolerance.
    pub fn goal(&self) -> f64 {
        self.goal
    }

    /// Forgets the iterations before.
    pub fn forget(&mut self) {
        self.eta = 1.0;
        self.theta = 0.0;
    }

    /// Begins an iteration, whose first increment is judged by the convergence of the one before.
    pub fn begin(&mut self) {
        self.eta = self.eta.powf(0.8).max(FIRST_INCREMENT_LEFT);
        self.theta = 0.0;
        self.increments = 0;
    }

    /// Whether the last iteration was so slow that the next step wants another Jacobian.
    pub fn is_slow(&self) -> bool {
        self.theta > FAST_CONVERGENCE
    }

    /// Judges the next increment by its size in units of the tolerance; one that is no number is a failure.
    pub fn judge(&mut self, size: f64) -> Iteration {
        self.increments += 1;
        if self.increments > 1 {
            self.contract(size / self.size);
        }
        self.size = size;
        let left = self.eta * size;
        let is_foreseen = if self.increments == 1 {
            size.is_finite()
        } else {
            left * self.theta.powi(RADAU_ITERATIONS - self.increments) <= self.goal
        };
        if self.theta < NEWTON_DIVERGENCE && left <= self.goal {
            Iteration::Converged
        } else if self.theta < NEWTON_DIVERGENCE && is_foreseen {
            Iteration::Continue
        } else {
            self.eta = 1.0;
            Iteration::Failed
        }
    }

    /// Takes note of the factor between two increments.
    fn contract(&mut self, factor: f64) {
        self.theta = if self.increments == 2 {
            factor
        } else {
            (factor * self.factor).sqrt()
        };
        self.factor = factor;
        self.eta = self.theta / (1.0 - self.theta);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The verdicts on increments that begin at a size and shrink by a factor each time, up to the last.
    fn verdicts(convergence: &mut Convergence, size: f64, factor: f64) -> Vec<Iteration> {
        convergence.begin();
        let mut verdicts = Vec::new();
        for k in 0..RADAU_ITERATIONS {
            verdicts.push(convergence.judge(size * factor.powi(k)));
            if verdicts.last() != Some(&Iteration::Continue) {
                break;
            }
        }
        verdicts
    }

    fn convergence(relative: f64) -> Convergence {
        Convergence::new(Tolerance {
            relative,
            absolute: relative,
        })
    }

    #[test]
    fn the_goal_is_above_rounding() {
        assert_eq!(convergence(1e-2).goal, 0.03);
        assert_eq!(convergence(1e-6).goal, 1e-3);
        assert!((convergence(1e-12).goal - 2.2e-3).abs() < 1e-4);
        assert_eq!(convergence(0.0).goal, 0.1);
    }

    #[test]
    fn it_stops_when_little_is_left() {
        let mut fast = convergence(1e-4);
        let got = verdicts(&mut fast, 1.0, 1e-4);
        assert_eq!(got, [Iteration::Continue, Iteration::Converged]);
        assert!(!fast.is_slow());
        // After a fast iteration the first increment counts a hundredth, not less.
        assert_eq!(verdicts(&mut fast, 0.99, 1e-4), [Iteration::Converged]);
        assert_eq!(verdicts(&mut fast, 1.01, 1e-4)[0], Iteration::Continue);
        fast.forget();
        assert_eq!(verdicts(&mut fast, 0.99, 1e-4)[0], Iteration::Continue);
        let mut slow = convergence(1e-4);
        assert_eq!(
            verdicts(&mut slow, 1.0, 0.2).last(),
            Some(&Iteration::Converged)
        );
        assert!(slow.is_slow());
    }

    #[test]
    fn it_gives_up_when_it_foresees_no_end() {
        let (go, failed) = (Iteration::Continue, Iteration::Failed);
        for factor in [0.9, 1.0, 3.0, f64::INFINITY, f64::NAN] {
            assert_eq!(verdicts(&mut convergence(1e-6), 1.0, factor), [go, failed]);
        }
        for size in [f64::INFINITY, f64::NAN] {
            assert_eq!(verdicts(&mut convergence(1e-6), size, 0.1), [failed]);
        }
        // An iteration that does not shrink has not converged, however small.
        assert_eq!(verdicts(&mut convergence(1e-6), 2e-3, 1.0), [go, failed]);
    }
}

//! The Radau IIA method of order 5 on `q'' = a(t, q, v)`, for stiff motions (theory 8). Hairer and Wanner, Solving Ordinary
//! Differential Equations II, section IV.8.
//!
//! With `y = (q, v)` and `y' = f(t, y)` the increments `z_i = y_i - y0` at the nodes solve `Z = h A F(Z)`. In the modes
//! `W = T^-1 Z` of `A^-1`, with eigenvalues z, an iteration of Newton with a Jacobian kept is
//! `(z - h J) dw = h T^-1 F - z w`. The end is the last stage, and the motion the cubic through all of them. The error, of
//! order 4 in h, is d with `(g - h J) d = h f0 + e1 z1 + e2 z2 + e3 z3`, where g is the real eigenvalue.

use crate::error::Result;
use crate::flow::steps::control::StepControl;
use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::radau::cubic::{Cubic, entry, set_entry};
use crate::flow::steps::radau::newton::{Convergence, Iteration, RADAU_ITERATIONS};
use crate::flow::steps::radau::system::NewtonSystem;
use crate::flow::steps::radau::tableau::{
    FROM_MODES, PAIR, RADAU_ERROR, RADAU_NODES, RADAU_STAGES, REAL_EIGENVALUE, TO_MODES, times,
};
use crate::flow::steps::state::{State, rate};
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::model::Dynamics;
use nalgebra::Complex;

/// The method, with the step last taken.
#[derive(Debug, Clone)]
pub(crate) struct Radau<S> {
    tolerance: Tolerance,
    system: NewtonSystem,
    convergence: Convergence,
    start_rate: S,
    end: S,
    end_rate: S,
    /// Increments at the nodes, and their modes.
    z: [S; RADAU_STAGES],
    w: [S; RADAU_STAGES],
    /// Rates at the nodes, then the increments of the modes in an iteration.
    f: [S; RADAU_STAGES],
    pair: Vec<Complex<f64>>,
    trial: S,
    /// The largest size of each entry on the step.
    most: S,
    error: S,
    cubic: Cubic<S>,
    /// Steps tried from this start.
    tries: u32,
    /// Whether no step has gone on since the motion began.
    is_first: bool,
    /// Whether the step last tried was taken.
    is_taken: bool,
    n_rhs: usize,
}

/// The tolerance of the error estimate, which is of order 4 where the end is of order 5: RADAU5's power of the one asked for.
/// Measured on ten smooth, stiff and tied motions at 1e-4 to 1e-11, the errors at the end were off the tolerance by a factor
/// of 5 in the mean, and up to 40 above it where stiffness lowers the order; without the power they were below it by a factor
/// of 40, at four times as many steps. The motion inside a step is as good as the estimate, not as the end.
fn coarse(tolerance: Tolerance) -> Tolerance {
    let factor = 0.1 / tolerance.relative.cbrt();
    if !factor.is_finite() {
        return tolerance;
    }
    Tolerance {
        relative: factor * tolerance.relative,
        absolute: factor * tolerance.absolute,
    }
}

/// The sum of two states.
#[inline]
fn add<S: State>(x: &S, y: &S, sum: &mut S) {
    let terms = x.slice().iter().zip(y.slice());
    for (sum, (x, y)) in sum.slice_mut().iter_mut().zip(terms) {
        *sum = x + y;
    }
}

/// Makes the error from the rate at the start.
fn estimate<S: State>(system: &mut NewtonSystem, h: f64, rate: &S, z: &[S; 3], error: &mut S) {
    for (i, (error, f)) in error.slice_mut().iter_mut().zip(rate.slice()).enumerate() {
        let z = entry(z, i);
        *error = h * f + RADAU_ERROR[0] * z[0] + RADAU_ERROR[1] * z[1] + RADAU_ERROR[2] * z[2];
    }
    system.solve_real(error.slice_mut());
}

impl<S: State> Radau<S> {
    /// Sets the increments to those that the cubic last known goes on with, or to zeros.
    fn guess(&mut self, h: f64) {
        for i in 0..self.pair.len() {
            let z = self.cubic.increments(i, h);
            set_entry(&mut self.z, i, z);
            set_entry(&mut self.w, i, times(&TO_MODES, z));
        }
    }

    /// Solves the equations of a step; false if they are singular or the iteration fails.
    fn solve<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
    ) -> Result<bool> {
        let (system, rate0) = (&mut self.system, &self.start_rate);
        if !system.prepare(dynamics, start, rate0, h, &mut self.n_rhs)? {
            return Ok(false);
        }
        self.guess(h);
        self.convergence.begin();
        let drives = RADAU_NODES.map(|node| dynamics.drive(start.at.after(node * h)));
        for _ in 0..RADAU_ITERATIONS {
            for (k, drive) in drives.iter().enumerate() {
                add(start.x, &self.z[k], &mut self.trial);
                rate(dynamics, drive, &self.trial, &mut self.f[k])?;
            }
            self.n_rhs += RADAU_STAGES;
            self.improve(h);
            add(start.x, &self.z[RADAU_STAGES - 1], &mut self.end);
            self.reach(start.x);
            match self.convergence.judge(self.increment()) {
                Iteration::Continue => {}
                verdict => return Ok(verdict == Iteration::Converged),
            }
        }
        Ok(false)
    }

    /// One iteration, from the rates at the nodes, which become the increments of the modes.
    fn improve(&mut self, h: f64) {
        for i in 0..self.pair.len() {
            let (f, w) = (times(&TO_MODES, entry(&self.f, i)), entry(&self.w, i));
            self.f[0].slice_mut()[i] = h * f[0] - REAL_EIGENVALUE * w[0];
            self.pair[i] = Complex::new(f[1], f[2]) * h - PAIR * Complex::new(w[1], w[2]);
        }
        self.system.solve_real(self.f[0].slice_mut());
        self.system.solve_pair(&mut self.pair);
        for (i, pair) in self.pair.iter().enumerate() {
            let d = [self.f[0].slice()[i], pair.re, pair.im];
            let w = entry(&self.w, i);
            let w = std::array::from_fn(|k| w[k] + d[k]);
            set_entry(&mut self.f, i, d);
            set_entry(&mut self.w, i, w);
            set_entry(&mut self.z, i, times(&FROM_MODES, w));
        }
    }

    /// Notes how large each entry becomes on the step: one that begins and ends at zero has the rounding of what is between.
    fn reach(&mut self, x: &S) {
        for (i, (most, x)) in self.most.slice_mut().iter_mut().zip(x.slice()).enumerate() {
            let stages = self.z.iter().map(|z| (x + z.slice()[i]).abs());
            *most = stages.fold(x.abs(), f64::max);
        }
    }

    /// The size of the increments of the modes, in units of the tolerance. Small positions, and velocities, are known to the
    /// rounding of the largest: no iteration makes less of an increment.
    fn increment(&self) -> f64 {
        let (n, most) = (self.pair.len() / 2, self.most.slice());
        let largest = |half: &[f64]| half.iter().copied().fold(0.0, f64::max);
        let rounding = 4.0 * f64::EPSILON / self.convergence.goal();
        let least = [&most[..n], &most[n..]].map(|half| rounding * largest(half));
        let Tolerance { relative, absolute } = self.tolerance;
        let scale = |i: usize| (absolute + relative * most[i]).max(least[i / n]);
        let square = |i: usize| {
            self.f
                .iter()
                .map(move |d| (d.slice()[i] / scale(i)).powi(2))
        };
        let squares = (0..2 * n).flat_map(square).sum::<f64>();
        (squares / (RADAU_STAGES * 2 * n) as f64).sqrt()
    }

    /// Makes the rate at the end and the cubic; false if the rate is no number.
    fn finish<D: Dynamics>(&mut self, dynamics: &D, drive: &D::Drive, h: f64) -> Result<bool> {
        self.n_rhs += 1;
        rate(dynamics, drive, &self.end, &mut self.end_rate)?;
        self.cubic.set(&self.z, h);
        Ok(self.end_rate.slice().iter().all(|x| x.is_finite()))
    }
}

impl<S: State> StepEnds<S> for Radau<S> {
    fn start_rate(&self) -> &S {
        &self.start_rate
    }

    fn end(&self) -> &S {
        &self.end
    }

    fn end_mut(&mut self) -> &mut S {
        &mut self.end
    }

    fn end_rate(&self) -> &S {
        &self.end_rate
    }

    fn n_rhs(&self) -> usize {
        self.n_rhs
    }
}

impl<S: State> Stepper<S> for Radau<S> {
    const HAS_QUINTIC: bool = false;

    type Choice = ();
    type Dense = Dense<S, 3>;

    fn new(n_dof: usize, tolerance: Tolerance, _choice: ()) -> Self {
        let zeros = S::zeros(2 * n_dof);
        let three = || std::array::from_fn(|_| zeros.clone());
        let tolerance = coarse(tolerance);
        Self {
            tolerance,
            system: NewtonSystem::new(n_dof, tolerance),
            convergence: Convergence::new(tolerance),
            start_rate: zeros.clone(),
            end: zeros.clone(),
            end_rate: zeros.clone(),
            z: three(),
            w: three(),
            f: three(),
            pair: vec![Complex::default(); 2 * n_dof],
            trial: zeros.clone(),
            most: zeros.clone(),
            error: zeros.clone(),
            cubic: Cubic::new(n_dof),
            tries: 0,
            is_first: true,
            is_taken: false,
            n_rhs: 0,
        }
    }

    /// What was known of the motion before is forgotten.
    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()> {
        self.system.forget();
        self.convergence.forget();
        self.cubic.forget();
        (self.tries, self.is_first, self.is_taken) = (0, true, false);
        self.n_rhs += 1;
        let drive = dynamics.drive(start.at);
        rate(dynamics, &drive, start.x, &mut self.start_rate)
    }

    /// A step that fails with an old Jacobian is tried once more with that of its start, from zero increments.
    fn step<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<bool> {
        if h == 0.0 {
            self.end.clone_from(start.x);
            self.end_rate.clone_from(&self.start_rate);
            return Ok(true);
        }
        self.tries += 1;
        self.is_taken = false;
        if self.system.is_old() && self.convergence.is_slow() {
            self.system.forget();
        }
        let mut is_solved = self.solve(dynamics, start, h)?;
        if !is_solved && self.system.is_old() {
            self.system.forget();
            self.cubic.forget();
            is_solved = self.solve(dynamics, start, h)?;
        }
        if is_solved {
            let drive = dynamics.drive(start.at.after(h));
            self.is_taken = self.finish(dynamics, &drive, h)?;
        }
        Ok(self.is_taken)
    }

    /// On a first step, and on one tried again, an error that is too large is taken once more with the rate at `y0 + d`, which
    /// leaves out what a stiff motion loses at once. Infinite if there is no step.
    fn error<D: Dynamics>(
        &mut self,
        dynamics: &D,
        StepStart { at, x }: StepStart<'_, S>,
        h: f64,
        tolerance: Tolerance,
    ) -> Result<f64> {
        if !self.is_taken {
            return Ok(f64::INFINITY);
        }
        let tolerance = coarse(tolerance);
        let size = |error: &S, most: &S| tolerance.norm(error, (x, most));
        let (system, z) = (&mut self.system, &self.z);
        estimate(system, h, &self.start_rate, z, &mut self.error);
        let mut error = size(&self.error, &self.most);
        if error >= 1.0 && error.is_finite() && (self.is_first || self.tries > 1) {
            self.n_rhs += 1;
            add(x, &self.error, &mut self.trial);
            let there = &mut self.f[0];
            rate(dynamics, &dynamics.drive(at), &self.trial, there)?;
            estimate(system, h, there, z, &mut self.error);
            error = size(&self.error, &self.most);
        }
        Ok(if error.is_finite() {
            error
        } else {
            f64::INFINITY
        })
    }

    fn dense<D: Dynamics>(
        &mut self,
        _dynamics: &D,
        StepStart { x, .. }: StepStart<'_, S>,
        h: f64,
    ) -> Result<Dense<S, 3>> {
        Ok(self.cubic.dense(x, &self.end, h))
    }

    fn go_on(&mut self) -> bool {
        std::mem::swap(&mut self.start_rate, &mut self.end_rate);
        self.system.go_on();
        self.cubic.go_on();
        (self.tries, self.is_first, self.is_taken) = (0, false, false);
        true
    }

    fn control(&self) -> StepControl {
        StepControl {
            order: 4,
            beta: 0.04,
            least: 0.2,
            most: 8.0,
            kept_below: 1.2,
        }
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;

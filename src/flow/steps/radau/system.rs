//! The linear systems of Newton's iteration for an implicit Runge-Kutta method on `q'' = a(t, q, v)` (Hairer and Wanner,
//! Solving Ordinary Differential Equations II, section IV.8).
//!
//! The Jacobian of `(v, a)` is `J = [[0, 1], [A, B]]` with `A = da/dq` and `B = da/dv`. To an eigenvalue z of the method belongs
//! the system `(z - h J)(dq, dv) = (r, s)`. Its first row says `h dv = z dq - r`, and n equations remain,
//! `(z^2 - z h B - h^2 A) dq = h s + (z - h B) r`.
//! In this scaling a short step leaves numbers of size one, and stiffness counts as `h^2 A`. What a stiff and a soft motion
//! lose beside each other in one matrix only slows the iteration: its right-hand sides are residuals, which vanish.

use crate::error::Result;
use crate::flow::steps::radau::tableau::{PAIR, REAL_EIGENVALUE};
use crate::flow::steps::state::State;
use crate::flow::steps::stepper::{StepStart, Tolerance};
use crate::model::Dynamics;
use nalgebra::{Complex, ComplexField, DMatrix, DVector, Dyn, LU};

/// The factored system of one eigenvalue.
#[derive(Debug, Clone)]
struct ReducedMatrices<T: ComplexField> {
    z: T,
    lu: LU<T, Dyn, Dyn>,
    /// The right-hand side, then the solution.
    x: DVector<T>,
}

impl<T: ComplexField<RealField = f64> + Copy> ReducedMatrices<T> {
    /// The system of a step; none if it is singular.
    fn new(z: T, jacobian: &DMatrix<f64>, h: f64) -> Option<Self> {
        let n = jacobian.nrows();
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            let square = if i == j { z * z } else { T::zero() };
            square - z.scale(h * jacobian[(i, n + j)]) - T::from_real(h * h * jacobian[(i, j)])
        });
        let lu = LU::new(matrix);
        let x = DVector::zeros(n);
        lu.is_invertible().then_some(Self { z, lu, x })
    }

    /// Replaces the right-hand side `(r, s)` by the solution `(dq, dv)`.
    fn solve(&mut self, jacobian: &DMatrix<f64>, h: f64, right: &mut [T]) {
        let n = right.len() / 2;
        let (r, s) = right.split_at_mut(n);
        for (i, x) in self.x.iter_mut().enumerate() {
            let damping = |sum: T, j: usize| sum + r[j].scale(jacobian[(i, n + j)]);
            let damping = (0..n).fold(T::zero(), damping);
            *x = self.z * r[i] + (s[i] - damping).scale(h);
        }
        self.lu.solve_mut(&mut self.x);
        for ((r, s), &dq) in r.iter_mut().zip(s).zip(self.x.iter()) {
            *s = (self.z * dq - *r).unscale(h);
            *r = dq;
        }
    }
}

/// The systems of a step.
#[derive(Debug, Clone)]
struct Factors {
    h: f64,
    real: ReducedMatrices<f64>,
    pair: ReducedMatrices<Complex<f64>>,
}

impl Factors {
    fn new(jacobian: &DMatrix<f64>, h: f64) -> Option<Self> {
        Some(Self {
            h,
            real: ReducedMatrices::new(REAL_EIGENVALUE, jacobian, h)?,
            pair: ReducedMatrices::new(PAIR, jacobian, h)?,
        })
    }
}

/// Where the Jacobian is from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Age {
    Unknown,
    /// The start of a step before.
    Old,
    /// The start of this step.
    New,
}

/// The Jacobian, and the systems of the step last tried, which serve as long as they can.
#[derive(Debug, Clone)]
pub(super) struct NewtonSystem {
    jacobian: DMatrix<f64>,
    age: Age,
    factors: Option<Factors>,
    /// The size of an entry of the state that is as good as zero.
    small: f64,
    trial: Vec<f64>,
    acceleration: Vec<f64>,
    #[cfg(test)]
    pub counts: NewtonCounts,
}

/// Jacobians and pairs of factorizations so far.
#[cfg(test)]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct NewtonCounts {
    pub jacobians: usize,
    pub factorizations: usize,
}

impl NewtonSystem {
    pub fn new(n_dof: usize, tolerance: Tolerance) -> Self {
        Self {
            jacobian: DMatrix::zeros(n_dof, 2 * n_dof),
            age: Age::Unknown,
            factors: None,
            small: tolerance.absolute / tolerance.relative,
            trial: vec![0.0; 2 * n_dof],
            acceleration: vec![0.0; n_dof],
            #[cfg(test)]
            counts: NewtonCounts::default(),
        }
    }

    /// Forgets the Jacobian.
    pub fn forget(&mut self) {
        self.age = Age::Unknown;
        self.factors = None;
    }

    #[cfg(test)]
    pub fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    /// Whether a Jacobian is used that is not of this start.
    pub fn is_old(&self) -> bool {
        self.age == Age::Old
    }

    /// The next step has another start.
    pub fn go_on(&mut self) {
        if self.age == Age::New {
            self.age = Age::Old;
        }
    }

    /// Makes what is not known of the systems of a step from a start with a rate; false if they are singular or no numbers.
    pub fn prepare<S: State, D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        rate: &S,
        h: f64,
        n_rhs: &mut usize,
    ) -> Result<bool> {
        if self.age == Age::Unknown {
            self.differentiate(dynamics, start, rate, n_rhs)?;
            if !self.jacobian.iter().copied().all(f64::is_finite) {
                return Ok(false);
            }
            self.age = Age::New;
        }
        if self.factors.as_ref().is_none_or(|factors| factors.h != h) {
            self.factors = Factors::new(&self.jacobian, h);
            #[cfg(test)]
            {
                self.counts.factorizations += 1;
            }
        }
        Ok(self.factors.is_some())
    }

    /// The Jacobian that is given, or that by differences.
    fn differentiate<S: State, D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        rate: &S,
        n_rhs: &mut usize,
    ) -> Result<()> {
        #[cfg(test)]
        {
            self.counts.jacobians += 1;
        }
        let n = self.acceleration.len();
        let (q, v) = start.x.slice().split_at(n);
        if let Some(jacobian) = dynamics.jacobian(start.at, q, v)? {
            self.jacobian = jacobian;
            return Ok(());
        }
        *n_rhs += 2 * n;
        let acceleration = &rate.slice()[n..];
        let sizes = [largest(q, self.small), largest(v, self.small)];
        let drive = dynamics.drive(start.at);
        self.trial.copy_from_slice(start.x.slice());
        for j in 0..2 * n {
            let x = self.trial[j];
            self.trial[j] = x + f64::EPSILON.sqrt() * sizes[j / n];
            let step = self.trial[j] - x;
            let (q, v) = self.trial.split_at(n);
            dynamics.driven(drive, q, v, &mut self.acceleration)?;
            for (i, (there, here)) in self.acceleration.iter().zip(acceleration).enumerate() {
                self.jacobian[(i, j)] = (there - here) / step;
            }
            self.trial[j] = x;
        }
        Ok(())
    }

    /// Solves the system of the real eigenvalue for a right-hand side.
    pub fn solve_real(&mut self, right: &mut [f64]) {
        if let Some(Factors { h, real, .. }) = &mut self.factors {
            real.solve(&self.jacobian, *h, right);
        }
    }

    /// Solves the system of the complex one.
    pub fn solve_pair(&mut self, right: &mut [Complex<f64>]) {
        if let Some(Factors { h, pair, .. }) = &mut self.factors {
            pair.solve(&self.jacobian, *h, right);
        }
    }
}

/// The size of positions, or of velocities, that differences are small beside; 1 if they are all zero and no size is small.
fn largest(x: &[f64], small: f64) -> f64 {
    let floor = if small.is_finite() { small } else { 0.0 };
    let size = x.iter().fold(floor, |most, x| most.max(x.abs()));
    if size > 0.0 { size } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between -1 and 1 without a pattern.
    fn numbers(len: usize) -> Vec<f64> {
        (1..=len).map(|k| (k as f64 * 1.7).sin()).collect()
    }

    /// The system as it is, of 2n equations.
    fn full<T: ComplexField<RealField = f64> + Copy>(
        z: T,
        jacobian: &DMatrix<f64>,
        h: f64,
    ) -> DMatrix<T> {
        let n = jacobian.nrows();
        DMatrix::from_fn(2 * n, 2 * n, |i, j| {
            let diagonal = if i == j { z } else { T::zero() };
            let entry = if i >= n {
                jacobian[(i - n, j)]
            } else {
                f64::from(u8::from(j == i + n))
            };
            diagonal - T::from_real(h * entry)
        })
    }

    fn check<T: ComplexField<RealField = f64> + Copy>(z: T, stiffness: f64, h: f64) {
        let n = 3;
        let mut jacobian = DMatrix::from_vec(n, 2 * n, numbers(2 * n * n));
        // A stiff and damped motion among soft ones, and not along one axis.
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let sign = if i == j { -1.0 } else { 1.0 };
            jacobian[(i, j)] += sign * stiffness;
            jacobian[(i, n + j)] += sign * stiffness.sqrt();
        }
        // The right-hand side of a known solution, of which the velocity is as large as the position.
        let x = DVector::from_vec(numbers(2 * n)).map(T::from_real);
        let mut right = full(z, &jacobian, h) * &x;
        let mut reduced = ReducedMatrices::new(z, &jacobian, h).expect("regular");
        reduced.solve(&jacobian, h, right.as_mut_slice());
        let lost = 1e-14 * (1.0 + h.abs() * stiffness.sqrt() + h * h * stiffness);
        let error = (right - x).map(ComplexField::modulus);
        assert!(error.rows(0, n).amax() < lost, "{stiffness} {h} {error}");
        assert!(
            error.rows(n, n).amax() < lost / h.abs(),
            "{stiffness} {h} {error}"
        );
    }

    #[test]
    fn the_reduced_system_has_the_solution_of_the_whole() {
        for stiffness in [0.0, 1.0, 1e6, 1e12] {
            for h in [1.0, 1e-2, 1e-6] {
                check(REAL_EIGENVALUE, stiffness, h);
                check(PAIR, stiffness, h);
                check(PAIR, stiffness, -h);
            }
        }
    }

    #[test]
    fn a_singular_system_is_none() {
        // Two bodies that are not told apart, with a spring that pushes them away.
        let stiffness = 0.5 * REAL_EIGENVALUE * REAL_EIGENVALUE;
        let row = [stiffness, stiffness, 0.0, 0.0];
        let jacobian = DMatrix::from_row_slice(2, 4, &[row, row].concat());
        assert!(ReducedMatrices::new(REAL_EIGENVALUE, &jacobian, 1.0).is_none());
        assert!(ReducedMatrices::new(PAIR, &jacobian, 1.0).is_some());
        assert!(Factors::new(&jacobian, 1.0).is_none());
        assert!(Factors::new(&jacobian, 0.5).is_some());
    }

    #[test]
    fn differences_are_small_beside_what_there_is() {
        assert_eq!(largest(&[0.0, -3.0], 1e-3), 3.0);
        assert_eq!(largest(&[0.0, 1e-200], 1e-3), 1e-3);
        assert_eq!(largest(&[0.0], 0.0), 1.0);
        assert_eq!(largest(&[0.0], f64::INFINITY), 1.0);
        assert_eq!(largest(&[2.0], f64::NAN), 2.0);
    }
}

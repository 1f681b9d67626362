//! Linear equations of motion for integrators that take no notice of it: `q'' = M^-1 (f0 + f - C v - K q)`, with the matrices
//! over the mass kept full, or as diagonals where all three are diagonal.

use crate::error::Result;
use crate::model::{Coefficient, Dynamics, Input, LinearSystem, Moment};
use nalgebra::{DMatrix, DVector};

/// `M^-1 K` and `M^-1 C`.
pub(crate) trait OverMass {
    /// Number of degrees of freedom.
    fn n_dof(&self) -> usize;
    /// Subtracts `M^-1 (K q + C v)` from a.
    fn resist(&self, q: &[f64], v: &[f64], a: &mut [f64]);
}

/// A linear system in motion, with what acts on it over its mass.
#[derive(Debug, Clone)]
pub(crate) struct LinearMotion<O, I> {
    over_mass: O,
    input: I,
}

/// Full matrices.
#[derive(Debug, Clone)]
pub(crate) struct Full {
    stiffness: DMatrix<f64>,
    /// Empty without damping.
    damping: DMatrix<f64>,
}

/// Diagonals, each coordinate by itself.
#[derive(Debug, Clone)]
pub(crate) struct Diagonals {
    stiffness: DVector<f64>,
    /// Empty without damping.
    damping: DVector<f64>,
}

impl Full {
    /// The matrices of a system.
    pub fn new(system: &LinearSystem) -> Self {
        let over_mass = |m: &Coefficient| {
            let columns: Vec<_> = m
                .to_dense()
                .column_iter()
                .map(|c| system.solve_mass(&c.into_owned()))
                .collect();
            DMatrix::from_columns(&columns)
        };
        let damping = over_mass(system.damping());
        Self {
            stiffness: over_mass(system.stiffness()),
            damping: if damping.amax() == 0.0 {
                DMatrix::zeros(0, 0)
            } else {
                damping
            },
        }
    }
}

impl Diagonals {
    /// The diagonals of a system; `None` if one of its matrices is not diagonal.
    pub fn of(system: &LinearSystem) -> Option<Self> {
        system.mass().diagonal()?;
        let damping = system.solve_mass(&system.damping().diagonal()?);
        Some(Self {
            stiffness: system.solve_mass(&system.stiffness().diagonal()?),
            damping: if damping.amax() == 0.0 {
                DVector::zeros(0)
            } else {
                damping
            },
        })
    }
}

/// `a -= m x` for a full matrix by columns.
#[allow(
    clippy::inline_always,
    reason = "the loops are written out where the caller's state is an array"
)]
#[inline(always)]
fn subtract_product(m: &DMatrix<f64>, x: &[f64], a: &mut [f64]) {
    let n = a.len();
    for j in 0..n {
        let column = &m.as_slice()[j * n..(j + 1) * n];
        for i in 0..n {
            a[i] -= column[i] * x[j];
        }
    }
}

/// The same for a diagonal matrix.
#[allow(
    clippy::inline_always,
    reason = "the loop is written out where the caller's state is an array"
)]
#[inline(always)]
fn subtract_each(m: &DVector<f64>, x: &[f64], a: &mut [f64]) {
    for (a, (m, x)) in a.iter_mut().zip(m.as_slice().iter().zip(x)) {
        *a -= m * x;
    }
}

impl OverMass for Full {
    fn n_dof(&self) -> usize {
        self.stiffness.nrows()
    }

    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn resist(&self, q: &[f64], v: &[f64], a: &mut [f64]) {
        subtract_product(&self.stiffness, q, a);
        if !self.damping.is_empty() {
            subtract_product(&self.damping, v, a);
        }
    }
}

impl OverMass for Diagonals {
    fn n_dof(&self) -> usize {
        self.stiffness.len()
    }

    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn resist(&self, q: &[f64], v: &[f64], a: &mut [f64]) {
        subtract_each(&self.stiffness, q, a);
        subtract_each(&self.damping, v, a);
    }
}

impl<O, I> LinearMotion<O, I> {
    /// The motion of a system on which something acts.
    pub fn new(over_mass: O, input: I) -> Self {
        Self { over_mass, input }
    }
}

impl<O: OverMass, I: Input> Dynamics for LinearMotion<O, I> {
    fn n_dof(&self) -> usize {
        self.over_mass.n_dof()
    }

    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a.fill(0.0);
        self.over_mass.resist(q, v, a);
        // A moving base acts by forces.
        self.input.add(at, |_| 0.0, a);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Driven, Forcing, Harmonic};
    use nalgebra::dvector;

    #[test]
    fn diagonals_are_the_full_matrices_to_the_bit() {
        let (m, c, k) = (
            dvector![2.0, 0.3, 7.0],
            dvector![0.1, 0.0, 0.7],
            dvector![5.0, 1.1, 0.3],
        );
        let force = Harmonic::new(dvector![1.0.into(), 0.5.into(), 0.0.into()], 0.7, 0.2);
        let forcing = Forcing::from(force.expect("valid"));
        let load = dvector![0.3, 0.0, -1.0];
        let diagonal = LinearSystem::new(m, c, k)
            .and_then(|s| s.with_load(load))
            .expect("valid");
        let (q, v) = ([0.3, -0.2, 0.9], [1.1, 0.4, -0.6]);
        let at = Moment {
            time: 0.4,
            angle: 0.48,
        };
        let (mut one, mut other) = ([0.0; 3], [0.0; 3]);
        let input = Driven::over_mass(&diagonal, &forcing).expect("driven");
        let diagonals = Diagonals::of(&diagonal).expect("diagonal");
        let diagonals = LinearMotion::new(diagonals, input.clone());
        let full = LinearMotion::new(Full::new(&diagonal), input);
        diagonals
            .acceleration(at, &q, &v, &mut one)
            .expect("linear");
        full.acceleration(at, &q, &v, &mut other).expect("linear");
        assert_eq!(one, other);
        let full = DMatrix::from_element(3, 3, 1.0);
        let coupled = LinearSystem::new(dvector![1.0, 1.0, 1.0], full, dvector![1.0, 1.0, 1.0]);
        assert!(Diagonals::of(&coupled.expect("valid")).is_none());
    }
}

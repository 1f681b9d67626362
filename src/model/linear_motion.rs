//! Linear equations of motion for integrators that take no notice of it: `q'' = M^-1 (f0 + f - C v - K q)`, with the matrices
//! over the mass kept full, or as diagonals where all three are diagonal.

use crate::error::Result;
use crate::model::dynamics::{Dynamics, Force, Moment};
use crate::model::{Coefficient, Forcing, LinearSystem};
use nalgebra::{DMatrix, DVector};

/// `M^-1 K` and `M^-1 C`.
pub(crate) trait OverMass {
    /// Subtracts `M^-1 (K q + C v)` from a.
    fn resist(&self, q: &[f64], v: &[f64], a: &mut [f64]);
}

/// A linear system in motion.
#[derive(Debug, Clone)]
pub(crate) struct LinearMotion<O> {
    over_mass: O,
    load: DVector<f64>,
    force: Force,
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

impl OverMass for Full {
    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn resist(&self, q: &[f64], v: &[f64], a: &mut [f64]) {
        let n = a.len();
        let (stiffness, damping) = (self.stiffness.as_slice(), self.damping.as_slice());
        if damping.is_empty() {
            for j in 0..n {
                let k = &stiffness[j * n..(j + 1) * n];
                for i in 0..n {
                    a[i] -= k[i] * q[j];
                }
            }
            return;
        }
        for j in 0..n {
            let column = j * n..(j + 1) * n;
            let (k, c) = (&stiffness[column.clone()], &damping[column]);
            for i in 0..n {
                a[i] -= k[i] * q[j] + c[i] * v[j];
            }
        }
    }
}

impl OverMass for Diagonals {
    #[allow(
        clippy::inline_always,
        reason = "the loop is written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn resist(&self, q: &[f64], v: &[f64], a: &mut [f64]) {
        let (stiffness, damping) = (self.stiffness.as_slice(), self.damping.as_slice());
        if damping.is_empty() {
            for (a, (k, q)) in a.iter_mut().zip(stiffness.iter().zip(q)) {
                *a -= k * q;
            }
            return;
        }
        let rows = stiffness.iter().zip(damping);
        for (a, ((k, c), (q, v))) in a.iter_mut().zip(rows.zip(q.iter().zip(v))) {
            *a -= k * q + c * v;
        }
    }
}

impl<O> LinearMotion<O> {
    /// The motion of a system under its forcing.
    pub fn new(over_mass: O, system: &LinearSystem, forcing: &Forcing) -> Self {
        let force = forcing
            .frequency()
            .map(|_| system.solve_mass_complex(&forcing.force_on(system)));
        Self {
            over_mass,
            load: system.solve_mass(system.load()),
            force: Force(force),
        }
    }
}

impl<O: OverMass> Dynamics for LinearMotion<O> {
    fn n_dof(&self) -> usize {
        self.load.len()
    }

    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a.copy_from_slice(self.load.as_slice());
        self.over_mass.resist(q, v, a);
        self.force.add(at, a);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Harmonic;
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
        let diagonals = Diagonals::of(&diagonal).expect("diagonal");
        LinearMotion::new(diagonals, &diagonal, &forcing)
            .acceleration(at, &q, &v, &mut one)
            .expect("linear");
        LinearMotion::new(Full::new(&diagonal), &diagonal, &forcing)
            .acceleration(at, &q, &v, &mut other)
            .expect("linear");
        assert_eq!(one, other);
        let full = DMatrix::from_element(3, 3, 1.0);
        let coupled = LinearSystem::new(dvector![1.0, 1.0, 1.0], full, dvector![1.0, 1.0, 1.0]);
        assert!(Diagonals::of(&coupled.expect("valid")).is_none());
    }
}

//! Linear equations of motion for integrators that take no notice of it: `q'' = M^-1 (f0 + f - C v - K q)`, with the matrices
//! over the mass kept full, or as diagonals where all three are diagonal.

use crate::error::Result;
use crate::model::dynamics::Dynamics;
use crate::model::input::{Driven, Input, NoInput};
use crate::model::linear::{Coefficient, LinearSystem};
use crate::model::moment::Moment;
use nalgebra::{DMatrix, DVector};

/// A matrix over the mass: full, or a diagonal, each coordinate by itself.
pub(crate) trait OverMass {
    /// Number of degrees of freedom.
    fn n_dof(&self) -> usize;
    /// Subtracts its product with x from a.
    fn subtract(&self, x: &[f64], a: &mut [f64]);
}

impl OverMass for DMatrix<f64> {
    fn n_dof(&self) -> usize {
        self.nrows()
    }

    #[allow(
        clippy::inline_always,
        clippy::needless_range_loop,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn subtract(&self, x: &[f64], a: &mut [f64]) {
        let n = a.len();
        for j in 0..n {
            let column = &self.as_slice()[j * n..(j + 1) * n];
            for i in 0..n {
                a[i] -= column[i] * x[j];
            }
        }
    }
}

impl OverMass for DVector<f64> {
    fn n_dof(&self) -> usize {
        self.len()
    }

    #[inline]
    fn subtract(&self, x: &[f64], a: &mut [f64]) {
        for (a, (m, x)) in a.iter_mut().zip(self.as_slice().iter().zip(x)) {
            *a -= m * x;
        }
    }
}

/// What resists a velocity: `M^-1 C`, nothing, or either.
pub(crate) trait Damping {
    /// Subtracts its force over the mass from a.
    fn resist(&self, v: &[f64], a: &mut [f64]);
}

/// Nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Undamped;

impl Damping for Undamped {
    #[inline]
    fn resist(&self, _v: &[f64], _a: &mut [f64]) {}
}

impl<O: OverMass> Damping for O {
    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn resist(&self, v: &[f64], a: &mut [f64]) {
        self.subtract(v, a);
    }
}

impl<O: OverMass> Damping for Option<O> {
    #[inline]
    fn resist(&self, v: &[f64], a: &mut [f64]) {
        if let Some(damping) = self {
            damping.subtract(v, a);
        }
    }
}

/// A linear system in motion, over its mass.
#[derive(Debug, Clone)]
pub(crate) struct LinearMotion<O, C, I> {
    stiffness: O,
    damping: C,
    input: I,
}

/// A linear motion by what it has.
pub(crate) enum ByParts<O> {
    Free(LinearMotion<O, Undamped, NoInput>),
    Driven(LinearMotion<O, Undamped, Driven>),
    Damped(LinearMotion<O, O, NoInput>),
    DampedDriven(LinearMotion<O, O, Driven>),
}

impl<O: OverMass, C: Damping, I: Input> Dynamics for LinearMotion<O, C, I> {
    type Drive = I::Push;

    fn n_dof(&self) -> usize {
        self.stiffness.n_dof()
    }

    #[inline]
    fn drive(&self, at: Moment) -> I::Push {
        self.input.push(at)
    }

    #[allow(
        clippy::inline_always,
        reason = "the loops are written out where the caller's state is an array"
    )]
    #[inline(always)]
    fn driven(&self, push: I::Push, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a.fill(0.0);
        self.stiffness.subtract(q, a);
        self.damping.resist(v, a);
        // A moving base acts by forces.
        self.input.add(push, |_| 0.0, a);
        Ok(())
    }
}

impl<O: Clone> LinearMotion<O, Option<O>, Option<Driven>> {
    /// The same by what it has.
    pub fn by_parts(&self) -> ByParts<O> {
        match (self.damping.clone(), self.input.clone()) {
            (None, None) => ByParts::Free(self.of(Undamped, NoInput)),
            (None, Some(input)) => ByParts::Driven(self.of(Undamped, input)),
            (Some(damping), None) => ByParts::Damped(self.of(damping, NoInput)),
            (Some(damping), Some(input)) => ByParts::DampedDriven(self.of(damping, input)),
        }
    }

    fn of<C, I>(&self, damping: C, input: I) -> LinearMotion<O, C, I> {
        LinearMotion {
            stiffness: self.stiffness.clone(),
            damping,
            input,
        }
    }
}

impl LinearMotion<DMatrix<f64>, Option<DMatrix<f64>>, Option<Driven>> {
    /// The motion of a system with full matrices.
    pub fn full(system: &LinearSystem, input: Option<Driven>) -> Self {
        let over_mass = |m: &Coefficient| {
            let columns: Vec<_> = m
                .to_dense()
                .column_iter()
                .map(|c| system.solve_mass(&c.into_owned()))
                .collect();
            DMatrix::from_columns(&columns)
        };
        let damping = Some(over_mass(system.damping())).filter(|c| c.amax() != 0.0);
        Self {
            stiffness: over_mass(system.stiffness()),
            damping,
            input,
        }
    }
}

impl LinearMotion<DVector<f64>, Option<DVector<f64>>, Option<Driven>> {
    /// The motion of a system whose matrices are diagonal; `None` if one of them is not.
    pub fn diagonal(system: &LinearSystem, input: Option<Driven>) -> Option<Self> {
        let (_, damping, stiffness) = system.diagonals()?;
        let damping = Some(system.solve_mass(&damping)).filter(|c| c.amax() != 0.0);
        Some(Self {
            stiffness: system.solve_mass(&stiffness),
            damping,
            input,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Excitation, Forcing, Harmonic, SceneMotion};
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
        let at = Moment::new(0.4, 0.48, 0.7);
        let (mut one, mut other) = ([0.0; 3], [0.0; 3]);
        let excitation = Excitation::new(&diagonal.clone().into(), &forcing);
        let input = Driven::new(&excitation.over_mass(&diagonal));
        let diagonals = LinearMotion::diagonal(&diagonal, input.clone()).expect("diagonal");
        let full = SceneMotion::Full(LinearMotion::full(&diagonal, input));
        let diagonals = SceneMotion::Diagonal(diagonals);
        (diagonals.acceleration(at, &q, &v, &mut one)).expect("linear");
        (full.acceleration(at, &q, &v, &mut other)).expect("linear");
        assert_eq!(one, other);
        let full = DMatrix::from_element(3, 3, 1.0);
        let coupled = LinearSystem::new(dvector![1.0, 1.0, 1.0], full, dvector![1.0, 1.0, 1.0]);
        assert!(LinearMotion::diagonal(&coupled.expect("valid"), None).is_none());
    }
}

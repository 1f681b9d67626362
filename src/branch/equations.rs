//! The equations `G(Z, p) = 0` of a closed loop Z at a value p of the parameter, linearised: `G_Z` exactly, the column `G_p` by central
//! differences (theory 19). Rows and unknowns are scaled, in units of the motion; what they are is asked of the formulation.

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::continuation::bordered;
use crate::error::{Error, Result};
use crate::linalg::determinant::{Determinant, signed_volume};
use crate::model::Scene;
use crate::orbit::{Linearised, PeriodicOrbit, ShootingState};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The linearised equations at a loop: `rows xi + column pi = right`, xi the correction of its scaled unknowns, pi that of the parameter in
/// parts of its range.
#[derive(Clone)]
pub(super) struct Equations {
    /// The Jacobian by the unknowns of the loop, shape `(n_equations, n_unknowns)`, \[-\].
    pub rows: DMatrix<f64>,
    pub by_value: ParameterDerivative,
    /// Minus the residual, shape `(n_equations,)`, \[-\].
    pub right: DVector<f64>,
    /// How far the loop is from closing, in parts of the motion's size \[-\].
    pub mismatch: f64,
    pub scene: Arc<Scene>,
    /// The flights, linearised; `None` for a loop whose unknowns are its impulses.
    pub flights: Option<Linearised>,
}

/// The point that a step begins from: its loop, the equations there, and the tangent of the branch.
pub(super) type BasePoint<'a> = (&'a ParametricLoop, &'a Equations, &'a BranchDirection);

/// Derivatives by pi, the parameter in parts of its range.
#[derive(Clone, Default)]
pub(super) struct ParameterDerivative {
    /// Of the residual, shape `(n_equations,)`, \[-\].
    pub column: DVector<f64>,
    /// Of the states and of the starts of the flights; empty for a loop whose unknowns are its impulses.
    pub flights: ShootingState,
}

impl Equations {
    /// The equations that a loop closes by, by their rows, minus their residual and how far it is from closing.
    pub fn closing(
        scene: Arc<Scene>,
        (rows, right, mismatch): (DMatrix<f64>, DVector<f64>, f64),
        flights: Option<Linearised>,
    ) -> Self {
        Self {
            rows,
            by_value: ParameterDerivative::default(),
            right,
            mismatch,
            scene,
            flights,
        }
    }

    /// The test function of branch points: it changes its sign where another branch is crossed, along the tangent of this one.
    pub fn crossing(&self, tangent: &BranchDirection) -> f64 {
        signed_volume(bordered(self, tangent))
    }

    /// The linearised flights of a loop whose unknowns are its states.
    pub fn flights(&self) -> &Linearised {
        let flights = self.flights.as_ref();
        flights.expect("the equations are those of shooting")
    }

    /// The Jacobian `[G_Z G_p]`, the column of the parameter last.
    pub fn all_columns(&self) -> DMatrix<f64> {
        let last = self.rows.ncols();
        let mut matrix = self.rows.clone().insert_column(last, 0.0);
        matrix.set_column(last, &self.by_value.column);
        matrix
    }
}

impl BranchProblem<'_> {
    /// The equations at a loop.
    pub fn equations(&self, place: &ParametricLoop) -> Result<Equations> {
        let equations = self.equations_nearby(place, &ParameterDerivative::default())?;
        self.renewed(place, equations)
    }

    /// The equations with the derivatives by the parameter of a loop nearby, which saves their differences: corrections converge a little
    /// slower, to the same solution.
    pub fn equations_nearby(
        &self,
        place: &ParametricLoop,
        by_value: &ParameterDerivative,
    ) -> Result<Equations> {
        let equations = self.closing_equations(place)?;
        // The mismatch is relative to the motion's size where that has outgrown the units.
        let grown = self.size(&place.state).max(1.0);
        Ok(Equations {
            by_value: by_value.clone(),
            mismatch: equations.mismatch / grown,
            ..equations
        })
    }

    /// The equations with the derivatives by the parameter taken at the loop itself.
    pub fn renewed(&self, place: &ParametricLoop, equations: Equations) -> Result<Equations> {
        let by_value = self.by_value(place, &equations)?;
        Ok(Equations {
            by_value,
            ..equations
        })
    }

    /// The equations of a loop taken for those of one next to it.
    pub fn equations_at(&self, place: &ParametricLoop, equations: Equations) -> Result<Equations> {
        Ok(Equations {
            scene: self.scene(place.value)?,
            ..equations
        })
    }

    /// The speed at which the stop of an instant is approached, of the first stop if several are hit.
    pub fn approach(&self, place: &ParametricLoop, instant: usize) -> Result<f64> {
        Ok(self.approaches(place)?[instant])
    }

    /// The test function of a multiplier: it changes its sign where one passes through a number, and nowhere else.
    pub fn multiplier_test(
        &self,
        at: (&ParametricLoop, Option<&Equations>),
        multiplier: f64,
    ) -> Result<f64> {
        let own = self.multiplier_determinant(at, multiplier)?;
        Ok(own.in_parts_of(own.lengths))
    }

    /// A smooth determinant that is zero where a number is a multiplier; it takes the equations at the loop where they are known.
    pub fn multiplier_determinant(
        &self,
        at: (&ParametricLoop, Option<&Equations>),
        multiplier: f64,
    ) -> Result<Determinant> {
        Ok(Determinant::of(self.variational(at, multiplier)?))
    }

    /// The orbit of a closed loop, checked by another route: it has to close when it is flown once more, a half motion for the whole
    /// period, a loop of impulses by its flights.
    ///
    /// # Errors
    /// As [`orbit`](Self::orbit); a motion that does not close.
    pub fn closed_orbit(&self, place: &ParametricLoop) -> Result<PeriodicOrbit> {
        let orbit = self.orbit(place)?;
        match orbit.closure_defect([self.units.position, self.units.velocity])? {
            None => Ok(orbit),
            Some(residual) => Err(Error::NoConvergence {
                stage: "the motion, followed once more by another route,",
                iterations: 0,
                residual,
            }),
        }
    }

    /// A function at both ends of a difference about a value, with the ends; at the value itself in place of an end that the scene refuses.
    pub fn beside<T>(
        &self,
        value: f64,
        at: &dyn Fn(f64) -> Result<T>,
        here: impl FnOnce() -> Result<T>,
    ) -> Result<[(f64, T); 2]> {
        let step = self.difference(value);
        let (above, below) = (value + step, value - step);
        let is_refused = |found: &Result<T>| matches!(found, Err(Error::BadValue { .. }));
        Ok(match (at(above), at(below)) {
            (Ok(upper), lower) if is_refused(&lower) => [(above, upper), (value, here()?)],
            (upper, Ok(lower)) if is_refused(&upper) => [(value, here()?), (below, lower)],
            (upper, lower) => [(above, upper?), (below, lower?)],
        })
    }
}

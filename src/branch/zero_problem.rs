//! A branch as a curve of zeros: the equations of its loops, and its tangents (theory 19).

use crate::branch::equations::Equations;
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::continuation::{Corrected, Linearisation, ScaledDirection, ZeroProblem};
use crate::error::Result;
use crate::linalg::rank;
use crate::tolerance::{CROSSING_CORRECTION, FREE_DIRECTION};
use nalgebra::{DMatrix, DVector};

/// A point of a branch as the corrector leaves it.
pub(super) type CorrectedPoint = Corrected<ParametricLoop, Equations, BranchDirection>;

impl Linearisation for Equations {
    fn matrix(&self) -> DMatrix<f64> {
        self.all_columns()
    }

    fn right(&self) -> &DVector<f64> {
        &self.right
    }

    fn mismatch(&self) -> f64 {
        self.mismatch
    }
}

impl ZeroProblem for BranchProblem<'_> {
    type Iterate = ParametricLoop;
    type Equations = Equations;
    type Direction = BranchDirection;

    /// The parameter. `[exact]`
    const N_NUMBERS: usize = 1;
    /// `[work]`
    const MOST_CORRECTIONS: usize = 6;
    const KEPT_CORRECTION: Option<f64> = Some(CROSSING_CORRECTION);

    fn value(&self, place: &ParametricLoop) -> f64 {
        place.value
    }

    fn coinciding(&self, place: &ParametricLoop) -> Option<usize> {
        place.coinciding_instant()
    }

    fn linearise(&self, place: &ParametricLoop, near: Option<&Equations>) -> Result<Equations> {
        match near {
            Some(near) => self.equations_nearby(place, &near.by_value),
            None => self.equations(place),
        }
    }

    fn retract(
        &self,
        place: &ParametricLoop,
        equations: &Equations,
        by: &BranchDirection,
    ) -> Result<ParametricLoop> {
        self.moved(place, equations, by)
    }

    fn settle(
        &self,
        mut place: ParametricLoop,
        equations: Equations,
        by: Option<&BranchDirection>,
    ) -> Result<(ParametricLoop, Equations)> {
        let equations = self.renewed(&place, equations)?;
        if let Some(by) = by {
            place = self.moved(&place, &equations, by)?;
        }
        let equations = self.equations_at(&place, equations)?;
        Ok((place, equations))
    }

    fn pin(&self, place: ParametricLoop, _: usize, value: f64) -> Result<ParametricLoop> {
        Ok(ParametricLoop { value, ..place })
    }
}

/// The null space of `[G_Z G_p]`, orthonormal: the tangent alone, but at branch points and in families of orbits more.
pub(super) fn directions(equations: &Equations) -> Result<Vec<BranchDirection>> {
    let all = equations.all_columns();
    let tolerance = FREE_DIRECTION * all.amax();
    let found = rank::solve(&all, &DVector::zeros(all.nrows()), tolerance)?.null_space;
    let each = found
        .column_iter()
        .map(|numbers| BranchDirection::of(&numbers.into_owned()).unit());
    Ok(each.collect())
}

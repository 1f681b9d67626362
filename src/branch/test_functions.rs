//! Test functions of a branch, which change their signs at bifurcations (theory 19).

use crate::branch::equations::BasePoint;
use crate::branch::parametric_loop::BranchDirection;
use crate::branch::problem::BranchProblem;
use crate::error::Result;
use crate::orbit::PeriodicOrbit;

/// The part of a unit tangent in the parameter: it changes its sign at a fold.
pub(super) fn fold(tangent: &BranchDirection) -> f64 {
    tangent.value_part
}

/// The values of all test functions at a point of a branch \[-\].
#[derive(Debug, Clone, Copy)]
pub(super) struct TestFunctionValues {
    /// [`fold`] of the tangent.
    pub fold: f64,
    /// It changes its sign where a multiplier passes through -1; for loops of half a period, a multiplier of that.
    pub doubling: f64,
    /// It changes its sign where another branch is crossed.
    pub crossing: f64,
    /// How many multipliers lie outside the unit circle; not counted where the energy is kept, as no torus is looked for there.
    pub outside: Option<usize>,
}

impl TestFunctionValues {
    /// The values for the tangent times a sign.
    pub fn along(self, sign: f64) -> Self {
        Self {
            fold: self.fold * sign,
            crossing: self.crossing * sign,
            ..self
        }
    }

    /// The values at a point and its orbit.
    pub fn at(
        problem: &BranchProblem<'_>,
        (place, equations, tangent): BasePoint<'_>,
        orbit: &PeriodicOrbit,
    ) -> Result<Self> {
        Ok(Self {
            fold: fold(tangent),
            doubling: problem.doubling_test(place, equations)?,
            crossing: equations.crossing(tangent),
            outside: problem.n_outside(place, orbit)?,
        })
    }
}

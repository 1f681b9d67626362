//! A step along a branch: the predictor along the tangent, then the corrector (theory 19).

use crate::branch::equations::{BasePoint, Equations};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::branch::test_functions::TestFunctionValues;
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{Attempt, ScaledDirection, stepped, stepped_to};
use crate::error::Result;
use crate::orbit::PeriodicOrbit;

/// A point of a branch that was accepted, with its orbit and its test functions.
#[derive(Clone)]
pub(super) struct AcceptedPoint {
    pub place: ParametricLoop,
    pub equations: Equations,
    pub tangent: BranchDirection,
    pub orbit: PeriodicOrbit,
    /// From the first point, in scaled unknowns \[-\].
    pub arclength: f64,
    pub test_values: TestFunctionValues,
}

/// What a step leads to.
#[derive(Clone, Copy)]
pub(super) enum StepTarget {
    /// An arclength along the tangent \[-\].
    Length(f64),
    /// A value of the parameter.
    Value(f64),
}

impl AcceptedPoint {
    /// A corrected point at an arclength, its tangent ahead by the sign of a number.
    pub fn settled(
        problem: &BranchProblem<'_>,
        (settled, orbit): (CorrectedPoint, PeriodicOrbit),
        (ahead, arclength): (f64, f64),
    ) -> Result<Self> {
        let CorrectedPoint {
            iterate: place,
            equations,
            tangent,
            ..
        } = settled;
        let tangent = tangent.scaled(ahead.signum());
        Ok(Self {
            test_values: TestFunctionValues::at(problem, (&place, &equations, &tangent), &orbit)?,
            place,
            equations,
            tangent,
            orbit,
            arclength,
        })
    }

    /// The point as the base of a step.
    pub fn base(&self) -> BasePoint<'_> {
        (&self.place, &self.equations, &self.tangent)
    }
}

/// A step along a branch: its predictor and corrector.
pub(super) fn step_to(
    problem: &BranchProblem<'_>,
    base: BasePoint<'_>,
    target: StepTarget,
) -> Attempt<CorrectedPoint> {
    match target {
        StepTarget::Length(length) => stepped(problem, base, length),
        StepTarget::Value(value) => {
            let (place, _, tangent) = base;
            let ahead = (value - place.value) / problem.span();
            stepped_to(problem, base, ahead / tangent.value_part, (0, value))
        }
    }
}

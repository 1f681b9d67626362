//! A step along a branch: the predictor along the tangent, then the corrector (theory 19).

use crate::branch::corrector::{Attempt, CorrectedPoint, attempted};
use crate::branch::equations::{BasePoint, Equations};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::branch::test_functions::TestFunctionValues;
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
    /// The point as the base of a step.
    pub fn base(&self) -> BasePoint<'_> {
        (&self.place, &self.equations, &self.tangent)
    }
}

/// A step along a branch: its predictor and corrector.
pub(super) fn step_to(
    problem: &BranchProblem<'_>,
    (place, equations, tangent): BasePoint<'_>,
    target: StepTarget,
) -> Attempt<CorrectedPoint> {
    let (length, normal) = match target {
        StepTarget::Length(length) => (length, tangent.clone()),
        StepTarget::Value(value) => {
            let ahead = (value - place.value) / problem.span();
            let by_value = BranchDirection::of_value(tangent.loop_part.len());
            (ahead / tangent.value_part, by_value)
        }
    };
    let moved = problem.moved(place, equations, &tangent.scaled(length));
    let mut moved = match attempted(moved, place.value)? {
        Ok(place) => place,
        Err(failure) => return Ok(Err(failure)),
    };
    if let StepTarget::Value(value) = target {
        moved.value = value;
    }
    let mut found = problem.corrected(moved, &normal)?;
    if let (Ok(settled), StepTarget::Value(value)) = (&mut found, target) {
        settled.place.value = value;
    }
    Ok(found)
}

//! A step along a curve to a value of a number; and chords between loops (theory 20).

use crate::branch::curve::direction::CurveDirection;
use crate::branch::curve::problem::{CurveProblem, TwoParameterLoop};
use crate::branch::curve::zero_problem::CorrectedCurvePoint;
use crate::continuation::{Attempt, stepped_to};
use nalgebra::DVector;

/// A step, no longer than some arclength, to where one of the numbers has a value.
pub(super) fn step_to_number(
    plane: &CurveProblem<'_>,
    from: &CorrectedCurvePoint,
    step: f64,
    (axis, end): (usize, f64),
) -> Attempt<CorrectedCurvePoint> {
    let at = [from.iterate.place.value, from.iterate.second][axis];
    let ahead = (end - at) / (from.tangent.numbers()[axis] * plane.span(axis));
    let ahead = if ahead.is_finite() {
        ahead.clamp(0.0, step)
    } else {
        step
    };
    stepped_to(plane, from.base(), ahead, (axis, end))
}

/// A loop shifted by whole turns of the forcing, so that it is nearest in time to another.
pub(super) fn turned_to(
    plane: &CurveProblem<'_>,
    iterate: &TwoParameterLoop,
    other: &TwoParameterLoop,
) -> TwoParameterLoop {
    let place = plane.along(0, iterate, |problem| {
        let turns = problem.turns(&iterate.place, &other.place);
        Ok(iterate.place.turned(turns))
    });
    TwoParameterLoop {
        place: place.unwrap_or_else(|_| iterate.place.clone()),
        second: iterate.second,
    }
}

/// The chord from a loop to another, in scaled unknowns and both numbers.
pub(super) fn chord(
    plane: &CurveProblem<'_>,
    from: &TwoParameterLoop,
    to: &TwoParameterLoop,
) -> CurveDirection {
    let place = plane.along(0, from, |problem| {
        Ok(problem.between(&from.place, &to.place))
    });
    let second = (to.second - from.second) / plane.span(1);
    CurveDirection(place.map_or_else(|_| DVector::zeros(0), |own| own.numbers().push(second)))
}

//! A step along a curve: the predictor along the tangent, then the corrector; and chords between loops (theory 20).

use crate::branch::corrector::{Attempt, attempted};
use crate::branch::curve::corrector::CorrectedCurvePoint;
use crate::branch::curve::problem::{CurveProblem, TwoParameterLoop};
use nalgebra::DVector;

/// A step along a curve by some arclength, corrected on the plane of a normal row.
pub(super) fn stepped(
    plane: &CurveProblem<'_>,
    from: &CorrectedCurvePoint,
    tangent: &DVector<f64>,
    ahead: f64,
    normal: &DVector<f64>,
) -> Attempt<CorrectedCurvePoint> {
    let moved = plane.moved(&from.iterate, &from.conditions, &(tangent * ahead));
    let iterate = match attempted(moved, from.iterate.place.value)? {
        Ok(iterate) => iterate,
        Err(failure) => return Ok(Err(failure)),
    };
    plane.corrected(iterate, normal)
}

/// A step, no longer than some arclength, to where one of the numbers has a value.
pub(super) fn stepped_to(
    plane: &CurveProblem<'_>,
    from: &CorrectedCurvePoint,
    tangent: &DVector<f64>,
    step: f64,
    (axis, end): (usize, f64),
) -> Attempt<CorrectedCurvePoint> {
    let at = [from.iterate.place.value, from.iterate.second][axis];
    let column = tangent.len() - 2 + axis;
    let ahead = (end - at) / (tangent[column] * plane.span(axis));
    let ahead = if ahead.is_finite() {
        ahead.clamp(0.0, step)
    } else {
        step
    };
    let mut row = DVector::zeros(tangent.len());
    row[column] = 1.0;
    let moved = plane.moved(&from.iterate, &from.conditions, &(tangent * ahead));
    let there = moved.and_then(|iterate| plane.at_value(&iterate, axis, end));
    let iterate = match attempted(there, from.iterate.place.value)? {
        Ok(iterate) => iterate,
        Err(failure) => return Ok(Err(failure)),
    };
    let found = plane.corrected(iterate, &row)?;
    let Ok(there) = found else {
        return Ok(found);
    };
    // Corrections leave the number at its value but for rounding.
    let iterate = plane.at_value(&there.iterate, axis, end)?;
    Ok(Ok(CorrectedCurvePoint { iterate, ..there }))
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
) -> DVector<f64> {
    let place = plane.along(0, from, |problem| {
        Ok(problem.between(&from.place, &to.place))
    });
    let second = (to.second - from.second) / plane.span(1);
    place.map_or_else(|_| DVector::zeros(0), |own| own.numbers().push(second))
}

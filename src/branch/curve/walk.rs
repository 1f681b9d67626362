//! One half of a curve, step by step from its first point to its end (theory 20).

use crate::branch::corrector::Attempt;
use crate::branch::curve::codimension_two::passed;
use crate::branch::curve::condition::Condition;
use crate::branch::curve::corrector::{CorrectedCurvePoint, length, weighted};
use crate::branch::curve::point::AcceptedCurvePoint;
use crate::branch::curve::predictor::{chord, stepped, stepped_to, turned_to};
use crate::branch::curve::problem::{CurveProblem, TwoParameterLoop};
use crate::branch::curve::result::CurvePoint;
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::half_branch::HalfBranch;
use crate::branch::options::ContinuationOptions;
use crate::branch::step_control::step_factor;
use crate::error::{Error, Result, digits};
use crate::tolerance::CLOSED_BRANCH_DIRECTION;
use nalgebra::DVector;
use std::ops::ControlFlow;

/// Follows a curve from a point, which is not among the points returned, along its tangent.
pub(super) fn walk(
    plane: &CurveProblem<'_>,
    first: &AcceptedCurvePoint,
    options: &ContinuationOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<HalfBranch<AcceptedCurvePoint, CurvePoint>> {
    let mut half = HalfBranch {
        points: Vec::new(),
        special: Vec::new(),
        end: BranchEnd::new(EndReason::Points, String::new()),
    };
    let [smallest, usual, largest] = options.steps;
    let mut step = usual;
    let mut farthest = 0.0f64;
    half.end = loop {
        let from = half.points.last().unwrap_or(first);
        let at = [from.found.iterate.place.value, from.found.iterate.second];
        if half.points.len() >= options.max_points {
            let detail = format!("{} points were asked for", options.max_points);
            break BranchEnd::new(EndReason::Points, detail);
        }
        if observer(at[0]).is_break() {
            break broken_off(at);
        }
        let end = reached(plane, &from.found.iterate, &from.found.tangent, step);
        if let Some((axis, value)) = end.filter(|&(axis, value)| at[axis] == value) {
            break range_end(axis, value);
        }
        let refused = match advance(plane, from, (step, end)) {
            Err(Error::Interrupted) => break broken_off(at),
            Err(error) => return Err(error),
            Ok(CurveStepOutcome::Accepted(point, factor)) => {
                let mut special = passed(plane, from, &point)?;
                let last = special.iter().position(|own| is_last(plane, &own.0));
                let last = last.map(|k| {
                    special.truncate(k + 1);
                    special[k].clone()
                });
                half.special.extend(special.into_iter().map(|own| own.0));
                if let Some((last, found)) = last {
                    half.points
                        .push(AcceptedCurvePoint::at(plane, found, last.arclength)?);
                    let detail = format!("{}: beyond it the two multipliers are real", last.kind);
                    break BranchEnd::new(EndReason::Boundary, detail);
                }
                if plane.condition == Condition::OnCircle && is_real(&point) {
                    let detail = "beyond it the two multipliers are real".to_owned();
                    break BranchEnd::new(EndReason::Boundary, detail);
                }
                let iterate = &point.found.iterate;
                let begun = turned_to(plane, &first.found.iterate, iterate);
                let home = chord(plane, &begun, iterate);
                let away = length(&home);
                let along = point.found.tangent.dot(&weighted(&first.found.tangent));
                let has_closed =
                    farthest > 2.0 * step && away < step && along > CLOSED_BRANCH_DIRECTION;
                farthest = farthest.max(away);
                if has_closed {
                    let is_past = home.dot(&weighted(&first.found.tangent)) > 0.0;
                    let before = if is_past { from.clone() } else { *point };
                    if !is_past {
                        half.points.push(before.clone());
                    }
                    half.points.push(closing(plane, &before, (first, begun)));
                    let detail = "it came back to where it began".to_owned();
                    break BranchEnd::new(EndReason::Closed, detail);
                }
                half.points.push(*point);
                step = (step * factor).clamp(smallest, largest);
                continue;
            }
            Ok(CurveStepOutcome::Refused(end)) => end,
        };
        if step <= smallest {
            break refused;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(half)
}

/// The outcome of a step: a point and the factor on the next step, or why there is none.
enum CurveStepOutcome {
    Accepted(Box<AcceptedCurvePoint>, f64),
    Refused(BranchEnd),
}

/// Makes a step from a point and judges it.
fn advance(
    plane: &CurveProblem<'_>,
    from: &AcceptedCurvePoint,
    ahead: (f64, Option<(usize, f64)>),
) -> Result<CurveStepOutcome> {
    let tangent = &from.found.tangent;
    let mut found = match within(plane, &from.found, tangent, ahead)? {
        Ok(found) => found,
        Err(failure) => return Ok(CurveStepOutcome::Refused(failure.end())),
    };
    let side = found.tangent.dot(&weighted(tangent));
    found.tangent *= side.signum();
    Ok(match step_factor(found.contraction, side) {
        Ok(factor) => {
            let covered = length(&chord(plane, &from.found.iterate, &found.iterate));
            let point = AcceptedCurvePoint::at(plane, found, from.arclength + covered)?;
            let least = [plane.units.position, plane.units.velocity];
            match point.orbit.closure_defect(least)? {
                None => CurveStepOutcome::Accepted(Box::new(point), factor),
                Some(by) => {
                    let detail = format!(
                        "the motion, followed once more by another route, misses its beginning by {}",
                        digits(by)
                    );
                    CurveStepOutcome::Refused(BranchEnd::new(EndReason::Step, detail))
                }
            }
        }
        Err(reason) => {
            CurveStepOutcome::Refused(BranchEnd::new(EndReason::Step, reason.to_owned()))
        }
    })
}

/// Whether a curve ends at a point: two multipliers on the circle meet where it crosses the real axis.
fn is_last(plane: &CurveProblem<'_>, own: &CurvePoint) -> bool {
    plane.condition == Condition::OnCircle && matches!(own.kind, "strong_1_1" | "strong_1_2")
}

/// Whether the two multipliers of a point whose product is 1 are real.
fn is_real(point: &AcceptedCurvePoint) -> bool {
    point.test_values.iter().any(|(kind, value)| match *kind {
        "strong_1_1" => *value > 0.0,
        "strong_1_2" => *value < 0.0,
        _ => false,
    })
}

/// The first point again as the last one of a closed curve.
fn closing(
    plane: &CurveProblem<'_>,
    from: &AcceptedCurvePoint,
    (first, iterate): (&AcceptedCurvePoint, TwoParameterLoop),
) -> AcceptedCurvePoint {
    let covered = length(&chord(plane, &from.found.iterate, &iterate));
    AcceptedCurvePoint {
        arclength: from.arclength + covered,
        found: CorrectedCurvePoint {
            iterate,
            ..first.found.clone()
        },
        ..first.clone()
    }
}

/// The end of a curve that the observer interrupts.
fn broken_off([x, y]: [f64; 2]) -> BranchEnd {
    let detail = format!("broken off at ({}, {})", digits(x), digits(y));
    BranchEnd::new(EndReason::Interrupted, detail)
}

/// The end of a curve at an end of a range.
fn range_end(axis: usize, value: f64) -> BranchEnd {
    let name = ["first", "second"][axis];
    let detail = format!("the range of the {name} number ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

/// The number whose range ends within a step, by its axis, and the value there.
fn reached(
    plane: &CurveProblem<'_>,
    from: &TwoParameterLoop,
    tangent: &DVector<f64>,
    step: f64,
) -> Option<(usize, f64)> {
    let at = [from.place.value, from.second];
    let ahead = (0..2).filter_map(|axis| {
        let (low, high) = plane.between[axis];
        let rate = tangent[tangent.len() - 2 + axis] * plane.span(axis);
        let end = if rate > 0.0 { high } else { low };
        // A number that does not change has no end.
        let ahead = (end - at[axis]) / rate;
        (rate != 0.0 && ahead <= step).then_some((axis, end, ahead))
    });
    let first = ahead.min_by(|a, b| a.2.total_cmp(&b.2));
    first.map(|(axis, end, _)| (axis, end))
}

/// A step, to the end of a range if one is reached, or if it leads out of one.
fn within(
    plane: &CurveProblem<'_>,
    from: &CorrectedCurvePoint,
    tangent: &DVector<f64>,
    (step, end): (f64, Option<(usize, f64)>),
) -> Attempt<CorrectedCurvePoint> {
    if let Some(end) = end {
        return stepped_to(plane, from, tangent, step, end);
    }
    let found = stepped(plane, from, tangent, step, &weighted(tangent))?;
    let Ok(there) = &found else {
        return Ok(found);
    };
    let values = [there.iterate.place.value, there.iterate.second];
    let is_out = |axis: &usize| {
        let (low, high) = plane.between[*axis];
        !(low..=high).contains(&values[*axis])
    };
    match (0..2).find(is_out) {
        Some(axis) => {
            let (low, high) = plane.between[axis];
            let end = values[axis].clamp(low, high);
            stepped_to(plane, from, tangent, step, (axis, end))
        }
        None => Ok(found),
    }
}

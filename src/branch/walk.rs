//! One half of a branch, step by step from its first point to its end (theory 19).

use crate::branch::advance::{StepOutcome, advance};
use crate::branch::bifurcations::bifurcations;
use crate::branch::collapse::{ended, meeting, named};
use crate::branch::corrector::{CorrectionFailure, directions, tangent};
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::half_branch::HalfBranch;
use crate::branch::options::ContinuationOptions;
use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::predictor::{AcceptedPoint, StepTarget};
use crate::branch::problem::BranchProblem;
use crate::branch::special::Special;
use crate::branch::test_functions::TestFunctionValues;
use crate::error::{Error, Result, digits};
use crate::tolerance::{CLOSED_BRANCH_DIRECTION, OUTGROWN_UNITS};
use std::ops::ControlFlow;

/// Follows a branch from a point, which is not among the points returned, along its tangent.
pub(super) fn walk(
    problem: &BranchProblem<'_>,
    begun: &AcceptedPoint,
    options: &ContinuationOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<HalfBranch<AcceptedPoint, Special>> {
    let mut points: Vec<AcceptedPoint> = Vec::new();
    let mut special = Vec::new();
    let [smallest, usual, largest] = options.steps;
    let mut step = usual;
    let mut farthest = 0.0f64;
    let broken_off = |at: &AcceptedPoint| {
        let detail = format!("broken off at {}", digits(at.place.value));
        BranchEnd::new(EndReason::Interrupted, detail)
    };
    let (problem, mut first) = (&mut problem.clone(), begun.clone());
    let end = loop {
        let from = points.last().unwrap_or(&first);
        if points.len() >= options.max_points {
            let detail = format!("{} points were asked for", options.max_points);
            break BranchEnd::new(EndReason::Points, detail);
        }
        if observer(from.place.value).is_break() {
            break broken_off(from);
        }
        let reached = reaches(problem, from, step);
        if let Some(end) = reached.filter(|&end| end == from.place.value) {
            break at_end(end);
        }
        let target = reached.map_or(StepTarget::Length(step), StepTarget::Value);
        let refused = match advance(problem, from, target, options.beyond) {
            Err(Error::Interrupted) => break broken_off(from),
            Err(error) => return Err(error),
            Ok(StepOutcome::End(last, found, end)) => {
                special.extend(found);
                points.extend(last.map(|last| *last));
                break end;
            }
            Ok(StepOutcome::Accepted(own, found, factor)) => {
                let turns = problem.turns(&first.place, &own.place);
                let begun = first.place.turned(turns);
                let home = problem.between(&begun, &own.place);
                let away = home.length();
                let has_closed = farthest > 2.0 * step
                    && away < step
                    && first.tangent.dot(&own.tangent) > CLOSED_BRANCH_DIRECTION;
                farthest = farthest.max(away);
                let is_past = has_closed && first.tangent.dot(&home) > 0.0;
                if !is_past {
                    special.extend(found);
                    points.push(rescaled(problem, *own)?);
                }
                if has_closed {
                    let from = points.last().unwrap_or(&first);
                    let (last, found) = closing(problem, from, (&first, begun))?;
                    special.extend(found);
                    points.push(last);
                    let detail = "it came back to where it began".to_owned();
                    break BranchEnd::new(EndReason::Closed, detail);
                }
                let found = points.last().map_or(Ok(None), |own| ended(problem, own))?;
                if let Some((end, met)) = found {
                    special.extend(met);
                    break end;
                }
                // A step that ended at a boundary before has not reached the end of the range.
                let now = points.last().map(|own| own.place.value);
                if let Some(end) = reached.filter(|&end| now == Some(end)) {
                    break at_end(end);
                }
                step = (step * factor).clamp(smallest, largest);
                continue;
            }
            // Where the mirror image of half the motion is not its other half any more, the branch goes on with the whole period.
            Ok(StepOutcome::Refused(CorrectionFailure::NotOdd { .. }))
                if options.symmetric.is_none() =>
            {
                if let Some(end) = go_on_whole(problem, &mut first, &mut points)? {
                    break end;
                }
                continue;
            }
            Ok(StepOutcome::Refused(failure)) => {
                (failure.end(), failed_instant(problem, from, &failure))
            }
            Ok(StepOutcome::Distrusted(end)) => (end, None),
        };
        if step <= smallest {
            let (end, instant) = refused;
            let met = meeting(problem, (from, &points), instant, step * problem.span())?;
            let end = match &met {
                Some(_) => BranchEnd::new(EndReason::Boundary, end.detail),
                None => end,
            };
            let end = named(end, met.as_ref());
            special.extend(met);
            break end;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(HalfBranch {
        points,
        special,
        end,
    })
}

/// The instant whose flight or stick has no duration left, if that is why the corrector failed.
fn failed_instant(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    failure: &CorrectionFailure,
) -> Option<usize> {
    match failure {
        CorrectionFailure::Met { instant, .. } => Some(*instant),
        CorrectionFailure::NoRest { .. } => problem.last_stick(&from.place),
        CorrectionFailure::Stalled { .. }
        | CorrectionFailure::NotOdd { .. }
        | CorrectionFailure::NoScene(_) => None,
    }
}

/// The first point again as the last one of a closed branch, and the special points between.
fn closing(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    (first, place): (&AcceptedPoint, ParametricLoop),
) -> Result<(AcceptedPoint, Vec<Special>)> {
    let chord = problem.between(&from.place, &place);
    let last = AcceptedPoint {
        arclength: from.arclength + chord.length(),
        place,
        ..first.clone()
    };
    let special = bifurcations(problem, from, &last, from.tangent.dot(&chord))?;
    Ok((last, special))
}

/// Replaces the loops of half a period by whole ones from the last point on; the end of the branch where these have no tangent.
fn go_on_whole(
    problem: &mut BranchProblem<'_>,
    first: &mut AcceptedPoint,
    points: &mut [AcceptedPoint],
) -> Result<Option<BranchEnd>> {
    let from = points.last().unwrap_or(first);
    let Some((whole, there)) = unfolded(problem, from)? else {
        let value = from.place.value;
        return Ok(Some(CorrectionFailure::NotOdd { value }.end()));
    };
    if let Some((_, begun)) = unfolded(problem, first)? {
        *first = begun;
    }
    *problem = whole;
    if let Some(last) = points.last_mut() {
        *last = there;
    }
    Ok(None)
}

/// A point of half a period as one of the whole, and its problem; none where that has no tangent.
fn unfolded<'a>(
    problem: &BranchProblem<'a>,
    own: &AcceptedPoint,
) -> Result<Option<(BranchProblem<'a>, AcceptedPoint)>> {
    let (whole, place) = problem.whole(&own.place)?;
    let equations = whole.equations(&place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    // The first state, the instants of the first half and the parameter are the unknowns of the half.
    let unknowns = tangent.loop_part.len();
    let mut half = own.tangent.clone();
    half.loop_part = half.loop_part.resize_vertically(unknowns, 0.0);
    let side = tangent.dot(&half).signum();
    let tangent = tangent.scaled(side);
    let test_values = TestFunctionValues::at(&whole, (&place, &equations, &tangent), &own.orbit)?;
    let point = AcceptedPoint {
        place,
        equations,
        tangent,
        test_values,
        ..own.clone()
    };
    Ok(Some((whole, point)))
}

/// A point in units that fit it: the problem takes those of the point where the motion has outgrown its units.
fn rescaled(problem: &mut BranchProblem<'_>, own: AcceptedPoint) -> Result<AcceptedPoint> {
    if problem.size(&own.place.state) <= OUTGROWN_UNITS {
        return Ok(own);
    }
    let there = problem.in_units_of(&own.place)?;
    let ratio = there.units.position / problem.units.position;
    let faster = there.units.velocity / problem.units.velocity;
    let before_times = own.place.n_before_times();
    let positions = if problem.has_pulses {
        0
    } else {
        before_times / 2
    };
    let mut border = own.tangent.clone();
    let numbers = border.loop_part.as_mut_slice();
    let (slow, fast) = numbers[..before_times].split_at_mut(positions);
    for (part, unit) in [(slow, ratio), (fast, faster)] {
        for x in part {
            *x /= unit;
        }
    }
    let equations = there.equations(&own.place)?;
    let Some(tangent) = tangent(&equations, &border) else {
        return Ok(own);
    };
    *problem = there;
    Ok(AcceptedPoint {
        equations,
        tangent,
        ..own
    })
}

/// The end of a branch at an end of its range.
fn at_end(value: f64) -> BranchEnd {
    let detail = format!("the range ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

/// The end of the range, if a step goes there or beyond.
fn reaches(problem: &BranchProblem<'_>, from: &AcceptedPoint, step: f64) -> Option<f64> {
    let (low, high) = problem.range;
    let ahead = from.place.value + step * from.tangent.value_part * problem.span();
    if ahead >= high {
        Some(high)
    } else if ahead <= low {
        Some(low)
    } else {
        None
    }
}

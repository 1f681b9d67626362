//! Along a curve, one way.

use crate::branch::corrector::Attempt;
use crate::branch::curve::corrector::{Found, length, weighted};
use crate::branch::curve::one::CurvePoint;
use crate::branch::curve::plane::{Plane, Spot};
use crate::branch::curve::step::{chord, stepped, stepped_to, turned_to};
use crate::branch::curve::two_at_once::{Point, indicators, passed};
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::options::ContinuationOptions;
use crate::branch::step_size::{SAME_WAY, step_factor};
use crate::branch::way::Way;
use crate::error::{Error, Result, digits};
use nalgebra::DVector;
use std::ops::ControlFlow;

/// Goes along a curve from a point, which is not among those that it gives.
pub(super) fn walk(
    plane: &Plane<'_>,
    first: &Point,
    sign: f64,
    options: &ContinuationOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Way<Point, CurvePoint>> {
    let mut way = Way {
        points: Vec::new(),
        special: Vec::new(),
        end: BranchEnd::new(EndReason::Points, String::new()),
    };
    let [smallest, usual, largest] = options.steps;
    let mut step = usual;
    let mut tangent = &first.found.tangent * sign;
    let mut farthest = 0.0f64;
    way.end = loop {
        let from = way.points.last().unwrap_or(first);
        let at = [from.found.spot.place.value, from.found.spot.second];
        if way.points.len() >= options.max_points {
            let detail = format!("{} points were asked for", options.max_points);
            break BranchEnd::new(EndReason::Points, detail);
        }
        if observer(at[0]).is_break() {
            let detail = format!("broken off at ({}, {})", digits(at[0]), digits(at[1]));
            break BranchEnd::new(EndReason::Interrupted, detail);
        }
        let end = reached(plane, &from.found.spot, &tangent, step);
        if let Some((axis, value)) = end.filter(|&(axis, value)| at[axis] == value) {
            break range_end(axis, value);
        }
        let refused = match within(plane, &from.found, &tangent, (step, end)) {
            Err(Error::Interrupted) => {
                let detail = format!("broken off at ({}, {})", digits(at[0]), digits(at[1]));
                break BranchEnd::new(EndReason::Interrupted, detail);
            }
            Err(error) => return Err(error),
            Ok(Ok(found)) => {
                match step_factor(found.contraction, found.tangent.dot(&weighted(&tangent))) {
                    Ok(factor) => {
                        let gone = chord(plane, &from.found.spot, &found.spot);
                        let arclength = from.arclength + length(&gone);
                        let indicators = indicators(plane, &found.spot)?;
                        let point = Point {
                            found,
                            arclength,
                            indicators,
                        };
                        let special = passed(plane, from, &point, &tangent)?;
                        way.special.extend(special);
                        let side = point.found.tangent.dot(&weighted(&tangent)).signum();
                        tangent = &point.found.tangent * side;
                        let begun = turned_to(plane, &first.found.spot, &point.found.spot);
                        let away = length(&chord(plane, &begun, &point.found.spot));
                        let is_same =
                            sign * tangent.dot(&weighted(&first.found.tangent)) > SAME_WAY;
                        let has_closed = farthest > 2.0 * step && away < step && is_same;
                        farthest = farthest.max(away);
                        way.points.push(point);
                        if has_closed {
                            let detail = "it came back to where it began".to_owned();
                            break BranchEnd::new(EndReason::Closed, detail);
                        }
                        step = (step * factor).clamp(smallest, largest);
                        continue;
                    }
                    Err(reason) => BranchEnd::new(EndReason::Step, reason.to_owned()),
                }
            }
            Ok(Err(missed)) => missed.end(),
        };
        if step <= smallest {
            break refused;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(way)
}

fn range_end(axis: usize, value: f64) -> BranchEnd {
    let name = ["first", "second"][axis];
    let detail = format!("the range of the {name} number ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

/// The number whose range ends within a step, and where.
fn reached(
    plane: &Plane<'_>,
    from: &Spot,
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
    plane: &Plane<'_>,
    from: &Found,
    tangent: &DVector<f64>,
    (step, end): (f64, Option<(usize, f64)>),
) -> Attempt<Found> {
    if let Some(end) = end {
        return stepped_to(plane, from, tangent, step, end);
    }
    let found = stepped(plane, from, tangent, step, &weighted(tangent))?;
    let Ok(there) = &found else {
        return Ok(found);
    };
    let values = [there.spot.place.value, there.spot.second];
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

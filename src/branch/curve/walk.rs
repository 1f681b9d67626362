//! Along a curve, one way.

use crate::branch::corrector::Attempt;
use crate::branch::curve::condition::Condition;
use crate::branch::curve::corrector::{Found, length, weighted};
use crate::branch::curve::one::CurvePoint;
use crate::branch::curve::plane::{Plane, Spot};
use crate::branch::curve::point::Point;
use crate::branch::curve::step::{chord, stepped, stepped_to, turned_to};
use crate::branch::curve::two_at_once::passed;
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
    let mut farthest = 0.0f64;
    way.end = loop {
        let from = way.points.last().unwrap_or(first);
        let at = [from.found.spot.place.value, from.found.spot.second];
        if way.points.len() >= options.max_points {
            let detail = format!("{} points were asked for", options.max_points);
            break BranchEnd::new(EndReason::Points, detail);
        }
        if observer(at[0]).is_break() {
            break broken_off(at);
        }
        let end = reached(plane, &from.found.spot, &from.found.tangent, step);
        if let Some((axis, value)) = end.filter(|&(axis, value)| at[axis] == value) {
            break range_end(axis, value);
        }
        let refused = match advance(plane, from, (step, end)) {
            Err(Error::Interrupted) => break broken_off(at),
            Err(error) => return Err(error),
            Ok(Advance::Point(point, factor)) => {
                let mut special = passed(plane, from, &point)?;
                let last = special.iter().position(|own| is_last(plane, &own.0));
                let last = last.map(|k| {
                    special.truncate(k + 1);
                    special[k].clone()
                });
                way.special.extend(special.into_iter().map(|own| own.0));
                if let Some((last, found)) = last {
                    way.points.push(Point::at(plane, found, last.arclength)?);
                    let detail = format!("{}: beyond it the two multipliers are real", last.kind);
                    break BranchEnd::new(EndReason::Boundary, detail);
                }
                if plane.condition == Condition::OnCircle && is_real(&point) {
                    let detail = "beyond it the two multipliers are real".to_owned();
                    break BranchEnd::new(EndReason::Boundary, detail);
                }
                let spot = &point.found.spot;
                let begun = turned_to(plane, &first.found.spot, spot);
                let home = chord(plane, &begun, spot);
                let away = length(&home);
                let along = point.found.tangent.dot(&weighted(&first.found.tangent));
                let has_closed = farthest > 2.0 * step && away < step && along > SAME_WAY;
                farthest = farthest.max(away);
                if has_closed {
                    let is_past = home.dot(&weighted(&first.found.tangent)) > 0.0;
                    let before = if is_past { from.clone() } else { *point };
                    if !is_past {
                        way.points.push(before.clone());
                    }
                    way.points.push(closing(plane, &before, (first, begun)));
                    let detail = "it came back to where it began".to_owned();
                    break BranchEnd::new(EndReason::Closed, detail);
                }
                way.points.push(*point);
                step = (step * factor).clamp(smallest, largest);
                continue;
            }
            Ok(Advance::Refused(end)) => end,
        };
        if step <= smallest {
            break refused;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(way)
}

/// What a step has come to: a point and the factor on the next step, or why there is none.
enum Advance {
    Point(Box<Point>, f64),
    Refused(BranchEnd),
}

/// A step from a point, as far as it can be trusted.
fn advance(plane: &Plane<'_>, from: &Point, ahead: (f64, Option<(usize, f64)>)) -> Result<Advance> {
    let tangent = &from.found.tangent;
    let mut found = match within(plane, &from.found, tangent, ahead)? {
        Ok(found) => found,
        Err(missed) => return Ok(Advance::Refused(missed.end())),
    };
    let side = found.tangent.dot(&weighted(tangent));
    found.tangent *= side.signum();
    Ok(match step_factor(found.contraction, side) {
        Ok(factor) => {
            let gone = length(&chord(plane, &from.found.spot, &found.spot));
            let point = Point::at(plane, found, from.arclength + gone)?;
            let least = [plane.units.position, plane.units.velocity];
            match point.orbit.missed(least)? {
                None => Advance::Point(Box::new(point), factor),
                Some(by) => {
                    let detail = format!(
                        "the motion, followed once more by another route, misses its beginning by {}",
                        digits(by)
                    );
                    Advance::Refused(BranchEnd::new(EndReason::Step, detail))
                }
            }
        }
        Err(reason) => Advance::Refused(BranchEnd::new(EndReason::Step, reason.to_owned())),
    })
}

/// Whether a curve ends at a point: two multipliers on the circle meet where it crosses the real axis.
fn is_last(plane: &Plane<'_>, own: &CurvePoint) -> bool {
    plane.condition == Condition::OnCircle && matches!(own.kind, "strong_1_1" | "strong_1_2")
}

/// Whether the two multipliers of a point whose product is 1 are real.
fn is_real(point: &Point) -> bool {
    point.indicators.iter().any(|(kind, value)| match *kind {
        "strong_1_1" => *value > 0.0,
        "strong_1_2" => *value < 0.0,
        _ => false,
    })
}

/// The first point again, behind the last one.
fn closing(plane: &Plane<'_>, from: &Point, (first, spot): (&Point, Spot)) -> Point {
    let gone = length(&chord(plane, &from.found.spot, &spot));
    Point {
        arclength: from.arclength + gone,
        found: Found {
            spot,
            ..first.found.clone()
        },
        ..first.clone()
    }
}

fn broken_off([x, y]: [f64; 2]) -> BranchEnd {
    let detail = format!("broken off at ({}, {})", digits(x), digits(y));
    BranchEnd::new(EndReason::Interrupted, detail)
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

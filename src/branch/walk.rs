//! Along a branch, one way: a step ahead, back to the branch, a longer or a shorter one (theory 19).

use crate::branch::advance::{Advance, advance};
use crate::branch::bifurcations::bifurcations;
use crate::branch::corrector::{Missed, directions, tangent};
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::family::Family;
use crate::branch::indicators::Indicators;
use crate::branch::options::ContinuationOptions;
use crate::branch::place::Place;
use crate::branch::special::Special;
use crate::branch::step::{Point, Target};
use crate::branch::step_size::SAME_WAY;
use crate::branch::vanished::{ended, meeting, named};
use crate::branch::way::Way;
use crate::error::{Error, Result, digits};
use std::ops::ControlFlow;

/// A motion that has grown beyond so many units gets units of its own. One that shrinks does not: steps to nothing would have no end.
const OUTGROWN: f64 = 4.0;

/// Goes along a branch from a point, which is not among those that it gives.
pub(super) fn walk(
    family: &Family<'_>,
    begun: &Point,
    options: &ContinuationOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Way<Point, Special>> {
    let mut points: Vec<Point> = Vec::new();
    let mut special = Vec::new();
    let [smallest, usual, largest] = options.steps;
    let mut step = usual;
    let mut farthest = 0.0f64;
    let broken_off = |at: &Point| {
        let detail = format!("broken off at {}", digits(at.place.value));
        BranchEnd::new(EndReason::Interrupted, detail)
    };
    let (family, mut first) = (&mut family.clone(), begun.clone());
    let end = loop {
        let from = points.last().unwrap_or(&first);
        if points.len() >= options.max_points {
            let detail = format!("{} points were asked for", options.max_points);
            break BranchEnd::new(EndReason::Points, detail);
        }
        if observer(from.place.value).is_break() {
            break broken_off(from);
        }
        let reached = reaches(family, from, step);
        if let Some(end) = reached.filter(|&end| end == from.place.value) {
            break at_end(end);
        }
        let target = reached.map_or(Target::Length(step), Target::Value);
        let refused = match advance(family, from, target, options.beyond) {
            Err(Error::Interrupted) => break broken_off(from),
            Err(error) => return Err(error),
            Ok(Advance::End(last, found, end)) => {
                special.extend(found);
                points.extend(last.map(|last| *last));
                break end;
            }
            Ok(Advance::Point(own, found, factor)) => {
                let turns = family.turns(&first.place, &own.place);
                let begun = first.place.turned(turns);
                let home = family.between(&begun, &own.place);
                let away = home.length();
                let has_closed = farthest > 2.0 * step
                    && away < step
                    && first.tangent.dot(&own.tangent) > SAME_WAY;
                farthest = farthest.max(away);
                let is_past = has_closed && first.tangent.dot(&home) > 0.0;
                if !is_past {
                    special.extend(found);
                    points.push(rescaled(family, *own)?);
                }
                if has_closed {
                    let from = points.last().unwrap_or(&first);
                    let (last, found) = closing(family, from, (&first, begun))?;
                    special.extend(found);
                    points.push(last);
                    let detail = "it came back to where it began".to_owned();
                    break BranchEnd::new(EndReason::Closed, detail);
                }
                let found = points.last().map_or(Ok(None), |own| ended(family, own))?;
                if let Some((end, met)) = found {
                    special.extend(met);
                    break end;
                }
                // A step back from a boundary is no step to the end.
                let now = points.last().map(|own| own.place.value);
                if let Some(end) = reached.filter(|&end| now == Some(end)) {
                    break at_end(end);
                }
                step = (step * factor).clamp(smallest, largest);
                continue;
            }
            // Where half a motion is not all of it any more the whole one goes on.
            Ok(Advance::Refused(Missed::NotOdd { .. })) if options.symmetric.is_none() => {
                if let Some(end) = go_on_whole(family, &mut first, &mut points)? {
                    break end;
                }
                continue;
            }
            Ok(Advance::Refused(missed)) => {
                let instant = match &missed {
                    Missed::Met { instant, .. } => Some(*instant),
                    Missed::NoRest { .. } => family.last_stick(&from.place),
                    Missed::Stalled { .. } | Missed::NotOdd { .. } | Missed::NoScene(_) => None,
                };
                (missed.end(), instant)
            }
            Ok(Advance::Distrusted(end)) => (end, None),
        };
        if step <= smallest {
            let (end, instant) = refused;
            let met = meeting(family, (from, &points), instant, step * family.span())?;
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
    Ok(Way {
        points,
        special,
        end,
    })
}

/// The first point again, behind the last one, and what lies between.
fn closing(
    family: &Family<'_>,
    from: &Point,
    (first, place): (&Point, Place),
) -> Result<(Point, Vec<Special>)> {
    let way = family.between(&from.place, &place);
    let last = Point {
        arclength: from.arclength + way.length(),
        place,
        ..first.clone()
    };
    let special = bifurcations(family, from, &last, from.tangent.dot(&way))?;
    Ok((last, special))
}

/// Goes on with whole motions from the last point of half ones; its end where they have no direction there.
fn go_on_whole(
    family: &mut Family<'_>,
    first: &mut Point,
    points: &mut [Point],
) -> Result<Option<BranchEnd>> {
    let from = points.last().unwrap_or(first);
    let Some((whole, there)) = unfolded(family, from)? else {
        let value = from.place.value;
        return Ok(Some(Missed::NotOdd { value }.end()));
    };
    if let Some((_, begun)) = unfolded(family, first)? {
        *first = begun;
    }
    *family = whole;
    if let Some(last) = points.last_mut() {
        *last = there;
    }
    Ok(None)
}

/// The whole motion of a point that is known by half of it, and its family; none where it has no direction.
fn unfolded<'a>(family: &Family<'a>, own: &Point) -> Result<Option<(Family<'a>, Point)>> {
    let (whole, place) = family.whole(&own.place)?;
    let equations = whole.equations(&place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    // The first state, the instants of the first half and the number are those of the half.
    let unknowns = tangent.loop_part.len();
    let mut half = own.tangent.clone();
    half.loop_part = half.loop_part.resize_vertically(unknowns, 0.0);
    let side = tangent.dot(&half).signum();
    let tangent = tangent.scaled(side);
    let indicators = Indicators::at(&whole, (&place, &equations, &tangent), &own.orbit)?;
    let point = Point {
        place,
        equations,
        tangent,
        indicators,
        ..own.clone()
    };
    Ok(Some((whole, point)))
}

/// A point in units that fit it: those of the family become its own where it has outgrown them.
fn rescaled(family: &mut Family<'_>, own: Point) -> Result<Point> {
    if family.size(&own.place.state) <= OUTGROWN {
        return Ok(own);
    }
    let there = family.in_units_of(&own.place)?;
    let ratio = there.units.position / family.units.position;
    let faster = there.units.velocity / family.units.velocity;
    let before_times = own.place.n_before_times();
    let positions = if family.has_pulses {
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
    *family = there;
    Ok(Point {
        equations,
        tangent,
        ..own
    })
}

fn at_end(value: f64) -> BranchEnd {
    let detail = format!("the range ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

/// The end of the range, if a step goes there or beyond.
fn reaches(family: &Family<'_>, from: &Point, step: f64) -> Option<f64> {
    let (low, high) = family.range;
    let ahead = from.place.value + step * from.tangent.value_part * family.span();
    if ahead >= high {
        Some(high)
    } else if ahead <= low {
        Some(low)
    } else {
        None
    }
}

//! Along a branch, one way: a step ahead, back to the branch, a longer or a shorter one (theory 19).

use crate::branch::bifurcations::{are_explained, bifurcations};
use crate::branch::boundary::{Boundary, is_broken, located};
use crate::branch::corrector::{Missed, Settled, attempted, tangent};
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::family::Family;
use crate::branch::indicators::Indicators;
use crate::branch::options::{ContinuationOptions, Virtual};
use crate::branch::place::{Direction, Place};
use crate::branch::special::{Special, SpecialKind};
use crate::branch::step::{Point, Target, step_to};
use crate::branch::step_size::{SAME_WAY, step_factor};
use crate::branch::tip::{Tip, tip};
use crate::branch::vanished::{ended, meeting, named};
use crate::branch::way::Way;
use crate::error::{Error, Result, digits};
use crate::orbit::PeriodicOrbit;
use std::ops::ControlFlow;

/// A step is refused if an instant goes farther in the phase of the forcing.
const MOST_SHIFT: f64 = 0.5;
/// A motion that has grown beyond so many units gets units of its own. One that shrinks does not: steps to nothing would have no end.
const OUTGROWN: f64 = 4.0;
/// A step no longer than this is not divided because multipliers left the unit circle that no bifurcation tells of.
const UNEXPLAINED: f64 = 1e-5;
/// A crossing that is known no better than this part of the range may be none.
const LOOSE: f64 = 1e-9;
/// A border at which a flight comes to nothing is no farther than this part of the range from where rules are broken by rounding.
const BY_ROUNDING: f64 = 1e-5;

/// What a step has come to.
enum Advance {
    /// A point, the special ones before it, and the factor on the next step.
    Point(Box<Point>, Vec<Special>, f64),
    /// A boundary, with the last point before it where one was found, and the special ones.
    Boundary(Option<Box<Point>>, Vec<Special>, BranchEnd),
    /// The tip of a doubled branch.
    Tip(Box<Point>, Vec<Special>, BranchEnd),
    /// Nothing: a shorter step may come farther, and this is the end where there is none.
    Refused(Missed),
    Distrusted(BranchEnd),
}

/// Goes along a branch from a point, which is not among those that it gives.
pub(super) fn walk(
    family: &Family<'_>,
    first: &Point,
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
    let family = &mut family.clone();
    let end = loop {
        let from = points.last().unwrap_or(first);
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
            Ok(Advance::Boundary(last, found, end)) => {
                special.extend(found);
                points.extend(last.map(|last| *last));
                break end;
            }
            Ok(Advance::Tip(last, found, end)) => {
                special.extend(found);
                points.push(*last);
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
                    let from = points.last().unwrap_or(first);
                    let (last, found) = closing(family, from, (first, begun))?;
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
            Ok(Advance::Refused(missed)) => {
                let instant = match &missed {
                    Missed::Met { instant, .. } => Some(*instant),
                    Missed::NoRest { .. } => family.last_stick(&from.place),
                    Missed::Stalled { .. } | Missed::NoScene(_) => None,
                };
                (missed.end(), instant)
            }
            Ok(Advance::Distrusted(end)) => (end, None),
        };
        if step <= smallest {
            let (end, instant) = refused;
            let error = step * family.span();
            let met = meeting(family, (from, &points), instant, error)?;
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

/// A step from a point, as far as it can be trusted.
fn advance(family: &Family<'_>, from: &Point, target: Target, beyond: Virtual) -> Result<Advance> {
    let mut there = step_to(family, from.foot(), target)?;
    // A step that leads out of the range ends where the range does.
    let (low, high) = family.range;
    let value = there
        .as_ref()
        .map_or(from.place.value, |settled| settled.place.value);
    if !(low..=high).contains(&value) {
        there = step_to(family, from.foot(), Target::Value(value.clamp(low, high)))?;
    }
    let settled = match there {
        Ok(settled) => settled,
        Err(missed) => return Ok(Advance::Refused(missed)),
    };
    let way = family.between(&from.place, &settled.place);
    let factor = match judged(from, &settled, (&way, settled.place.n_before_times())) {
        Ok(factor) => factor,
        Err(reason) => {
            let detail = format!("{reason} at {}", digits(settled.place.value));
            return Ok(Advance::Distrusted(BranchEnd::new(EndReason::Step, detail)));
        }
    };
    let orbit = match attempted(family.orbit(&settled.place), settled.place.value)? {
        Ok(orbit) => orbit,
        Err(missed) => return Ok(Advance::Refused(missed)),
    };
    if let Some(tip) = at_tip(family, from, &settled.place, beyond)? {
        return Ok(tip);
    }
    if beyond == Virtual::Stop && is_broken(&orbit) {
        let mut found = located(family, from, way.length(), (&settled.place, orbit))?;
        let end = at_boundary(&found);
        // Where a flight comes to nothing rules are broken by rounding a little before.
        if let Some(met) = meeting(family, (from, &[]), None, 0.0)? {
            let last = found.last.as_ref();
            let broken = last.map_or(from.place.value, |(settled, _)| settled.place.value);
            if (met.parameter - broken).abs() <= BY_ROUNDING * family.span() {
                let end = named(end, Some(&met));
                return Ok(Advance::Boundary(None, vec![met], end));
            }
        }
        let Some((settled, orbit)) = found.last.take() else {
            if found.left.is_some() {
                return Ok(Advance::Distrusted(end));
            }
            let special = found.special(&found.other, from, family.units.velocity);
            let end = named(end, special.as_ref());
            return Ok(Advance::Boundary(None, special.into_iter().collect(), end));
        };
        let step = way.length();
        let way = family.between(&from.place, &settled.place);
        // What breaks a rule by less than is seen may lie behind the boundary already.
        let ahead = from.tangent.dot(&way);
        let own = accepted(family, from, (settled, orbit), way.length().copysign(ahead))?;
        let mut special = if ahead > 0.0 {
            bifurcations(family, from, &own, ahead)?
        } else {
            Vec::new()
        };
        if let Some(left) = found.left {
            return Ok(Advance::Point(Box::new(own), special, 0.5 * left / step));
        }
        let boundary = found.special(&found.other, &own, family.units.velocity);
        let end = named(end, boundary.as_ref());
        special.extend(boundary);
        return Ok(Advance::Boundary(Some(Box::new(own)), special, end));
    }
    let own = accepted(family, from, (settled, orbit), way.length())?;
    let mut special = bifurcations(family, from, &own, from.tangent.dot(&way))?;
    let is_counted = are_explained(&special, from.indicators.outside, own.indicators.outside);
    if !is_counted && way.length() > UNEXPLAINED {
        let detail = format!(
            "several multipliers leave the circle at {}",
            digits(own.place.value)
        );
        return Ok(Advance::Distrusted(BranchEnd::new(EndReason::Step, detail)));
    }
    // Branches that come close to each other without crossing look like that from afar, and a long step may lead from one to the other.
    let is_loose = |special: &Special| {
        special.kind == SpecialKind::BranchPoint && special.error > LOOSE * family.span()
    };
    if special.iter().any(is_loose) && way.length() > UNEXPLAINED {
        let detail = format!("another branch is close at {}", digits(own.place.value));
        return Ok(Advance::Distrusted(BranchEnd::new(EndReason::Step, detail)));
    }
    if is_broken(&from.orbit) != is_broken(&own.orbit) {
        special.extend(crossed(family, from, &own)?);
        special.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    }
    Ok(Advance::Point(Box::new(own), special, factor))
}

/// The end of a step that leads beyond the tip of a doubled branch.
fn at_tip(
    family: &Family<'_>,
    from: &Point,
    to: &Place,
    beyond: Virtual,
) -> Result<Option<Advance>> {
    let is_kept = |own: &Tip| beyond == Virtual::Keep || !is_broken(&own.last.orbit);
    let Some(Tip { doubling, last }) = tip(family, from, to)?.filter(is_kept) else {
        return Ok(None);
    };
    let length = last.arclength - from.arclength;
    let ahead = (doubling.parameter - from.place.value) * from.tangent.value_part;
    let value = digits(doubling.parameter);
    if ahead < 0.0 && length > UNEXPLAINED {
        let detail = format!("a fold next to the tip at {value}");
        let end = BranchEnd::new(EndReason::Step, detail);
        return Ok(Some(Advance::Distrusted(end)));
    }
    let mut special = bifurcations(family, from, &last, length)?;
    special.push(doubling);
    let detail = format!("at {value} both rounds are one, from which the branch is doubled");
    let end = BranchEnd::new(EndReason::Doubling, detail);
    Ok(Some(Advance::Tip(Box::new(last), special, end)))
}

/// The boundary that a branch goes across on a step, where virtual orbits are kept.
fn crossed(family: &Family<'_>, from: &Point, to: &Point) -> Result<Option<Special>> {
    let length = to.arclength - from.arclength;
    let mut found = located(family, from, length, (&to.place, to.orbit.clone()))?;
    let at = match found.last.take() {
        Some((settled, orbit)) => {
            let way = family.between(&from.place, &settled.place);
            accepted(family, from, (settled, orbit), way.length())?
        }
        None => from.clone(),
    };
    let broken = if is_broken(&at.orbit) {
        &at.orbit
    } else {
        &found.other
    };
    Ok(found.special(broken, &at, family.units.velocity))
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

fn accepted(
    family: &Family<'_>,
    from: &Point,
    (settled, orbit): (Settled, PeriodicOrbit),
    length: f64,
) -> Result<Point> {
    let Settled {
        place,
        equations,
        tangent,
        ..
    } = settled;
    // A point at a given value has its direction by the parameter.
    let way = tangent.dot(&from.tangent).signum();
    let tangent = tangent.scaled(way);
    Ok(Point {
        indicators: Indicators::at(family, (&place, &equations, &tangent), &orbit)?,
        place,
        equations,
        tangent,
        orbit,
        arclength: from.arclength + length,
    })
}

/// The factor on the next step; why a point is not to be trusted.
fn judged(
    from: &Point,
    settled: &Settled,
    (chord, before_times): (&Direction, usize),
) -> std::result::Result<f64, &'static str> {
    let factor = step_factor(settled.contraction, settled.tangent.dot(&from.tangent))?;
    let times = &chord.loop_part.as_slice()[before_times..];
    if times.iter().any(|shift| shift.abs() > MOST_SHIFT) {
        return Err("an instant goes far");
    }
    Ok(factor)
}

fn at_boundary(found: &Boundary) -> BranchEnd {
    let (orbit, last) = (&found.other, found.last.as_ref());
    let reason = orbit.violation().map_or("", |v| v.reason.as_str());
    let place = last.map_or("here".to_owned(), |(settled, _)| {
        digits(settled.place.value)
    });
    BranchEnd::new(EndReason::Boundary, format!("beyond {place} {reason}"))
}

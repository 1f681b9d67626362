//! A step along a branch, as far as it can be trusted: what it comes to, and what lies on it (theory 19).

use crate::branch::bifurcations::bifurcations;
use crate::branch::boundary::{Boundary, is_broken, located};
use crate::branch::corrector::{Missed, Settled, attempted};
use crate::branch::crossings::are_explained;
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::family::Family;
use crate::branch::indicators::Indicators;
use crate::branch::options::Virtual;
use crate::branch::place::{Direction, Place};
use crate::branch::special::{Special, SpecialKind};
use crate::branch::step::{Point, Target, step_to};
use crate::branch::step_size::step_factor;
use crate::branch::tip::{Tip, tip};
use crate::branch::vanished::{meeting, named};
use crate::error::{Result, digits};
use crate::orbit::PeriodicOrbit;

/// A step is refused if an instant goes farther in the phase of the forcing.
const MOST_SHIFT: f64 = 0.5;
/// A step no longer than this is not divided because multipliers left the unit circle that no bifurcation tells of.
const UNEXPLAINED: f64 = 1e-5;
/// A crossing that is known no better than this part of the range may be none.
const LOOSE: f64 = 1e-9;
/// A border at which a flight comes to nothing is no farther than this part of the range from where rules are broken by rounding.
const BY_ROUNDING: f64 = 1e-5;

/// What a step has come to.
pub(super) enum Advance {
    /// A point, the special ones before it, and the factor on the next step.
    Point(Box<Point>, Vec<Special>, f64),
    /// An end, a boundary or the tip of a doubled branch, with the last point where one was found, and the special ones.
    End(Option<Box<Point>>, Vec<Special>, BranchEnd),
    /// Nothing: a shorter step may come farther, and this is the end where there is none.
    Refused(Missed),
    Distrusted(BranchEnd),
}

/// A step from a point, as far as it can be trusted.
pub(super) fn advance(
    family: &Family<'_>,
    from: &Point,
    target: Target,
    beyond: Virtual,
) -> Result<Advance> {
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
    let orbit = match attempted(family.closed_orbit(&settled.place), settled.place.value)? {
        Ok(orbit) => orbit,
        Err(_) if family.signature.images.is_some() => {
            let value = settled.place.value;
            return Ok(Advance::Refused(Missed::NotOdd { value }));
        }
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
                return Ok(Advance::End(None, vec![met], end));
            }
        }
        let Some((settled, orbit)) = found.last.take() else {
            if found.left.is_some() {
                return Ok(Advance::Distrusted(end));
            }
            let special = found.special(&found.other, from, family.units.velocity);
            let end = named(end, special.as_ref());
            return Ok(Advance::End(None, special.into_iter().collect(), end));
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
        if let Some(end) = unexplained(family, (from, &own), &special)? {
            return Ok(Advance::Distrusted(end));
        }
        if let Some(left) = found.left {
            return Ok(Advance::Point(Box::new(own), special, 0.5 * left / step));
        }
        let boundary = found.special(&found.other, &own, family.units.velocity);
        let end = named(end, boundary.as_ref());
        special.extend(boundary);
        return Ok(Advance::End(Some(Box::new(own)), special, end));
    }
    let own = accepted(family, from, (settled, orbit), way.length())?;
    let mut special = bifurcations(family, from, &own, from.tangent.dot(&way))?;
    if let Some(end) = unexplained(family, (from, &own), &special)? {
        return Ok(Advance::Distrusted(end));
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

/// Why a step is not trusted on which multipliers cross the unit circle otherwise than its special points say, unless it is too short to be
/// divided.
fn unexplained(
    family: &Family<'_>,
    (from, to): (&Point, &Point),
    special: &[Special],
) -> Result<Option<BranchEnd>> {
    let is_short = to.arclength - from.arclength <= UNEXPLAINED;
    if is_short || are_explained(family, (from, to), special)? {
        return Ok(None);
    }
    let detail = format!(
        "several multipliers cross the circle at {}",
        digits(to.place.value)
    );
    Ok(Some(BranchEnd::new(EndReason::Step, detail)))
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
    Ok(Some(Advance::End(Some(Box::new(last)), special, end)))
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

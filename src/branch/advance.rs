//! A step along a branch with its verdict: whether it can be trusted, whether a boundary ends it, and which special points lie on it
//! (theory 19).

use crate::branch::bifurcations::bifurcations;
use crate::branch::boundary::{Boundary, is_broken, located};
use crate::branch::collapse::{meeting, named};
use crate::branch::crossings::are_explained;
use crate::branch::doubling_end::{DoublingEnd, doubling_end};
use crate::branch::options::Virtual;
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{AcceptedPoint, StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{
    BranchEnd, EndReason, ScaledDirection, StepFailure, StepOutcome, attempted, step_factor,
};
use crate::error::{Result, digits};
use crate::orbit::PeriodicOrbit;
use crate::tolerance::{
    BORDER_BY_ROUNDING, LOOSE_BRANCH_POINT, STEP_PHASE_SHIFT, UNDIVIDED_STEP_LENGTH,
};

/// The outcome of a step along a branch.
pub(super) type BranchOutcome = StepOutcome<AcceptedPoint, Special>;

/// Makes a step from a point and judges it.
pub(super) fn advance(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    target: StepTarget,
    beyond: Virtual,
) -> Result<BranchOutcome> {
    let mut there = step_to(problem, from.base(), target)?;
    // A step that leads out of the range ends where the range does.
    let (low, high) = problem.range;
    let value = there
        .as_ref()
        .map_or(from.place.value, |settled| settled.iterate.value);
    if !(low..=high).contains(&value) {
        there = step_to(
            problem,
            from.base(),
            StepTarget::Value(value.clamp(low, high)),
        )?;
    }
    let settled = match there {
        Ok(settled) => settled,
        Err(failure) => return Ok(StepOutcome::Refused(failure)),
    };
    let chord = problem.between(&from.place, &settled.iterate);
    let factor = match judged(from, &settled, &chord) {
        Ok(factor) => factor,
        Err(reason) => {
            let detail = format!("{reason} at {}", digits(settled.iterate.value));
            return Ok(StepOutcome::Refused(StepFailure::distrusted(detail)));
        }
    };
    let orbit = match attempted(
        problem.closed_orbit(&settled.iterate),
        settled.iterate.value,
    )? {
        Ok(orbit) => orbit,
        Err(_) if problem.signature.images.is_some() => {
            let value = settled.iterate.value;
            return Ok(StepOutcome::Refused(StepFailure::NotOdd { value }));
        }
        Err(failure) => return Ok(StepOutcome::Refused(failure)),
    };
    if let Some(doubling_end) = at_doubling_end(problem, from, &settled.iterate, beyond)? {
        return Ok(doubling_end);
    }
    if beyond == Virtual::Stop && is_broken(&orbit) {
        return to_boundary(problem, from, &chord, (&settled.iterate, orbit));
    }
    let own = accepted(problem, from, (settled, orbit), chord.length())?;
    let mut special = bifurcations(problem, from, &own, from.tangent.dot(&chord))?;
    if let Some(failure) = unexplained(problem, (from, &own), &special)? {
        return Ok(StepOutcome::Refused(failure));
    }
    // Two branches that come close without crossing look like this from afar, and a long step may lead from one to the other.
    let is_loose = |special: &Special| {
        special.kind == SpecialKind::BranchPoint
            && special.error > LOOSE_BRANCH_POINT * problem.span()
    };
    if special.iter().any(is_loose) && chord.length() > UNDIVIDED_STEP_LENGTH {
        let detail = format!("another branch is close at {}", digits(own.place.value));
        return Ok(StepOutcome::Refused(StepFailure::distrusted(detail)));
    }
    if is_broken(&from.orbit) != is_broken(&own.orbit) {
        special.extend(crossed(problem, from, &own)?);
        special.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    }
    Ok(StepOutcome::Accepted(Box::new(own), special, factor))
}

/// The outcome of a step along a chord to a loop whose orbit breaks a rule of contact: the boundary before it.
fn to_boundary(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    chord: &BranchDirection,
    there: (&ParametricLoop, PeriodicOrbit),
) -> Result<BranchOutcome> {
    let mut found = located(problem, from, chord.length(), there)?;
    let end = at_boundary(&found);
    // Where the duration of a flight goes to zero, rules are broken by rounding a little before.
    if let Some(met) = meeting(problem, (from, &[]), None, 0.0)? {
        let last = found.last.as_ref();
        let broken = last.map_or(from.place.value, |(settled, _)| settled.iterate.value);
        if (met.parameter - broken).abs() <= BORDER_BY_ROUNDING * problem.span() {
            let end = named(end, Some(&met));
            return Ok(StepOutcome::End(None, vec![met], end));
        }
    }
    let Some((settled, orbit)) = found.last.take() else {
        if found.left.is_some() {
            return Ok(StepOutcome::Refused(StepFailure::Distrusted(end)));
        }
        let special = found.special(&found.other, from, problem.units.velocity);
        let end = named(end, special.as_ref());
        return Ok(StepOutcome::End(None, special.into_iter().collect(), end));
    };
    let step = chord.length();
    let chord = problem.between(&from.place, &settled.iterate);
    // A rule that is broken by less than rounding goes unnoticed: the point may lie beyond the boundary already.
    let ahead = from.tangent.dot(&chord);
    let own = accepted(
        problem,
        from,
        (settled, orbit),
        chord.length().copysign(ahead),
    )?;
    let mut special = if ahead > 0.0 {
        bifurcations(problem, from, &own, ahead)?
    } else {
        Vec::new()
    };
    if let Some(failure) = unexplained(problem, (from, &own), &special)? {
        return Ok(StepOutcome::Refused(failure));
    }
    if let Some(left) = found.left {
        return Ok(StepOutcome::Accepted(
            Box::new(own),
            special,
            0.5 * left / step,
        ));
    }
    let boundary = found.special(&found.other, &own, problem.units.velocity);
    let end = named(end, boundary.as_ref());
    special.extend(boundary);
    Ok(StepOutcome::End(Some(Box::new(own)), special, end))
}

/// Why a step is not trusted if multipliers cross the unit circle otherwise than its special points say; none if it is too short to be
/// divided.
fn unexplained(
    problem: &BranchProblem<'_>,
    (from, to): (&AcceptedPoint, &AcceptedPoint),
    special: &[Special],
) -> Result<Option<StepFailure>> {
    let is_short = to.arclength - from.arclength <= UNDIVIDED_STEP_LENGTH;
    if is_short || are_explained(problem, (from, to), special)? {
        return Ok(None);
    }
    let detail = format!(
        "several multipliers cross the circle at {}",
        digits(to.place.value)
    );
    Ok(Some(StepFailure::distrusted(detail)))
}

/// The end of a doubled branch at its doubling, if a step leads past it.
fn at_doubling_end(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    to: &ParametricLoop,
    beyond: Virtual,
) -> Result<Option<BranchOutcome>> {
    let is_kept = |own: &DoublingEnd| beyond == Virtual::Keep || !is_broken(&own.last.orbit);
    let Some(DoublingEnd { doubling, last }) = doubling_end(problem, from, to)?.filter(is_kept)
    else {
        return Ok(None);
    };
    let length = last.arclength - from.arclength;
    let ahead = (doubling.parameter - from.place.value) * from.tangent.value_part;
    let value = digits(doubling.parameter);
    if ahead < 0.0 && length > UNDIVIDED_STEP_LENGTH {
        let detail = format!("a fold next to the tip at {value}");
        return Ok(Some(StepOutcome::Refused(StepFailure::distrusted(detail))));
    }
    let mut special = bifurcations(problem, from, &last, length)?;
    special.push(doubling);
    let detail = format!("at {value} both rounds are one, from which the branch is doubled");
    let end = BranchEnd::new(EndReason::Doubling, detail);
    Ok(Some(StepOutcome::End(Some(Box::new(last)), special, end)))
}

/// The boundary that lies on a step, where the branch goes on with virtual orbits.
fn crossed(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    to: &AcceptedPoint,
) -> Result<Option<Special>> {
    let length = to.arclength - from.arclength;
    let mut found = located(problem, from, length, (&to.place, to.orbit.clone()))?;
    let at = match found.last.take() {
        Some((settled, orbit)) => {
            let chord = problem.between(&from.place, &settled.iterate);
            accepted(problem, from, (settled, orbit), chord.length())?
        }
        None => from.clone(),
    };
    let broken = if is_broken(&at.orbit) {
        &at.orbit
    } else {
        &found.other
    };
    Ok(found.special(broken, &at, problem.units.velocity))
}

/// A corrected point as one of the branch, with its tangent on the side of the one before.
fn accepted(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    (settled, orbit): (CorrectedPoint, PeriodicOrbit),
    length: f64,
) -> Result<AcceptedPoint> {
    // The tangent at a given value has the sign of the parameter, not that of the branch.
    let side = settled.tangent.dot(&from.tangent);
    AcceptedPoint::settled(problem, (settled, orbit), (side, from.arclength + length))
}

/// The factor on the next step, or why a point is not trusted.
fn judged(
    from: &AcceptedPoint,
    settled: &CorrectedPoint,
    chord: &BranchDirection,
) -> std::result::Result<f64, &'static str> {
    let factor = step_factor(settled.contraction, settled.tangent.dot(&from.tangent))?;
    let times = &chord.loop_part.as_slice()[settled.iterate.before_times().len()..];
    if times.iter().any(|shift| shift.abs() > STEP_PHASE_SHIFT) {
        return Err("an instant goes far");
    }
    Ok(factor)
}

fn at_boundary(found: &Boundary) -> BranchEnd {
    let (orbit, last) = (&found.other, found.last.as_ref());
    let reason = orbit.violation().map_or("", |v| v.reason.as_str());
    let place = last.map_or("here".to_owned(), |(settled, _)| {
        digits(settled.iterate.value)
    });
    BranchEnd::new(EndReason::Boundary, format!("beyond {place} {reason}"))
}

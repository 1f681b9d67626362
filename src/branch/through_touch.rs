//! A branch through a touch of a stop that gives way (theory 22, "Touches"): its orbits have a contact more behind it, or one less. The touch
//! is located on the side without the contact, where nothing is singular; on the other the duration of the contact is the unknown by which
//! the curve is smooth.

use crate::branch::boundary::is_broken;
use crate::branch::contact_nodes::{BriefContact, LoopWithout};
use crate::branch::multipliers::n_beyond_circle;
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{AcceptedPoint, StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::touch_multipliers::{at_touches, touches_with};
use crate::branch::touch_outcome::TouchMultipliers;
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{ScaledDirection, attempted, corrected};
use crate::error::Result;
use crate::orbit::PeriodicOrbit;
use crate::root::Secant;
use crate::tolerance::{
    BRIEF_CONTACT, LEAST_BRIEF_CONTACT, MARGINAL, TOUCH_BESIDE, TOUCH_LEFT, TOUCH_SECANT_STEP,
    UNDIVIDED_STEP_LENGTH, ZERO_PARAMETER_CHANGE,
};

/// Secants of a search for a touch. `[work]`
const MOST_TOUCH_SECANTS: usize = 30;
/// The factor from one duration of a contact that is tried to the next. `[work]`
const BRIEFER: f64 = 0.25;

/// A branch behind a touch: its problem, and the first point there.
pub(super) struct PassedTouch<'a> {
    pub problem: BranchProblem<'a>,
    pub point: AcceptedPoint,
}

/// Whether a special point is a touch that a branch goes through.
pub(super) fn is_passed(special: &Special) -> bool {
    matches!(
        special.kind,
        SpecialKind::Touch | SpecialKind::BorderCollision
    )
}

/// The branch behind a touch at which a contact begins; the special point gets the multipliers of both sides. None where no such orbit is
/// found next to it.
pub(super) fn onto_contact<'a>(
    problem: &BranchProblem<'a>,
    special: &mut Special,
) -> Result<Option<PassedTouch<'a>>> {
    let Some(touch) = special.stop.zip(special.time) else {
        return Ok(None);
    };
    let (whole, place) = problem.touching(&special.orbit, special.parameter)?;
    let sides = at_touches(
        &whole,
        (&place, &special.orbit),
        &touches_with(&special.orbit, touch),
    )?;
    let half = if problem.signature.images.is_some() {
        whole.half(&place)?
    } else {
        None
    };
    let (apart, place, touch) = match half {
        Some((half, at)) => {
            let (stop, time) = half.in_half(&at, (touch.0, place.state.times[0] + touch.1));
            let time = time - at.state.times[0];
            (half, at, (stop, time))
        }
        None => (whole, place, touch),
    };
    let met = sides
        .as_ref()
        .map(|[_, met]| n_beyond_circle(met, MARGINAL));
    let found = with_brief_contact(&apart, (&place, touch), met)?;
    let found = found.filter(|own| !is_broken(&own.point.orbit));
    special.touch = sides.map(|[before, after]| TouchMultipliers { before, after });
    special.arclength = special.arclength.next_up();
    Ok(found.map(|mut own| {
        own.point.arclength += special.arclength;
        own
    }))
}

/// The branch on which the touch of a loop, of a stop at a time from its first instant, has become a contact, at a point where that is brief: one
/// that keeps the rules of contact if there is one, with as many multipliers outside the circle as where it has no duration, if that is given.
pub(super) fn with_brief_contact<'a>(
    apart: &BranchProblem<'a>,
    (place, touch): (&ParametricLoop, (usize, f64)),
    met: Option<usize>,
) -> Result<Option<PassedTouch<'a>>> {
    let mut found: Option<PassedTouch<'a>> = None;
    let mut part = BRIEF_CONTACT;
    while part >= LEAST_BRIEF_CONTACT {
        if let Some(own) = lasting(apart, (place, touch), part)? {
            let keeps_rules = !is_broken(&own.point.orbit);
            if keeps_rules && (met.is_none() || own.point.test_values.outside == met) {
                return Ok(Some(own));
            }
            let was_broken = found.as_ref().is_none_or(|own| is_broken(&own.point.orbit));
            if keeps_rules || was_broken {
                found = Some(own);
            }
        }
        part *= BRIEFER;
    }
    Ok(found)
}

/// The same where the contact lasts for a part of the period.
fn lasting<'a>(
    apart: &BranchProblem<'a>,
    (place, touch): (&ParametricLoop, (usize, f64)),
    part: f64,
) -> Result<Option<PassedTouch<'a>>> {
    let state = &place.state;
    let duration = part * (state.times[state.states.len()] - state.times[0]);
    let Some((problem, at, contact)) = apart.with_contact(place, touch, duration)? else {
        return Ok(None);
    };
    let longer = problem.longer(&at, contact);
    let Ok(settled) = corrected(&problem, at.clone(), &longer.unit())? else {
        return Ok(None);
    };
    let (low, high) = problem.range;
    let value = settled.iterate.value;
    let Ok(orbit) = attempted(problem.closed_orbit(&settled.iterate), value)? else {
        return Ok(None);
    };
    if !(low..=high).contains(&value) {
        return Ok(None);
    }
    // Its beginning and its end go half of the way each.
    let length = 0.5 * duration / at.clock * longer.length();
    let ahead = longer.dot(&settled.tangent);
    let point = AcceptedPoint::settled(&problem, (settled, orbit), (ahead, length))?;
    Ok(Some(PassedTouch { problem, point }))
}

/// The touch at which a contact of a branch comes to an end on a step of some length, and the branch behind it; none where no contact does.
pub(super) fn off_contact<'a>(
    problem: &BranchProblem<'a>,
    from: &AcceptedPoint,
    length: f64,
) -> Result<Option<(Special, PassedTouch<'a>)>> {
    let scene = problem.scene(from.place.value)?;
    let mut ending: Option<(BriefContact, f64)> = None;
    for contact in problem.brief_contacts() {
        let longer = problem.longer(&from.place, contact);
        let duration = contact.duration(&from.place.state) / from.place.clock;
        let rate = longer.loop_part.dot(&from.tangent.loop_part);
        let left = -duration / rate;
        // The duration is smooth along the branch: it ends before this length or not much later.
        if rate < 0.0 && left < 2.0 * length && ending.is_none_or(|own| left < own.1) {
            ending = Some((contact, left));
        }
    }
    let Some((contact, left)) = ending else {
        return Ok(None);
    };
    let kind = match SpecialKind::of_touch(scene.stops()[contact.stop].contact()) {
        // With a preload contacts end as impacts do.
        SpecialKind::Graze if left > TOUCH_LEFT => return Ok(None),
        SpecialKind::Graze => SpecialKind::LostImpact,
        kind => kind,
    };
    // The parameter goes by the square of the duration.
    let expected = from.place.value + 0.5 * left * from.tangent.value_part * problem.span();
    let Some((rest, touched, time)) = touched_without(problem, from, contact, expected)? else {
        return Ok(None);
    };
    let (settled, orbit, ahead, error) = touched;
    let off = (settled.iterate.value - expected).abs();
    let way = (from.place.value - expected).abs();
    if off > way.max(TOUCH_BESIDE * problem.span()) {
        return Ok(None);
    }
    let touch = (contact.stop, time);
    let (whole, place) = problem.touching(&orbit, settled.iterate.value)?;
    let touches = touches_with(&orbit, touch);
    let sides = match kind {
        SpecialKind::LostImpact => None,
        _ => at_touches(&whole, (&place, &orbit), &touches)?,
    };
    let met = sides
        .as_ref()
        .map(|[_, met]| n_beyond_circle(met, MARGINAL));
    let is_near = met.is_none() || from.test_values.outside == met;
    if !is_near && left > UNDIVIDED_STEP_LENGTH {
        return Ok(None);
    }
    let arclength = from.arclength + left;
    let mut point = AcceptedPoint::settled(&rest, (settled, orbit), (ahead, arclength))?;
    let special = Special {
        stop: Some(contact.stop),
        time: Some(time),
        touch: sides.map(|[apart, met]| TouchMultipliers {
            before: met,
            after: apart,
        }),
        ..Special::at(kind, &point, error)
    };
    if let Some((settled, orbit)) = rest.beside_touch(&point)? {
        let arclength = arclength + TOUCH_LEFT;
        point = AcceptedPoint::settled(&rest, (settled, orbit), (1.0, arclength))?;
    }
    point.arclength = point.arclength.max(arclength.next_up());
    Ok(Some((
        special,
        PassedTouch {
            problem: rest,
            point,
        },
    )))
}

/// A point of a branch, its orbit, the sign of the way along its tangent on which the gap opens, and the error of its parameter.
type TouchedPoint = (CorrectedPoint, PeriodicOrbit, f64, f64);

/// The motion without a contact that touches the stop of that, near an expected value; its problem, and when it does, from its first instant.
fn touched_without<'a>(
    problem: &BranchProblem<'a>,
    from: &AcceptedPoint,
    contact: BriefContact,
    expected: f64,
) -> Result<Option<(BranchProblem<'a>, TouchedPoint, f64)>> {
    let Some(LoopWithout {
        problem: rest,
        place,
        time,
    }) = problem.without_contact(&from.place, contact)?
    else {
        return Ok(None);
    };
    let by_value = BranchDirection::of_value(rest.n_unknowns(&place));
    let Ok(base) = corrected(&rest, place, &by_value)? else {
        return Ok(None);
    };
    let gap = |along: f64| -> Result<Option<(CorrectedPoint, PeriodicOrbit, f64)>> {
        let Ok(there) = step_to(&rest, base.base(), StepTarget::Length(along))? else {
            return Ok(None);
        };
        let Ok(orbit) = attempted(rest.closed_orbit(&there.iterate), there.iterate.value)? else {
            return Ok(None);
        };
        let least = orbit.least_gap_near(contact.stop, orbit.place_on_flight(time))?;
        Ok(least.map(|least| (there, orbit, least)))
    };
    let Some((_, _, here)) = gap(0.0)? else {
        return Ok(None);
    };
    let mut secant = Secant {
        at: 0.0,
        value: here,
    };
    let span = problem.span();
    let first = (expected - base.iterate.value) / span / base.tangent.value_part;
    let is_sensible = first.is_finite() && first != 0.0 && first.abs() < 1.0;
    let mut along = if is_sensible {
        first
    } else {
        TOUCH_SECANT_STEP
    };
    let mut slope = 0.0;
    for _ in 0..MOST_TOUCH_SECANTS {
        let Some((there, orbit, least)) = gap(along)? else {
            return Ok(None);
        };
        let (at, value) = (secant.at, secant.value);
        let step = secant.step(along, least);
        if least != value {
            slope = (least - value) / (along - at);
        }
        let error = (step * there.tangent.value_part).abs() * span;
        let is_there = least == 0.0 || error <= ZERO_PARAMETER_CHANGE * span;
        if is_there && slope != 0.0 {
            let ahead = slope * there.tangent.dot(&base.tangent);
            let error = if least == 0.0 { 0.0 } else { error };
            let error = error.max(f64::EPSILON * span);
            return Ok(Some((rest, (there, orbit, ahead, error), time)));
        }
        along += step;
        if !along.is_finite() {
            return Ok(None);
        }
    }
    Ok(None)
}

impl BranchProblem<'_> {
    /// The loop of a whole period that an orbit of the branch is where it touches a stop, and its problem.
    fn touching(&self, orbit: &PeriodicOrbit, value: f64) -> Result<(Self, ParametricLoop)> {
        let (problem, mut place) = Self::around(orbit, self.make, value, self.range)?;
        // Times count as on this branch.
        let late = (problem.phase - self.phase) * place.clock;
        if !self.is_free {
            let (times, starts) = (&mut place.state.times, &mut place.state.starts);
            times.iter_mut().chain(starts).for_each(|t| *t += late);
        }
        let problem = Self {
            units: self.units,
            phase: self.phase,
            ..problem
        };
        Ok((problem, place))
    }

    /// A point beside one that touches a stop, along its tangent; none where it breaks a rule of contact.
    fn beside_touch(&self, at: &AcceptedPoint) -> Result<Option<(CorrectedPoint, PeriodicOrbit)>> {
        let Ok(there) = step_to(self, at.base(), StepTarget::Length(TOUCH_LEFT))? else {
            return Ok(None);
        };
        let value = there.iterate.value;
        let (low, high) = self.range;
        let orbit = attempted(self.closed_orbit(&there.iterate), value)?.ok();
        let orbit = orbit.filter(|orbit| (low..=high).contains(&value) && !is_broken(orbit));
        Ok(orbit.map(|orbit| (there, orbit)))
    }
}

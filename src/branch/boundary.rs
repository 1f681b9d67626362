//! The locator of boundaries, beyond which the orbits of a branch break a rule of contact: between a point that keeps them and one that
//! does not, by a test function that is zero there, and by bisection. Lengths are arclengths along the tangent of the point before.

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::predictor::{AcceptedPoint, StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::release_onset::release_onset;
use crate::branch::special::{BreachKind, Special, SpecialKind, breach_kind, of_boundary};
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{
    ChangeBracket, LocatedZero, TestEvaluation, attempted, evaluated, locate_change, locate_zero,
};
use crate::error::Result;
use crate::orbit::{PeriodicOrbit, Touch};
use crate::tolerance::{BRANCH_BOUNDARY_LENGTH, BREACH_AT_TOUCH, CUBIC_LANDING_ERROR};

/// The factor by which the search moves farther from the expected boundary each time that it was on the wrong side. `[work]`
const RETREAT_FACTOR: f64 = 16.0;

/// What lies on both sides of a boundary on a step: the point nearest to it on the side of the step's beginning, the orbit on the other.
pub(super) struct Boundary {
    pub last: Option<(CorrectedPoint, PeriodicOrbit)>,
    pub other: PeriodicOrbit,
    /// By how much the parameter differs between them.
    pub width: f64,
    /// The length between them if the corrector failed there: a step from the last point may succeed.
    pub left: Option<f64>,
    /// At a graze: the value at which the stop is touched, its error, and the orbit.
    touch: Option<(f64, f64, PeriodicOrbit)>,
}

impl Boundary {
    /// The boundary as a special point, by the orbit that breaks a rule, next to a point; with the unit of velocities.
    pub fn special(
        &self,
        broken: &PeriodicOrbit,
        at: &AcceptedPoint,
        speed: f64,
    ) -> Option<Special> {
        let own = of_boundary(broken, at, self.width, speed)?;
        Some(match &self.touch {
            Some((parameter, error, orbit)) => Special {
                parameter: *parameter,
                error: *error,
                orbit: orbit.clone(),
                ..own
            },
            None => own,
        })
    }
}

/// Whether an orbit breaks a rule of contact.
pub(super) fn is_broken(orbit: &PeriodicOrbit) -> bool {
    orbit.is_admissible() == Some(false)
}

/// Locates a boundary that lies on a step from a point.
pub(super) fn located(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    step: f64,
    (there, other): (&ParametricLoop, PeriodicOrbit),
) -> Result<Boundary> {
    let was_broken = is_broken(&from.orbit);
    let mut beside = [0.25 * BRANCH_BOUNDARY_LENGTH; 2];
    let mut expected: Option<ExpectedBoundary> = None;
    let mut aim = |bracket: &BoundaryBracket| {
        if expected.is_none() {
            let [low, high] = bracket.points.each_ref().map(Option::as_ref);
            let low = low.map_or((&from.place, &from.orbit), loop_of);
            let high = high.map_or((there, &other), loop_of);
            expected = zero_of_breach(problem, from, bracket.ends, [low, high])?;
        }
        let root = expected.as_ref().map(|zero| zero.along);
        Ok(aimed(root, bracket.ends, &mut beside))
    };
    let mut at = |along: f64| {
        let Ok(settled) = step_to(problem, from.base(), StepTarget::Length(along))? else {
            return Ok(None);
        };
        let value = settled.iterate.value;
        let orbit = attempted(problem.closed_orbit(&settled.iterate), value)?;
        Ok(orbit.ok().map(|orbit| {
            let is_before = is_broken(&orbit) == was_broken;
            ((settled, orbit), is_before)
        }))
    };
    let bracket = locate_change(step, BRANCH_BOUNDARY_LENGTH, &mut aim, &mut at)?;
    let ([low, high], [last, beyond]) = (bracket.ends, bracket.points);
    let value = |own: &(CorrectedPoint, PeriodicOrbit)| own.0.iterate.value;
    let before = last.as_ref().map_or(from.place.value, value);
    let after = beyond.as_ref().map_or(there.value, value);
    let mut found = Boundary {
        last,
        other: beyond.map_or(other, |(_, orbit)| orbit),
        width: (before - after).abs(),
        left: (!bracket.is_reached).then_some(high - low),
        touch: None,
    };
    let kept = found.last.as_ref().map_or(&from.orbit, |(_, orbit)| orbit);
    let breach = between(problem, [kept, &found.other]);
    let Some(BreachKind {
        kind, stop, time, ..
    }) = breach
    else {
        return Ok(found);
    };
    // The stop is touched before it is seen to be passed, by more than rounding: the touch is the special point.
    let is_near = |own: &Touch| {
        own.stop == stop && (own.time - time).abs() <= BREACH_AT_TOUCH * kept.period()
    };
    let is_touch = |zero: &ExpectedBoundary| {
        let touches = zero
            .point
            .1
            .as_ref()
            .map_or(&[][..], PeriodicOrbit::touches);
        kind == SpecialKind::Graze && zero.along <= high && touches.iter().any(is_near)
    };
    if let Some(LocatedZero {
        point: (settled, Some(orbit)),
        error,
        ..
    }) = expected.filter(is_touch)
    {
        let error = error.max(f64::EPSILON * problem.span());
        found.touch = Some((settled.iterate.value, error, orbit));
        return Ok(found);
    }
    let landing = problem.instant_of(&from.place, (stop, from.place.state.times[0] + time));
    let sharp = match (kind, landing) {
        (SpecialKind::LandingBorder, Some(k)) => zero_of(problem, from, step, &|there| {
            problem.opening(there, k).map(Some)
        })?,
        (SpecialKind::Rise, _) => zero_of(problem, from, step, &|there| {
            Ok(release_onset(problem, there, (stop, time))?.map(|pull| pull.most))
        })?,
        _ => None,
    };
    if let Some((there, error)) = sharp {
        (found.last, found.width) = (Some(there), error);
    } else if breach.is_some_and(|own| own.is_by_cube) {
        found.width = CUBIC_LANDING_ERROR * problem.span();
    }
    Ok(found)
}

/// The part of a step on which a boundary lies.
type BoundaryBracket = ChangeBracket<(CorrectedPoint, PeriodicOrbit)>;

/// The loop and the orbit of a point.
fn loop_of(
    (settled, orbit): &(CorrectedPoint, PeriodicOrbit),
) -> (&ParametricLoop, &PeriodicOrbit) {
    (&settled.iterate, orbit)
}

/// The kind of the boundary between two orbits, of which one breaks a rule.
fn between(problem: &BranchProblem<'_>, [one, other]: [&PeriodicOrbit; 2]) -> Option<BreachKind> {
    let (broken, kept) = if is_broken(one) {
        (one, other)
    } else {
        (other, one)
    };
    breach_kind(broken, kept, problem.units.velocity)
}

/// A point at which a boundary is expected, with the orbit if it is a graze.
type ExpectedBoundary = LocatedZero<(CorrectedPoint, Option<PeriodicOrbit>)>;

/// Where a boundary is expected between two lengths of a step, by the zero of the speed of an impact or of the gap at a touch; none where
/// that does not change its sign.
fn zero_of_breach(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    [low, high]: [f64; 2],
    [one, other]: [(&ParametricLoop, &PeriodicOrbit); 2],
) -> Result<Option<ExpectedBoundary>> {
    let Some(breach) = between(problem, [one.1, other.1]) else {
        return Ok(None);
    };
    let (stop, time) = (breach.stop, breach.time);
    let struck = problem.instant_of(&from.place, (stop, from.place.state.times[0] + time));
    let speed = |place: &ParametricLoop| struck.map(|k| problem.approach(place, k)).transpose();
    let broken = if is_broken(other.1) { other.1 } else { one.1 };
    let touched = broken.place_on_flight(time);
    let gap = |orbit: &PeriodicOrbit| orbit.least_gap_near(stop, touched);
    let ends = match breach.kind {
        SpecialKind::LostImpact => [speed(one.0)?, speed(other.0)?],
        SpecialKind::Graze => [gap(one.1)?, gap(other.1)?],
        _ => return Ok(None),
    };
    let [Some(before), Some(after)] = ends else {
        return Ok(None);
    };
    if before * after >= 0.0 {
        return Ok(None);
    }
    let mut point = |along: f64| {
        let Ok(settled) = step_to(problem, from.base(), StepTarget::Length(low + along))? else {
            return Ok(None);
        };
        let (value, orbit) = if breach.kind == SpecialKind::Graze {
            let Ok(orbit) = attempted(
                problem.closed_orbit(&settled.iterate),
                settled.iterate.value,
            )?
            else {
                return Ok(None);
            };
            (gap(&orbit)?, Some(orbit))
        } else {
            (speed(&settled.iterate)?, None)
        };
        Ok(value.map(|value| TestEvaluation {
            parameter: settled.iterate.value,
            value,
            point: (settled, orbit),
        }))
    };
    let zero = locate_zero([high - low, before, after], problem.span(), &mut point)?;
    Ok(zero.map(|zero| LocatedZero {
        along: low + zero.along,
        ..zero
    }))
}

/// The next trial of the bisection: next to the expected zero on the side of the farther end, each time farther from it; in the middle
/// where none is expected, or the trial would be outside.
fn aimed(root: Option<f64>, [low, high]: [f64; 2], beside: &mut [f64; 2]) -> f64 {
    let aimed = root.map(|root| {
        let side = usize::from(root - low < high - root);
        let off = beside[side];
        beside[side] *= RETREAT_FACTOR;
        if side == 0 { root - off } else { root + off }
    });
    aimed
        .filter(|along| low < *along && *along < high)
        .unwrap_or(0.5 * (low + high))
}

/// Where a test function of a loop is zero on a step, or on one as long before it, as rules may be broken by less than rounding there; and
/// the error of the parameter. None where it does not change its sign.
fn zero_of(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    step: f64,
    of: &dyn Fn(&ParametricLoop) -> Result<Option<f64>>,
) -> Result<Option<((CorrectedPoint, PeriodicOrbit), f64)>> {
    let at = |along: f64| {
        evaluated(problem, from.base(), along, |settled| {
            let place = &settled.iterate;
            Ok(of(place)?.map(|value| (place.value, value)))
        })
    };
    let value = |along: f64| at(along).map(|there| there.map(|there| there.value));
    for begin in [0.0, -step] {
        let (Some(before), Some(after)) = (value(begin)?, value(begin + step)?) else {
            continue;
        };
        if before * after >= 0.0 {
            continue;
        }
        let mut point = |along: f64| at(begin + along);
        let zero = locate_zero([step, before, after], problem.span(), &mut point)?;
        let Some(zero) = zero else {
            return Ok(None);
        };
        let value = zero.point.iterate.value;
        let orbit = attempted(problem.closed_orbit(&zero.point.iterate), value)?.ok();
        return Ok(orbit.map(|orbit| ((zero.point, orbit), zero.error)));
    }
    Ok(None)
}

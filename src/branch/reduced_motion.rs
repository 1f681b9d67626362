//! The reduced motion at a border: without the stick or the flight whose duration is zero there; and the border, located on that motion,
//! where nothing is singular (theory 19, "Landing", "Rise"). Values are of the parameter, in its unit.

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::release_onset::release_onset;
use crate::branch::shooting_nodes::{period, rebuilt};
use crate::branch::simulated::simulated;
use crate::continuation::corrected;
use crate::error::Result;
use crate::itinerary::{turned, without_first};
use crate::orbit::PeriodicOrbit;
use crate::root::Secant;
use crate::tolerance::{
    BEYOND_BOUNDARY_DISTANCE, BORDER_REACH, BORDER_SECANT_STEP, ZERO_PARAMETER_CHANGE,
};
use std::f64::consts::TAU;

/// Secants of a search for a border. `[work]`
const MOST_BORDER_SECANTS: usize = 20;

/// A border that is located, its error, and the reduced motion there.
pub(super) struct LocatedBorder {
    pub value: f64,
    pub error: f64,
    pub orbit: PeriodicOrbit,
}

/// The motion near a loop without the stick or the flight that begins at an instant, and its problem; none where there is no such motion.
pub(super) fn reduced_motion<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    instant: usize,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    if let Some((rest, at)) = without(problem, place, instant)? {
        let by_value = BranchDirection::of_value(rest.n_unknowns(&at));
        if let Ok(settled) = corrected(&rest, at, &by_value)? {
            return Ok(Some((rest, settled.iterate)));
        }
    }
    reduced_by_simulation(problem, place)
}

/// The guess of the reduced motion: a stop that is held for no time is left at once, one that is left for no time stays held.
fn without<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    instant: usize,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    let whole = period(&place.state);
    let instants = turned(problem.instants(&place.state), instant, whole);
    match without_first(instants) {
        Some(instants) => rebuilt(problem, place, instants),
        None => Ok(None),
    }
}

/// A reduced motion by simulation: near the border, on one side or the other, a round of the motion is simulated and closed; it counts if
/// it has fewer instants.
fn reduced_by_simulation<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    for side in [1.0, -1.0] {
        let value = place.value + side * BEYOND_BOUNDARY_DISTANCE * problem.span();
        if let Some((rest, at)) = simulated(problem, place, value, 0)?
            && rest.signature.stages.n_changes() < problem.signature.stages.n_changes()
        {
            let by_value = BranchDirection::of_value(rest.n_unknowns(&at));
            if let Ok(settled) = corrected(&rest, at, &by_value)? {
                return Ok(Some((rest, settled.iterate)));
            }
        }
    }
    Ok(None)
}

/// The border at which the stick or the flight that begins at an instant has no duration left: on the reduced motion a stop is neither left
/// nor pressed onto there, after the impact or where its contact force is least.
pub(super) fn border(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    instant: usize,
) -> Result<Option<LocatedBorder>> {
    let time = place.state.times[instant];
    // In the reduced motion times may count from another instant, and by whole periods of the forcing from another round.
    let angle = problem.phase + time / place.clock;
    let times = |rest: &BranchProblem<'_>, there: &ParametricLoop| -> Vec<f64> {
        let late = there.state.times[0] / there.clock + rest.phase;
        let first = (angle - late).rem_euclid(TAU);
        let rounds = 0..rest.signature.n_periods;
        let each = rounds.map(|k| (first + TAU * k as f64) * there.clock);
        each.collect()
    };
    let stages = &problem.signature.stages;
    if let Some(stop) = stages.impact(instant) {
        zero_without(problem, (place, instant), &|rest, there| {
            let first = there.state.times[0];
            let each = times(rest, there).into_iter().map(|t| {
                let instant = rest.instant_of(there, (stop, first + t));
                instant.map(|k| rest.opening(there, k)).transpose()
            });
            Ok(nearest_to_zero(each.collect::<Result<Vec<_>>>()?))
        })
    } else if let Some(stop) = stages.departure(instant) {
        zero_without(problem, (place, instant), &|rest, there| {
            let each = times(rest, there).into_iter().map(|t| {
                let pull = release_onset(rest, there, (stop, t))?;
                Ok(pull.map(|pull| pull.most))
            });
            Ok(nearest_to_zero(each.collect::<Result<Vec<_>>>()?))
        })
    } else {
        Ok(None)
    }
}

fn nearest_to_zero(all: Vec<Option<f64>>) -> Option<f64> {
    let known = all.into_iter().flatten();
    known.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// A test function of a loop: none where it is not defined.
type BorderFunction<'a> = &'a dyn Fn(&BranchProblem<'_>, &ParametricLoop) -> Result<Option<f64>>;

/// Where a test function of the reduced motion is zero, by secants over the parameter.
fn zero_without(
    problem: &BranchProblem<'_>,
    (place, instant): (&ParametricLoop, usize),
    of: BorderFunction<'_>,
) -> Result<Option<LocatedBorder>> {
    let Some((rest, at)) = reduced_motion(problem, place, instant)? else {
        return Ok(None);
    };
    let by_value = BranchDirection::of_value(rest.n_unknowns(&at));
    let Ok(settled) = corrected(&rest, at, &by_value)? else {
        return Ok(None);
    };
    let base = settled.base();
    let number = |value: f64| -> Result<Option<f64>> {
        match step_to(&rest, base, StepTarget::Value(value))? {
            Ok(there) => of(&rest, &there.iterate),
            Err(_) => Ok(None),
        }
    };
    let span = problem.span();
    let Some(number_here) = number(place.value)? else {
        return Ok(None);
    };
    let mut secant = Secant {
        at: place.value,
        value: number_here,
    };
    let mut value = place.value + BORDER_SECANT_STEP * span;
    for _ in 0..MOST_BORDER_SECANTS {
        let Some(own) = number(value)? else {
            return Ok(None);
        };
        let by = secant.step(value, own);
        value += by;
        if !by.is_finite() || (value - place.value).abs() > BORDER_REACH * span {
            return Ok(None);
        }
        if by.abs() <= ZERO_PARAMETER_CHANGE * span {
            let Ok(there) = step_to(&rest, base, StepTarget::Value(value))? else {
                return Ok(None);
            };
            return Ok(Some(LocatedBorder {
                value,
                error: by.abs().max(f64::EPSILON * span),
                orbit: rest.orbit(&there.iterate)?,
            }));
        }
    }
    Ok(None)
}

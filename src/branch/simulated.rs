//! The orbit beyond a boundary by simulation: whatever its instants are there, each impact and each release is what the laws of contact
//! make of it (theory 19, "Switching").

use crate::branch::candidate::Candidate;
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::period;
use crate::continuation::corrected;
use crate::error::{Error, Result};
use crate::hybrid::carried;
use crate::hybrid::halves;
use crate::law::Regime;
use crate::orbit::{Guess, PeriodicOrbit, Signature, begun, with_maps, with_phase};
use crate::simulate::{ImpactSide, Keep, SimulateOptions, Status, simulate};
use crate::tolerance::{
    BEYOND_BOUNDARY_DISTANCE, MEETS_BRANCH_DISTANCE, NEARER_BOUNDARY_FACTOR, NEARING_FACTOR,
    NEARING_IN_A_ROW, SAME_AS_BRANCH, SETTLING_ROUNDS,
};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Distances from a boundary at which motions are simulated, each nearer than the one before. `[work]`
const MOST_NEARER_MOTIONS: usize = 5;
/// Phases of the forcing at which two orbits are compared. `[work]`
const COMPARED_PHASES: u32 = 64;

/// The time in the middle of the longest free flight of a loop, and the state there; none where a stop is always held.
fn in_flight(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
) -> Result<Option<(f64, DVector<f64>)>> {
    let state = &place.state;
    let span = |k: &usize| state.times[k + 1] - state.starts[*k];
    let is_free = |k: &usize| problem.signature.stages[*k].regime.is_free();
    let free = (0..state.states.len()).filter(is_free);
    let Some(k) = free.max_by(|a, b| span(a).total_cmp(&span(b))) else {
        return Ok(None);
    };
    let (start, time) = (state.starts[k], state.starts[k] + 0.5 * span(&k));
    let scene = problem.scene(place.value)?;
    let x = with_maps(&scene, &problem.signature, |motion| {
        let span = (start, time);
        carried(motion, Regime::free(), span, &state.states[k])
    })?;
    Ok(Some((time, x)))
}

/// A loop in the scene of a value and its problem, from a motion that begins amid the longest free flight of a loop and is simulated for
/// some rounds. None where that does not come near an orbit, or without forcing.
pub(super) fn simulated<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    value: f64,
    rounds: usize,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    let Some((time, x)) = in_flight(problem, place)?.filter(|_| !problem.is_free) else {
        return Ok(None);
    };
    let Signature {
        n_periods,
        depends_on_time,
        ..
    } = problem.signature;
    let (mut q, mut v) = halves(&x);
    let phase = problem.phase + time / place.clock;
    let found = (problem.make)(value)
        .and_then(|scene| with_phase(&scene, phase, depends_on_time))
        .and_then(|scene| {
            if rounds > 0 {
                let once = scene.frequency().map_or(period(&place.state), |w| TAU / w);
                let end = once * (n_periods * rounds) as f64;
                let options = SimulateOptions {
                    keep: Keep::Final,
                    ..Default::default()
                };
                let run = simulate(&scene, &q, &v, (0.0, end), &options)?;
                if run.status() != Status::Finished {
                    return Ok(None);
                }
                let (last_q, last_v) = run.last();
                (q, v) = (last_q.clone(), last_v.clone());
            }
            let guess = Guess::State {
                q: &q,
                v: &v,
                period: None,
            };
            begun(&scene, guess, Some(n_periods)).map(Some)
        });
    let (scene, signature, state) = match found {
        Ok(Some(found)) => found,
        Ok(None) | Err(Error::BadValue { .. } | Error::NoConvergence { .. }) => return Ok(None),
        Err(error) => return Err(error),
    };
    let mut rest = BranchProblem {
        signature,
        phase: scene.phase(),
        ..problem.clone()
    };
    let at = rest.place(&scene, value, state)?;
    rest.formulation = rest.formulation.of_loop(&at);
    Ok(Some((rest, at)))
}

/// The orbit on which a motion goes on beyond a boundary, for larger or smaller parameters by a sign: one that keeps the rules of contact
/// and comes nearer to the last orbit as its parameter comes nearer to the boundary.
pub(super) fn simulated_beyond(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    side: f64,
) -> Result<Option<Candidate>> {
    let last = problem.orbit(place)?;
    for rounds in [0, SETTLING_ROUNDS] {
        let mut nearing: Vec<(Candidate, f64)> = Vec::new();
        let mut off = BEYOND_BOUNDARY_DISTANCE * problem.span();
        for _ in 0..MOST_NEARER_MOTIONS {
            let here = closed(problem, place, place.value + side * off, rounds)?;
            let here = match here {
                Some(own) => {
                    let apart = distance(&own.orbit, &last)?;
                    (apart <= MEETS_BRANCH_DISTANCE).then_some((own, apart))
                }
                None => None,
            };
            let comes = |nearer: f64| {
                let last = nearing.last();
                last.is_none_or(|(_, farther)| nearer <= NEARING_FACTOR * farther + SAME_AS_BRANCH)
            };
            if !here.as_ref().is_some_and(|(_, apart)| comes(*apart)) {
                nearing.clear();
            }
            nearing.extend(here);
            if nearing.len() == NEARING_IN_A_ROW {
                return Ok(Some(nearing.swap_remove(0).0));
            }
            off *= NEARER_BOUNDARY_FACTOR;
        }
    }
    Ok(None)
}

/// The orbit near a simulated motion in the scene of a value, if it keeps the rules of contact.
fn closed(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    value: f64,
    rounds: usize,
) -> Result<Option<Candidate>> {
    let Some((own, at)) = simulated(problem, place, value, rounds)? else {
        return Ok(None);
    };
    let by_value = BranchDirection::of_value(own.n_unknowns(&at));
    let Ok(settled) = corrected(&own, at, &by_value)? else {
        return Ok(None);
    };
    let found = Candidate::at(&own, &settled.iterate, place.value)?;
    Ok(Some(found).filter(|own| own.orbit.is_admissible() != Some(false)))
}

/// The largest distance of an orbit from another at equal phases of the forcing, in parts of the other's largest coordinate \[-\].
fn distance(orbit: &PeriodicOrbit, other: &PeriodicOrbit) -> Result<f64> {
    // Phases are known up to periods of the forcing: the shift by whole periods with the least distance counts.
    let rounds = orbit.n_periods().max(other.n_periods());
    let ahead = (orbit.phase() - other.phase()) / TAU;
    let state = |own: &PeriodicOrbit, periods: f64| {
        let once = own.period() / own.n_periods() as f64;
        own.state_at(periods * once, ImpactSide::After).0
    };
    let size = other.max_displacement()?.into_iter().fold(0.0, f64::max);
    let mut least = f64::INFINITY;
    for round in 0..rounds {
        let mut most = 0.0f64;
        for k in 0..COMPARED_PHASES {
            let periods = rounds as f64 * f64::from(k) / f64::from(COMPARED_PHASES);
            let there = state(other, periods + ahead + round as f64);
            most = most.max((state(orbit, periods) - there).amax());
        }
        least = least.min(most);
    }
    Ok(least / size)
}

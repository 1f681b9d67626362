//! What a motion is on the other side of a boundary, by following it: whatever its instants are there, each impact and each release is what the
//! laws of contact make of it (theory 19, "Switching").

use crate::branch::candidate::Candidate;
use crate::branch::family::Family;
use crate::branch::instants::{are_impacts, period};
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::orbit::{Guess, PeriodicOrbit, Signature, begun, with_phase, with_shooting};
use crate::simulate::{Keep, SimulateOptions, Status, simulate};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// How far beyond a boundary is looked at first, in parts of the range; by what factor nearer, and how often: another boundary may be as near.
const BEYOND: f64 = 1e-4;
const NEARER: f64 = 0.1;
const MOST_NEARER: usize = 5;
/// Rounds in which a motion settles: a deviation that is half as large after each is 1e-9 of itself.
const SETTLING: usize = 30;
/// An orbit that meets a branch comes nearer to the last one of that by this factor at least, from one distance to the next and from that to the next
/// again: once it may for another reason, as the orbits beyond a fold next to the boundary do. It is another where it does not, or is farther
/// than this part of the motion.
const COMES_NEARER: f64 = 0.6;
const IN_A_ROW: usize = 3;
const FAR: f64 = 0.1;
/// Orbits that differ by less are one.
const SAME: f64 = 1e-9;
/// Times at which two orbits are compared.
const TIMES: u32 = 64;

/// The time in the middle of the longest free flight of a loop, and the state there; none where a stop is always held.
fn in_flight(family: &Family<'_>, place: &Place) -> Result<Option<(f64, DVector<f64>)>> {
    let state = &place.state;
    let span = |k: &usize| state.times[k + 1] - state.starts[*k];
    let is_free = |k: &usize| family.signature.stages[*k].held.is_empty();
    let free = (0..state.states.len()).filter(is_free);
    let Some(k) = free.max_by(|a, b| span(a).total_cmp(&span(b))) else {
        return Ok(None);
    };
    let (start, time) = (state.starts[k], state.starts[k] + 0.5 * span(&k));
    let mut x = state.states[k].clone();
    let scene = family.scene(place.value)?;
    with_shooting(&scene, &family.signature, |shooting, _| {
        let none = &mut DMatrix::zeros(x.len(), 0);
        shooting.motion.flow(&[], (start, time), &mut x, none)
    })?;
    Ok(Some((time, x)))
}

/// The loop that a motion is in the scene of a value, which begins amid the longest flight of a loop, after some rounds; none where it is none, or
/// without forcing.
pub(super) fn simulated<'a>(
    family: &Family<'a>,
    place: &Place,
    value: f64,
    rounds: usize,
) -> Result<Option<(Family<'a>, Place)>> {
    let Some((time, x)) = in_flight(family, place)?.filter(|_| !family.is_free) else {
        return Ok(None);
    };
    let Signature {
        n_periods,
        depends_on_time,
        ..
    } = family.signature;
    let n = x.len() / 2;
    let (mut q, mut v) = (x.rows(0, n).into_owned(), x.rows(n, n).into_owned());
    let phase = family.phase + time / place.clock;
    let found = (family.make)(value)
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
    let rest = Family {
        has_pulses: family.has_pulses && are_impacts(&signature.stages),
        signature,
        phase: scene.phase(),
        ..family.clone()
    };
    let at = rest.place(&scene, value, state)?;
    Ok(Some((rest, at)))
}

/// The orbit on which the motion of a loop goes on beyond a boundary there, on the side of a sign of the number: one that keeps the rules of
/// contact and comes to the loop as the number does.
pub(super) fn beyond(family: &Family<'_>, place: &Place, side: f64) -> Result<Option<Candidate>> {
    let last = family.orbit(place)?;
    for rounds in [0, SETTLING] {
        let mut nearing: Vec<(Candidate, f64)> = Vec::new();
        let mut off = BEYOND * family.span();
        for _ in 0..MOST_NEARER {
            let here = closed(family, place, place.value + side * off, rounds)?;
            let here = match here {
                Some(own) => {
                    let apart = distance(&own.orbit, &last)?;
                    (apart <= FAR).then_some((own, apart))
                }
                None => None,
            };
            let comes = |nearer: f64| {
                let last = nearing.last();
                last.is_none_or(|(_, farther)| nearer <= COMES_NEARER * farther + SAME)
            };
            if !here.as_ref().is_some_and(|(_, apart)| comes(*apart)) {
                nearing.clear();
            }
            nearing.extend(here);
            if nearing.len() == IN_A_ROW {
                return Ok(Some(nearing.swap_remove(0).0));
            }
            off *= NEARER;
        }
    }
    Ok(None)
}

/// The orbit that keeps the rules of contact and that a motion from a loop is near, in the scene of a value.
fn closed(
    family: &Family<'_>,
    place: &Place,
    value: f64,
    rounds: usize,
) -> Result<Option<Candidate>> {
    let Some((own, at)) = simulated(family, place, value, rounds)? else {
        return Ok(None);
    };
    let by_value = Direction::of_value(own.n_unknowns(&at));
    let Ok(settled) = own.corrected(at, &by_value)? else {
        return Ok(None);
    };
    let found = Candidate::at(&own, &settled.place, place.value)?;
    Ok(Some(found).filter(|own| own.orbit.is_admissible() != Some(false)))
}

/// How far an orbit is from another at equal phases of the forcing, in parts of the other's largest coordinate.
fn distance(orbit: &PeriodicOrbit, other: &PeriodicOrbit) -> Result<f64> {
    // The phases are known to a period of the forcing; of those that an orbit goes through the nearest one counts.
    let rounds = orbit.n_periods().max(other.n_periods());
    let ahead = (orbit.phase() - other.phase()) / TAU;
    let state = |own: &PeriodicOrbit, periods: f64| {
        let once = own.period() / own.n_periods() as f64;
        own.state(periods * once, false).0
    };
    let size = other.max_displacement()?.into_iter().fold(0.0, f64::max);
    let mut least = f64::INFINITY;
    for round in 0..rounds {
        let mut most = 0.0f64;
        for k in 0..TIMES {
            let periods = rounds as f64 * f64::from(k) / f64::from(TIMES);
            let there = state(other, periods + ahead + round as f64);
            most = most.max((state(orbit, periods) - there).amax());
        }
        least = least.min(most);
    }
    Ok(least / size)
}

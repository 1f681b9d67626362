//! The motion at a border without the stay or the flight that comes to nothing there, and where that is (theory 19, "Landing", "Rise").

use crate::branch::family::Family;
use crate::branch::instants::{Instant, as_loop, period, rebuilt, turned};
use crate::branch::place::{Direction, Place};
use crate::branch::risen::strongest_pull;
use crate::branch::simulated::simulated;
use crate::branch::step::{Target, step_to};
use crate::error::Result;
use crate::orbit::{ContactStage, Event, PeriodicOrbit};
use std::f64::consts::TAU;

/// How far from a border the motion beyond is looked for, in parts of the range.
const BEYOND: f64 = 1e-4;
/// The first step of a search by secants and how far it may go, in parts of the range; when it is over.
const BESIDE: f64 = 1e-6;
const NEAR: f64 = 1e-2;
const KNOWN: f64 = 1e-12;
const MOST_SECANTS: usize = 20;

/// A border that is known sharply, and the motion there without what comes to nothing.
pub(super) struct Sharp {
    pub value: f64,
    pub error: f64,
    pub orbit: PeriodicOrbit,
}

/// How often a stop is let go, and how often one is hit where none is hit on and on.
fn n_changes(stages: &[ContactStage]) -> (usize, usize) {
    let is_release = |stage: &&ContactStage| matches!(stage.event, Event::Release(_));
    let is_chatter = |stage: &ContactStage| matches!(stage.event, Event::Chatter(_));
    let n_releases = stages.iter().filter(is_release).count();
    let n_impacts = if stages.iter().any(is_chatter) {
        0
    } else {
        stages.len() - n_releases
    };
    (n_releases, n_impacts)
}

/// The motion near a loop without the stay or the flight that begins at an instant and comes to nothing; none where that is not to be had.
pub(super) fn with_less<'a>(
    family: &Family<'a>,
    place: &Place,
    instant: usize,
) -> Result<Option<(Family<'a>, Place)>> {
    if let Some((rest, at)) = without(family, place, instant)? {
        let by_value = Direction::of_value(rest.n_unknowns(&at));
        if let Ok(settled) = rest.corrected(at, &by_value)? {
            return Ok(Some((rest, settled.place)));
        }
    }
    followed(family, place)
}

/// The loop without what begins at an instant: a stop that is held for no time is left at once, one that is left for no time is held.
fn without<'a>(
    family: &Family<'a>,
    place: &Place,
    instant: usize,
) -> Result<Option<(Family<'a>, Place)>> {
    let mut instants = turned(family.instants(&place.state), instant, period(&place.state));
    let Some(next) = instants.get(1).map(|own| own.stage.clone()) else {
        return Ok(None);
    };
    match (instants[0].stage.event.clone(), next.event) {
        (Event::Strike(_), Event::Release(stop)) => {
            instants[0].stage.held.retain(|own| *own != stop);
            instants.remove(1);
        }
        (Event::Strike(_), Event::Strike(_)) => {
            instants[0].stage.held = next.held;
            instants.remove(1);
        }
        (Event::Release(stop), _) => {
            let is_back = |own: &Instant| own.stage.held.contains(&stop);
            let Some(back) = instants.iter().position(is_back) else {
                return Ok(None);
            };
            let landed = instants[back].clone();
            instants.drain(..=back);
            if instants.is_empty() {
                // Held for good, from where it had come to rest.
                let mut always = landed;
                always.time = always.start;
                always.stage.event = Event::Nothing;
                return as_loop(family, place, vec![always]);
            }
        }
        _ => return Ok(None),
    }
    rebuilt(family, place, instants)
}

/// The motion near a loop, on one side of its value, that has a stay or a flight less: what a flight comes to that is followed for a round.
fn followed<'a>(family: &Family<'a>, place: &Place) -> Result<Option<(Family<'a>, Place)>> {
    for side in [1.0, -1.0] {
        let value = place.value + side * BEYOND * family.span();
        if let Some((rest, at)) = simulated(family, place, value, 0)?
            && n_changes(&rest.signature.stages) < n_changes(&family.signature.stages)
        {
            let by_value = Direction::of_value(rest.n_unknowns(&at));
            if let Ok(settled) = rest.corrected(at, &by_value)? {
                return Ok(Some((rest, settled.place)));
            }
        }
    }
    Ok(None)
}

/// Where a stay or a flight that begins at an instant comes to nothing, and how far that is known: where on the motion without it a stop is
/// neither left nor pressed onto, behind the impact or where its force is least.
pub(super) fn border(family: &Family<'_>, place: &Place, instant: usize) -> Result<Option<Sharp>> {
    let time = place.state.times[instant];
    // In the motion without it times may count from elsewhere, by whole periods of the forcing too.
    let angle = family.phase + time / place.clock;
    let times = |rest: &Family<'_>, there: &Place| -> Vec<f64> {
        let late = there.state.times[0] / there.clock + rest.phase;
        let first = (angle - late).rem_euclid(TAU);
        let rounds = 0..rest.signature.n_periods;
        let each = rounds.map(|k| (first + TAU * k as f64) * there.clock);
        each.collect()
    };
    match &family.signature.stages[instant].event {
        Event::Strike(stops) => {
            let stop = stops[0];
            zero_without(family, (place, instant), &|rest, there| {
                let first = there.state.times[0];
                let each = times(rest, there).into_iter().map(|t| {
                    let instant = rest.instant_of(there, (stop, first + t));
                    instant.map(|k| rest.opening(there, k)).transpose()
                });
                Ok(nearest_to_zero(each.collect::<Result<Vec<_>>>()?))
            })
        }
        Event::Release(stop) => zero_without(family, (place, instant), &|rest, there| {
            let each = times(rest, there).into_iter().map(|t| {
                let pull = strongest_pull(rest, there, (*stop, t))?;
                Ok(pull.map(|pull| pull.most))
            });
            Ok(nearest_to_zero(each.collect::<Result<Vec<_>>>()?))
        }),
        _ => Ok(None),
    }
}

fn nearest_to_zero(all: Vec<Option<f64>>) -> Option<f64> {
    let known = all.into_iter().flatten();
    known.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// A number of a loop.
type Measure<'a> = &'a dyn Fn(&Family<'_>, &Place) -> Result<Option<f64>>;

/// Where a number is zero on the motion near a loop that has less, by secants.
fn zero_without(
    family: &Family<'_>,
    (place, instant): (&Place, usize),
    of: Measure<'_>,
) -> Result<Option<Sharp>> {
    let Some((rest, at)) = with_less(family, place, instant)? else {
        return Ok(None);
    };
    let by_value = Direction::of_value(rest.n_unknowns(&at));
    let Ok(settled) = rest.corrected(at, &by_value)? else {
        return Ok(None);
    };
    let foot = (&settled.place, &settled.equations, &settled.tangent);
    let number = |value: f64| -> Result<Option<f64>> {
        match step_to(&rest, foot, Target::Value(value))? {
            Ok(there) => of(&rest, &there.place),
            Err(_) => Ok(None),
        }
    };
    let span = family.span();
    let (mut before, mut value) = (place.value, place.value + BESIDE * span);
    let Some(mut at_before) = number(before)? else {
        return Ok(None);
    };
    for _ in 0..MOST_SECANTS {
        let Some(own) = number(value)? else {
            return Ok(None);
        };
        let by = own * (value - before) / (own - at_before);
        (before, at_before, value) = (value, own, value - by);
        if !by.is_finite() || (value - place.value).abs() > NEAR * span {
            return Ok(None);
        }
        if by.abs() <= KNOWN * span {
            let Ok(there) = step_to(&rest, foot, Target::Value(value))? else {
                return Ok(None);
            };
            return Ok(Some(Sharp {
                value,
                error: by.abs().max(f64::EPSILON * span),
                orbit: rest.orbit(&there.place)?,
            }));
        }
    }
    Ok(None)
}

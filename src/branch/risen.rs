//! The motion behind a rise (theory 19, "Rise"): where the force of a contact comes to zero and would pull, the stop is let go and landed on
//! again.

use crate::branch::family::Family;
use crate::branch::instants::{Instant, begun_with_strike, period};
use crate::branch::place::Place;
use crate::error::Result;
use crate::hybrid::held_through;
use crate::model::contacts;
use crate::orbit::{ContactStage, Event, with_shooting};
use crate::tolerance::SAME_ROUND;
use nalgebra::{DMatrix, DVector};

/// The part of the contact about the time of the rise in which the force is least.
const ABOUT: f64 = 0.2;
/// Parts in which that is looked at first, and narrowings of three of them.
const PARTS: usize = 32;
const NARROWINGS: usize = 8;

/// Where a stop that is held would be left most readily.
pub(super) struct Pull {
    /// The instant from which it is held.
    instant: usize,
    time: f64,
    /// The acceleration with which it would be left, above zero where it pulls, and the curvature of that over time, downwards.
    pub most: f64,
    bend: f64,
}

/// How readily a stop that is held would be left near a time; none where it is not held.
pub(super) fn strongest_pull(
    family: &Family<'_>,
    place: &Place,
    (stop, time): (usize, f64),
) -> Result<Option<Pull>> {
    let state = &place.state;
    let instants = family.instants(state);
    let count = instants.len();
    let mut about = state.times[0] + time.rem_euclid(period(state));
    let Some(mut instant) = instants.iter().rposition(|own| own.start <= about) else {
        return Ok(None);
    };
    // The end of a contact is the start of what follows.
    let late = about - instants[instant].start;
    if !instants[instant].stage.held.contains(&stop) && late <= SAME_ROUND * period(state) {
        instant = (instant + count - 1) % count;
        about = state.times[instant + 1];
    }
    let (from, end) = (&instants[instant], state.times[instant + 1]);
    if !from.stage.held.contains(&stop) {
        return Ok(None);
    }
    let without = from.stage.held_but(stop);
    // At its own landing it is another border, at its release nothing pulls; where another stop's impact begins or ends the contact the force
    // may be least.
    let is_release =
        matches!(&instants[(instant + 1) % count].stage.event, Event::Release(own) if *own == stop);
    let was_held = instants[(instant + count - 1) % count]
        .stage
        .held
        .contains(&stop);
    let parts = usize::from(!was_held)..PARTS + usize::from(!is_release);
    let scene = family.scene(place.value)?;
    let mut signature = family.signature.clone();
    signature.stages.push(ContactStage {
        event: Event::Release(stop),
        held: without.clone(),
    });
    with_shooting(&scene, &signature, |shooting, _| {
        let pull = |t: f64| -> Result<f64> {
            let mut x = from.state.clone();
            let none = &mut DMatrix::zeros(x.len(), 0);
            let held = &from.stage.held;
            shooting.motion.flow(held, (from.start, t), &mut x, none)?;
            let rate = shooting.motion.rate(&without, t, &x)?;
            shooting.motion.gap_acceleration(stop, t, &x, &rate)
        };
        let half = ABOUT * (end - from.start);
        let (mut low, mut high) = ((about - half).max(from.start), (about + half).min(end));
        let mut top = (about, f64::NEG_INFINITY);
        for _ in 0..NARROWINGS {
            let step = (high - low) / PARTS as f64;
            for i in parts.clone() {
                let t = low + step * i as f64;
                let own = pull(t)?;
                if own > top.1 {
                    top = (t, own);
                }
            }
            (low, high) = ((top.0 - step).max(from.start), (top.0 + step).min(end));
        }
        let (time, most) = top;
        // The curvature over a part of the contact that rounding leaves alone.
        let step = 1e-3 * (end - from.start);
        let bend = (2.0 * most - pull(time - step)? - pull(time + step)?) / (step * step);
        Ok(Some(Pull {
            instant,
            time,
            most,
            bend,
        }))
    })
}

/// A motion without instants that begins half a period before a time.
fn begun_before(family: &Family<'_>, place: &Place, time: f64) -> Result<Place> {
    let whole = period(&place.state);
    let mut state = place.state.clone();
    let begin = state.times[0];
    let late = (time - 0.5 * whole).rem_euclid(whole);
    let scene = family.scene(place.value)?;
    with_shooting(&scene, &family.signature, |shooting, _| {
        let x = &mut state.states[0];
        let none = &mut DMatrix::zeros(x.len(), 0);
        let held = &family.signature.stages[0].held;
        shooting.motion.flow(held, (begin, begin + late), x, none)
    })?;
    state.times = vec![begin + late, begin + late + whole];
    state.starts = vec![begin + late];
    family.place(&scene, place.value, state)
}

/// A loop in which a stop is let go where it pulls, near a time, and landed on after three times as long as it had risen; none where it does
/// not pull, other stops are held beside one that bounces, or the landing throws the motion off another one.
pub(super) fn with_flight<'a>(
    family: &Family<'a>,
    place: &Place,
    (stop, time): (usize, f64),
) -> Result<Option<(Family<'a>, Place)>> {
    // A motion that is held for good begins anywhere: half a period before.
    let turned = if family.is_empty() {
        Some(begun_before(family, place, time)?)
    } else {
        None
    };
    let (place, time) = turned
        .as_ref()
        .map_or((place, time), |there| (there, 0.5 * period(&there.state)));
    let Some(pull) = strongest_pull(family, place, (stop, time))? else {
        return Ok(None);
    };
    let state = &place.state;
    let mut instants = family.instants(state);
    let (from, end) = (
        instants[pull.instant].clone(),
        state.times[pull.instant + 1],
    );
    let scene = family.scene(place.value)?;
    let restitution = contacts(&scene)[stop].restitution;
    let without = from.stage.held_but(stop);
    let is_alone = restitution == 0.0 || without.is_empty();
    if !(pull.most > 0.0 && pull.bend > 0.0 && is_alone) {
        return Ok(None);
    }
    let quarter = (2.0 * pull.most / pull.bend).sqrt();
    let (left, back) = (pull.time - quarter, pull.time + 3.0 * quarter);
    // What accumulates behind it takes four thirds of e/(1 - e) as long.
    let rest = 4.0 / 3.0 * quarter * restitution / (1.0 - restitution);
    if !(from.start < left && back + rest < end) {
        return Ok(None);
    }
    let held_at = |t: f64| -> Result<DVector<f64>> {
        let mut x = from.state.clone();
        with_shooting(&scene, &family.signature, |shooting, _| {
            let none = &mut DMatrix::zeros(x.len(), 0);
            let held = &from.stage.held;
            shooting.motion.flow(held, (from.start, t), &mut x, none)
        })?;
        Ok(x)
    };
    let landing = if restitution > 0.0 {
        Event::Chatter(stop)
    } else {
        let landed = held_at(back)?;
        let law = with_shooting(&scene, &family.signature, |shooting, _| {
            held_through(shooting.motion, (stop, &without), back, &landed)
        })?;
        if !law.thrown.is_empty() {
            return Ok(None);
        }
        Event::Strike(law.struck)
    };
    let instant =
        |(event, held): (Event, &[usize]), (time, start): (f64, f64)| -> Result<Instant> {
            Ok(Instant {
                stage: ContactStage {
                    event,
                    held: held.to_vec(),
                },
                time,
                start,
                state: held_at(start)?,
            })
        };
    let both = [
        instant((Event::Release(stop), &without), (left, left))?,
        instant((landing, &from.stage.held), (back, back + rest))?,
    ];
    let instants = if family.is_empty() {
        // Held for good so far: the period begins with the landing.
        begun_with_strike(both.to_vec(), period(state)).unwrap_or_default()
    } else {
        let behind = pull.instant + 1;
        instants.splice(behind..behind, both);
        instants
    };
    if instants.is_empty() {
        // Impacts that accumulate begin no period.
        return Ok(None);
    }
    let length = (period(state), family.signature.n_periods);
    family
        .with_instants(place.value, instants, length)
        .map(Some)
}

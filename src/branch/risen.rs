//! The motion behind a rise (theory 19, "Rise"): where the force of a contact comes to zero and would pull, the stop is let go and landed on
//! again.

use crate::branch::candidate::Candidate;
use crate::branch::corrector::directions;
use crate::branch::equations::Foot;
use crate::branch::family::Family;
use crate::branch::instants::{Instant, period};
use crate::branch::place::{Direction, Place};
use crate::branch::special::Special;
use crate::branch::step::{Target, step_to};
use crate::error::Result;
use crate::model::contacts;
use crate::orbit::{ContactStage, Event, Signature, with_shooting};
use nalgebra::{DMatrix, DVector};

/// How far behind the boundary it is looked for at first, in arclength, and how often half as far.
const BEHIND: f64 = 1e-2;
const MOST_HALVINGS: usize = 8;
/// The part of the contact about the time of the rise in which the force is least.
const ABOUT: f64 = 0.2;
/// Parts in which that is looked at first, and narrowings of three of them.
const PARTS: usize = 32;
const NARROWINGS: usize = 8;

/// The orbit behind a rise.
pub(super) fn risen(
    family: &Family<'_>,
    place: &Place,
    special: &Special,
    (stop, time): (usize, f64),
) -> Result<Option<Candidate>> {
    let equations = family.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    let ahead = Direction::of(&special.direction);
    let same = tangent.loop_part.len() == ahead.loop_part.len();
    let sign = if same {
        tangent.dot(&ahead)
    } else {
        tangent.value_part * ahead.value_part
    };
    let tangent = &tangent.scaled(if sign < 0.0 { -1.0 } else { 1.0 });
    let mut length = BEHIND;
    for _ in 0..MOST_HALVINGS {
        let from: Foot<'_> = (place, &equations, tangent);
        if let Ok(behind) = step_to(family, from, Target::Length(length))?
            && let Some((other, at)) = with_flight(family, &behind.place, (stop, time))?
        {
            let by_value = Direction::of_value(other.n_unknowns(&at));
            if let Ok(settled) = other.corrected(at, &by_value)? {
                return Candidate::at(&other, &settled.place, special.parameter).map(Some);
            }
        }
        length *= 0.5;
    }
    Ok(None)
}

/// A loop in which a stop is let go where it pulls, near a time, and landed on after three times as long as it had risen; none where it does
/// not pull, or other stops are held by an impact that takes not all speed.
fn with_flight<'a>(
    family: &Family<'a>,
    place: &Place,
    (stop, time): (usize, f64),
) -> Result<Option<(Family<'a>, Place)>> {
    let state = &place.state;
    let mut instants = family.instants(state);
    let about = state.times[0] + time.rem_euclid(period(state));
    let Some(k) = instants.iter().rposition(|own| own.start <= about) else {
        return Ok(None);
    };
    let (from, end) = (instants[k].clone(), state.times[k + 1]);
    let held = from.stage.held.clone();
    let without: Vec<usize> = held.iter().copied().filter(|own| *own != stop).collect();
    let scene = family.scene(place.value)?;
    let restitution = contacts(&scene)[stop].restitution;
    if without.len() == held.len() || restitution > 0.0 && !without.is_empty() {
        return Ok(None);
    }
    let landing = if restitution > 0.0 {
        Event::Chatter(stop)
    } else {
        Event::Strike(vec![stop])
    };
    let stage = |event: Event, held: &[usize]| ContactStage {
        event,
        held: held.to_vec(),
    };
    let let_go = stage(Event::Release(stop), &without);
    let landed = stage(landing, &held);
    let mut stages = family.signature.stages.clone();
    stages.splice((k + 1)..=k, [let_go.clone(), landed.clone()]);
    let signature = Signature {
        stages,
        ..family.signature.clone()
    };
    let found = with_shooting(&scene, &signature, |shooting, _| {
        let held_at = |t: f64| -> Result<DVector<f64>> {
            let mut x = from.state.clone();
            let none = &mut DMatrix::zeros(x.len(), 0);
            shooting.motion.flow(&held, (from.start, t), &mut x, none)?;
            Ok(x)
        };
        // How fast the stop would be left.
        let pull = |t: f64| -> Result<f64> {
            let x = held_at(t)?;
            let rate = shooting.motion.rate(&without, t, &x)?;
            shooting.motion.gap_acceleration(stop, t, &x, &rate)
        };
        let half = ABOUT * (end - from.start);
        let (mut low, mut high) = ((about - half).max(from.start), (about + half).min(end));
        let mut top = (about, f64::NEG_INFINITY);
        for _ in 0..NARROWINGS {
            let step = (high - low) / PARTS as f64;
            for i in 1..PARTS {
                let t = low + step * i as f64;
                let own = pull(t)?;
                if own > top.1 {
                    top = (t, own);
                }
            }
            (low, high) = (top.0 - step, top.0 + step);
        }
        let (t, most) = top;
        // The curvature over a part of the contact that rounding leaves alone.
        let step = 1e-3 * (end - from.start);
        let bend = (2.0 * most - pull(t - step)? - pull(t + step)?) / (step * step);
        if !(most > 0.0 && bend > 0.0) {
            return Ok(None);
        }
        let quarter = (2.0 * most / bend).sqrt();
        let (left, back) = (t - quarter, t + 3.0 * quarter);
        // What accumulates behind it takes four thirds of e/(1 - e) as long.
        let rest = 4.0 / 3.0 * quarter * restitution / (1.0 - restitution);
        if !(from.start < left && back + rest < end) {
            return Ok(None);
        }
        let left = Instant {
            stage: let_go.clone(),
            time: left,
            start: left,
            state: held_at(left)?,
        };
        let back = Instant {
            stage: landed.clone(),
            time: back,
            start: back + rest,
            state: held_at(back + rest)?,
        };
        Ok(Some([left, back]))
    })?;
    let Some(both) = found else {
        return Ok(None);
    };
    instants.splice((k + 1)..=k, both);
    let length = (period(state), family.signature.n_periods);
    family
        .with_instants(place.value, instants, length)
        .map(Some)
}

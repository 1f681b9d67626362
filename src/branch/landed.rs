//! The motion behind a landing border (theory 19, "Landing"): behind an impact that takes all speed the stop is held for a while where it was
//! left, or left for a while where it was held.

use crate::branch::family::Family;
use crate::branch::instants::{Instant, rebuilt};
use crate::branch::place::Place;
use crate::error::Result;
use crate::hybrid::held_through;
use crate::orbit::{ContactStage, Event, with_shooting};
use nalgebra::DMatrix;

/// The step of the rate of an acceleration, in parts of the time to the next instant.
const STEP: f64 = 1e-4;

/// A loop in which a stop that was left behind an impact near a time is held until the forces let it go, or one that was held is left until
/// it is landed on again; none where its forces ask for neither, or the landing throws the motion off another stop.
pub(super) fn with_change<'a>(
    family: &Family<'a>,
    place: &Place,
    (stop, time): (usize, f64),
) -> Result<Option<(Family<'a>, Place)>> {
    let state = &place.state;
    let Some(k) = family.instant_of(place, (stop, state.times[0] + time)) else {
        return Ok(None);
    };
    let mut instants = family.instants(state);
    let (own, end) = (instants[k].clone(), state.times[k + 1]);
    let was_held = own.stage.held.contains(&stop);
    let without = own.stage.held_but(stop);
    let mut held = without.clone();
    held.push(stop);
    held.sort_unstable();
    // What holds at first behind the border, and what after that.
    let (begins, goes_on) = if was_held {
        (without.clone(), held.clone())
    } else {
        (held.clone(), without.clone())
    };
    instants[k].stage.held.clone_from(&begins);
    let mut signature = family.signature.clone();
    signature.stages[k].held.clone_from(&begins);
    signature.stages.push(ContactStage {
        event: Event::Release(stop),
        held: goes_on.clone(),
    });
    let scene = family.scene(place.value)?;
    let found = with_shooting(&scene, &signature, |shooting, _| {
        let motion = shooting.motion;
        // How fast the stop would be left behind some of its being held.
        let pull = |t: f64| -> Result<f64> {
            let mut x = own.state.clone();
            let none = &mut DMatrix::zeros(x.len(), 0);
            motion.flow(&held, (own.time, t), &mut x, none)?;
            let rate = motion.rate(&without, t, &x)?;
            motion.gap_acceleration(stop, t, &x, &rate)
        };
        let step = STEP * (end - own.time);
        let opening = pull(own.time)?;
        let rate = (pull(own.time + step)? - opening) / step;
        // Held until it is zero; left until its cube is.
        let length = if was_held { -3.0 } else { -1.0 } * opening / rate;
        let asks = if was_held {
            opening > 0.0
        } else {
            opening < 0.0
        };
        if !(asks && length > 0.0 && own.time + length < end) {
            return Ok(None);
        }
        let until = own.time + length;
        let mut x = own.state.clone();
        let none = &mut DMatrix::zeros(x.len(), 0);
        motion.flow(&begins, (own.time, until), &mut x, none)?;
        let event = if was_held {
            let law = held_through(motion, (stop, &begins), until, &x)?;
            if !law.thrown.is_empty() {
                return Ok(None);
            }
            motion.impact(&law.struck, until, &mut x, none)?;
            Event::Strike(law.struck)
        } else {
            Event::Release(stop)
        };
        Ok(Some(Instant {
            stage: ContactStage {
                event,
                held: goes_on.clone(),
            },
            time: until,
            start: until,
            state: x,
        }))
    })?;
    let Some(new) = found else {
        return Ok(None);
    };
    instants.insert(k + 1, new);
    rebuilt(family, place, instants)
}

//! The motion beyond a landing border (theory 19, "Landing"): after an impact with e = 0 the stop is held for a while where it was left at
//! once, or left for a while where it was held at once.

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::rebuilt;
use crate::error::Result;
use crate::hybrid::{ImpactOutcome, carried, impact_outcome, reset};
use crate::itinerary::Instant;
use crate::law::{ElementState, Stage};
use crate::orbit::with_maps;
use crate::tolerance::LANDING_RATE_STEP;

/// A loop in which a stop that was left after an impact near a time is held until its force is zero, or one that was held is left until it
/// is landed on again. None where its acceleration asks for neither, or the landing throws the motion off another stop.
pub(super) fn with_landing_change<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    (stop, time): (usize, f64),
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    let state = &place.state;
    let Some(k) = problem.instant_of(place, (stop, state.times[0] + time)) else {
        return Ok(None);
    };
    let mut instants = problem.instants(state);
    let (own, end) = (instants[k].clone(), state.times[k + 1]);
    let was_held = own.stage.regime.holds(stop);
    let without = own.stage.regime.without(stop);
    let held = without.with(stop, ElementState::Held);
    // The regime at first beyond the border, and the one after that.
    let (begins, goes_on) = if was_held {
        (without.clone(), held.clone())
    } else {
        (held.clone(), without.clone())
    };
    instants[k].stage.regime.clone_from(&begins);
    let signature = problem.signature.clone().beside(&begins).beside(&goes_on);
    let scene = problem.scene(place.value)?;
    let found = with_maps(&scene, &signature, |motion| {
        // The acceleration with which the stop would be left after it was held until a time.
        let pull = |t: f64| -> Result<f64> {
            let x = carried(motion, &held, (own.time, t), &own.state)?;
            let rate = motion.rate(&without, t, &x)?;
            motion.gap_acceleration(stop, t, &x, &rate)
        };
        let step = LANDING_RATE_STEP * (end - own.time);
        let opening = pull(own.time)?;
        let rate = (pull(own.time + step)? - opening) / step;
        // It is held until that acceleration is zero; or left until the gap, which goes by its integrals, is zero again.
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
        let x = carried(motion, &begins, (own.time, until), &own.state)?;
        let stage = if was_held {
            let ImpactOutcome { transition, thrown } =
                impact_outcome(motion, (stop, &begins), until, &x)?;
            if !thrown.is_empty() {
                return Ok(None);
            }
            Stage {
                transition,
                regime: goes_on.clone(),
            }
        } else {
            Stage::departure(stop, goes_on.clone())
        };
        Ok(Some(Instant {
            state: reset(motion, &stage.transition, until, x)?,
            stage,
            time: until,
            start: until,
        }))
    })?;
    let Some(new) = found else {
        return Ok(None);
    };
    instants.insert(k + 1, new);
    rebuilt(problem, place, instants)
}

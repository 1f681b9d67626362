//! The onset of a release within lasting contact (theory 19, "Rise"): where the contact force comes to zero and would pull, the stop is let
//! go and landed on again a little later. Times in \[s\], accelerations in \[m/s^2\].

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::period;
use crate::error::Result;
use crate::hybrid::{carried, landing_on};
use crate::itinerary::{Instant, begun_with_impact};
use crate::law::Stage;
use crate::model::contacts;
use crate::orbit::with_maps;
use crate::tolerance::{ONSET_CURVATURE_STEP, RELEASE_ONSET_WINDOW, SAME_ROUND};

/// Parts in which a span of time is searched for the largest acceleration. `[work]`
const ONSET_SAMPLES: usize = 32;
/// Narrowings of the span to the two parts beside the largest. `[work]`
const ONSET_NARROWINGS: usize = 8;

/// Where the contact force of a held stop is least: where the motion would leave it first.
pub(super) struct ReleaseOnset {
    /// The instant from which the stop is held.
    instant: usize,
    time: f64,
    /// The acceleration with which the stop would be left \[m/s^2\], above zero where the contact would pull.
    pub most: f64,
    /// Minus the second derivative of that over time \[m/s^4\].
    bend: f64,
}

/// The onset of a release of a held stop near a time; none where the stop is not held.
pub(super) fn release_onset(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    (stop, time): (usize, f64),
) -> Result<Option<ReleaseOnset>> {
    let state = &place.state;
    let instants = problem.instants(state);
    let count = instants.len();
    let mut about = state.times[0] + time.rem_euclid(period(state));
    let Some(mut instant) = instants.iter().rposition(|own| own.start <= about) else {
        return Ok(None);
    };
    // A time at the end of a contact may be found to be in the flight that follows.
    let late = about - instants[instant].start;
    if !instants[instant].stage.regime.holds(stop) && late <= SAME_ROUND * period(state) {
        instant = (instant + count - 1) % count;
        about = state.times[instant + 1];
    }
    let (from, end) = (&instants[instant], state.times[instant + 1]);
    if !from.stage.regime.holds(stop) {
        return Ok(None);
    }
    let without = from.stage.regime.without(stop);
    // The ends of the contact count where another stop's impact makes them. At the landing on this stop the border is another one, and at
    // its release the force is zero.
    let next = &instants[(instant + 1) % count].stage.transition;
    let is_release = next.is_release() && next.element() == Some(stop);
    let was_held = instants[(instant + count - 1) % count]
        .stage
        .regime
        .holds(stop);
    let parts = usize::from(!was_held)..ONSET_SAMPLES + usize::from(!is_release);
    let scene = problem.scene(place.value)?;
    let signature = problem.signature.clone().beside(&without);
    with_maps(&scene, &signature, |motion| {
        let pull = |t: f64| -> Result<f64> {
            let x = carried(motion, &from.stage.regime, (from.start, t), &from.state)?;
            let rate = motion.rate(&without, t, &x)?;
            motion.gap_acceleration(stop, t, &x, &rate)
        };
        let half = RELEASE_ONSET_WINDOW * (end - from.start);
        let (mut low, mut high) = ((about - half).max(from.start), (about + half).min(end));
        let mut top = (about, f64::NEG_INFINITY);
        for _ in 0..ONSET_NARROWINGS {
            let step = (high - low) / ONSET_SAMPLES as f64;
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
        // The second difference over a part of the contact that is long enough for rounding.
        let step = ONSET_CURVATURE_STEP * (end - from.start);
        let bend = (2.0 * most - pull(time - step)? - pull(time + step)?) / (step * step);
        Ok(Some(ReleaseOnset {
            instant,
            time,
            most,
            bend,
        }))
    })
}

/// A loop in which nothing happens, begun half a period before a time.
fn begun_before(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    time: f64,
) -> Result<ParametricLoop> {
    let whole = period(&place.state);
    let mut state = place.state.clone();
    let begin = state.times[0];
    let late = (time - 0.5 * whole).rem_euclid(whole);
    let scene = problem.scene(place.value)?;
    state.states[0] = with_maps(&scene, &problem.signature, |motion| {
        let regime = &problem.signature.stages[0].regime;
        let span = (begin, begin + late);
        carried(motion, regime, span, &state.states[0])
    })?;
    state.times = vec![begin + late, begin + late + whole];
    state.starts = vec![begin + late];
    problem.place(&scene, place.value, state)
}

/// A loop in which a stop is let go near a time, where its contact would pull, and landed on again after three times as long as it had
/// risen. None where it would not pull, where a stop with restitution is held beside others, or where the landing throws the motion off
/// another stop.
pub(super) fn with_flight<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    (stop, time): (usize, f64),
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    // A motion in lasting contact all period long has no first instant: it begins half a period before.
    let turned = if problem.is_empty() {
        Some(begun_before(problem, place, time)?)
    } else {
        None
    };
    let (place, time) = turned
        .as_ref()
        .map_or((place, time), |there| (there, 0.5 * period(&there.state)));
    let Some(pull) = release_onset(problem, place, (stop, time))? else {
        return Ok(None);
    };
    let state = &place.state;
    let mut instants = problem.instants(state);
    let (from, end) = (
        instants[pull.instant].clone(),
        state.times[pull.instant + 1],
    );
    let scene = problem.scene(place.value)?;
    let impact = contacts(&scene)[stop].law();
    let without = from.stage.regime.without(stop);
    let is_alone = impact.is_inelastic() || without.is_free();
    if !(pull.most > 0.0 && pull.bend > 0.0 && is_alone) {
        return Ok(None);
    }
    let quarter = (2.0 * pull.most / pull.bend).sqrt();
    let (left, back) = (pull.time - quarter, pull.time + 3.0 * quarter);
    // The impacts that accumulate after the landing take 4/3 e/(1 - e) times as long.
    let rest = 4.0 / 3.0 * quarter * impact.restitution / (1.0 - impact.restitution);
    if !(from.start < left && back + rest < end) {
        return Ok(None);
    }
    let held_at = |t: f64| {
        with_maps(&scene, &problem.signature, |motion| {
            let regime = &from.stage.regime;
            carried(motion, regime, (from.start, t), &from.state)
        })
    };
    let landed = held_at(back)?;
    let landing = with_maps(&scene, &problem.signature, |motion| {
        landing_on(motion, (stop, &without), back, &landed)
    })?;
    let Some(landing) = landing else {
        return Ok(None);
    };
    let instant = |stage: Stage, (time, start): (f64, f64)| -> Result<Instant> {
        Ok(Instant {
            stage,
            time,
            start,
            state: held_at(start)?,
        })
    };
    let landing = Stage {
        transition: landing,
        regime: from.stage.regime.clone(),
    };
    let both = [
        instant(Stage::departure(stop, without.clone()), (left, left))?,
        instant(landing, (back, back + rest))?,
    ];
    let instants = if problem.is_empty() {
        // The motion was in lasting contact all period long: the period begins with the landing now.
        begun_with_impact(both.to_vec(), period(state)).unwrap_or_default()
    } else {
        let next = pull.instant + 1;
        instants.splice(next..next, both);
        instants
    };
    if instants.is_empty() {
        // A period cannot begin with impacts that accumulate.
        return Ok(None);
    }
    let length = (period(state), problem.signature.n_periods);
    problem
        .with_instants(place.value, instants, length)
        .map(Some)
}

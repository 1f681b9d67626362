//! A guess for an orbit of a given pattern: from a state on, each stop of the pattern is waited for in its order, and all other stops are
//! passed through.

use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::hybrid::{halves, joined};
use crate::impact::wrapped;
use crate::itinerary::{Instant, Itinerary};
use crate::law::Stage;
use crate::model::{Change, Scene};

use crate::orbit::pattern::Pattern;
use crate::orbit::shooting::guess::{Guess, Start, period_of_state, started};
use crate::orbit::shooting::guess_by_signature::instants_of_signature;
use crate::orbit::shooting::own_time::with_phase;
use crate::orbit::shooting::signature::{Signature, with_shooting};
use crate::path::{ImpactSide, KeptMotion, Motion};
use crate::simulate::{SimulateOptions, simulate};
use crate::tolerance::GUESS_RUN_PERIODS;
use nalgebra::{DMatrix, DVector};

/// What is to come from a guess on, in its order.
pub(super) enum ToCome<'a> {
    /// Impacts on the stops of a pattern.
    Impacts(&'a Pattern),
    /// The events of a signature.
    Events(&'a [(String, usize)]),
}

/// The start that a guess is if its stops are those of a pattern, or its events those of a signature, in their order: from the state itself,
/// from the end of a trajectory, from the middle of the last flight of an orbit.
pub(super) fn start_in_order(
    guess: Guess<'_>,
    scene: &Scene,
    n_periods: Option<usize>,
    to_come: &ToCome<'_>,
) -> Result<Start> {
    let at_phase = |phase: f64| with_phase(scene, phase, false);
    let (scene, (q, v), once, given) = match guess {
        Guess::State { q, v, period } => (scene.clone(), (q.clone(), v.clone()), 1, period),
        Guess::Trajectory(run) => {
            let (_, end) = run.span();
            let state = run.state(end, ImpactSide::After)?;
            if scene.frequency().is_none() {
                let rule = "without forcing its period is not known; give a state (q0, v0, period)";
                return Err(Error::bad_value("guess", "a trajectory", rule));
            }
            (at_phase(run.forcing_phase()(end))?, state, 1, None)
        }
        Guess::Orbit(orbit) => {
            let last = orbit.flights().last().map_or(0.0, |flight| flight.start);
            let t = 0.5 * (last + orbit.period());
            let turned = orbit.scene().frequency().map_or(0.0, |w| w * t);
            let period = scene.frequency().is_none().then(|| orbit.period());
            let scene = at_phase(orbit.phase() + turned)?;
            (
                scene,
                orbit.state_at(t, ImpactSide::After),
                orbit.n_periods(),
                period,
            )
        }
    };
    let n_periods = n_periods.unwrap_or(once);
    let forced = scene.period().map(|once| once * n_periods as f64);
    let period = period_of_state(forced, given)?;
    let instants = match to_come {
        ToCome::Impacts(pattern) => {
            pattern.check(scene.stops().len())?;
            instants_in_order(&scene, (q, v), pattern, period)?
        }
        ToCome::Events(events) => instants_of_signature(&scene, &joined(&(q, v)), events, period)?,
    };
    let turned = scene.frequency().unwrap_or(0.0) * instants[0].time;
    let phase = wrapped(turned + scene.phase());
    Ok(started(instants, n_periods, phase, period))
}

/// The impacts on the stops of a pattern, each the first on its stop after the one before.
fn instants_in_order(
    scene: &Scene,
    (mut q, mut v): (DVector<f64>, DVector<f64>),
    pattern: &Pattern,
    period: f64,
) -> Result<Vec<Instant>> {
    let signature = Signature {
        stages: Itinerary::of_impacts(pattern.instants()),
        n_periods: 1,
        depends_on_time: false,
        units: ScaledUnits::of(std::iter::once(&joined(&(q.clone(), v.clone()))), period),
        images: None,
    };
    let options = SimulateOptions {
        max_impacts: Some(1),
        ..SimulateOptions::default()
    };
    let mut found: Vec<Instant> = Vec::new();
    with_shooting(scene, &signature, |shooting, _| {
        let mut time = 0.0;
        for (k, stops) in pattern.instants().iter().enumerate() {
            // They are hit together where the first of them is.
            let own = stops.iter().map(|&stop| scene.stops()[stop].clone());
            let looked_at = scene.replace(Change::Stops(own.collect()))?;
            let span = (time, time + GUESS_RUN_PERIODS * period);
            let refused = |what: &str| {
                let rule = format!("from the guess stop {} is {what}", stops[0]);
                Error::bad_value(format!("pattern[{k}]"), format!("{stops:?}"), rule)
            };
            let run = match simulate(&looked_at, &q, &v, span, &options) {
                Err(Error::BadValue { argument, .. }) if argument == "q0" => {
                    return Err(refused(
                        "to be reached from outside, but that lies behind it",
                    ));
                }
                run => run?,
            };
            let first = found.first().map_or(f64::INFINITY, |first| first.time);
            let hit = run.impacts().first();
            let hit = hit.filter(|hit| hit.time < first + period).ok_or_else(|| {
                refused("not hit within a period: the stops of a pattern are hit in its order")
            })?;
            time = hit.time;
            let mut state = joined(&run.state(time, ImpactSide::Before)?);
            let none = &mut DMatrix::zeros(state.len(), 0);
            shooting.motion.impact(stops, time, &mut state, none)?;
            (q, v) = halves(&state);
            found.push(Instant {
                time,
                start: time,
                stage: Stage::impact(stops),
                state,
            });
        }
        Ok(())
    })?;
    if found.is_empty() {
        found.push(Instant {
            time: 0.0,
            start: 0.0,
            stage: Stage::impact(&[]),
            state: joined(&(q, v)),
        });
    }
    Ok(found)
}

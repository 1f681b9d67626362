//! The instants of a trajectory, and of an orbit: impacts, and where contact lasts the landings and departures.

use crate::error::Result;
use crate::hybrid::joined;
use crate::impact::Impact;
use crate::itinerary::arc::MotionArc;
use crate::itinerary::compliant_states::CompliantStates;
use crate::itinerary::instant::Instant;
use crate::itinerary::list::unsupported;
use crate::law::{Regime, Stage, Transition};
use crate::model::{Scene, contacts};
use crate::path::{ImpactSide, KeptMotion, Motion, Stretch};
use crate::simulate::Trajectory;
use nalgebra::DVector;

/// An instant that was read off a motion.
#[derive(Debug, Clone)]
pub(crate) struct ReadInstant {
    pub instant: Instant,
    /// The phase of the forcing at it \[rad\]; zero on an orbit, which has a phase of its own.
    pub phase: f64,
    /// The approach speed of its impact \[m/s\], zero without one.
    pub approach: f64,
}

/// The instants of a trajectory.
pub(crate) fn instants_of(trajectory: &Trajectory) -> Result<Vec<ReadInstant>> {
    let stretches = trajectory.stretches()?;
    if stretches.iter().all(|stretch| stretch.regime.is_free()) {
        impacts(trajectory)
    } else {
        lasting(trajectory)
    }
}

/// The impacts of a trajectory without lasting contact.
fn impacts(trajectory: &Trajectory) -> Result<Vec<ReadInstant>> {
    let mut found: Vec<ReadInstant> = Vec::new();
    for &Impact {
        time,
        stop,
        phase,
        approach,
        ..
    } in trajectory.impacts()
    {
        if let Some(ReadInstant { instant, .. }) = found.last_mut()
            && instant.time == time
            && let Transition::Strike(stops) = &mut instant.stage.transition
            && !stops.contains(&stop)
        {
            stops.push(stop);
            continue;
        }
        let stage = Stage::free(Transition::Strike(vec![stop]));
        let instant = instant_at(trajectory, stage, (time, time))?;
        found.push(ReadInstant {
            instant,
            phase,
            approach,
        });
    }
    Ok(found)
}

/// The instant of a trajectory at a time, after which an arc starts.
fn instant_at(trajectory: &Trajectory, stage: Stage, (time, start): (f64, f64)) -> Result<Instant> {
    Ok(Instant {
        stage,
        time,
        start,
        state: joined(&trajectory.state(start, ImpactSide::After)?),
    })
}

/// The instants of a trajectory with lasting contact, segment by segment.
fn lasting(trajectory: &Trajectory) -> Result<Vec<ReadInstant>> {
    let phase_at = trajectory.forcing_phase();
    let stretches = trajectory.stretches()?;
    let is_part = |s: &&Stretch<'_>| s.end > s.start || s.accumulation().is_some();
    let parts = stretches.iter().filter(is_part);
    let mut impacts = trajectory.impacts().iter().peekable();
    let mut found = Vec::new();
    let (mut chatter, mut before): (Option<(usize, f64)>, &[usize]) = (None, &[]);
    let mut states = CompliantStates::new(trajectory.scene());
    for part in parts {
        let (start, stops) = (part.start, part.stops());
        let slack = 4.0 * f64::EPSILON * start.abs();
        let (mut struck, mut approach) = (Vec::new(), 0.0f64);
        while let Some(impact) = impacts.next_if(|impact| impact.time <= start + slack) {
            if impact.time >= start - slack && !struck.contains(&impact.stop) {
                struck.push(impact.stop);
                approach = approach.max(impact.approach);
            }
        }
        if let Some(stop) = part.accumulation() {
            chatter = Some((stop, start));
            before = &[];
            continue;
        }
        let released: Vec<usize> = before
            .iter()
            .copied()
            .filter(|stop| !stops.contains(stop))
            .collect();
        let changed = states.take(part.regime);
        let (time, transition) = match (chatter.take(), struck.is_empty(), released.as_slice()) {
            (Some((stop, time)), ..) if stops == [stop] => (time, Transition::Chatter(stop)),
            (chatter, is_alone, released) if !changed.is_empty() => {
                let is_alone = is_alone && chatter.is_none() && released.is_empty();
                (start, states.transition(&changed, is_alone, start)?)
            }
            (None, false, _) => (start, Transition::Strike(struck)),
            (None, true, &[stop]) => (start, Transition::Release(stop)),
            (None, true, &[]) => (start, Transition::Nothing),
            (None, true, _) => {
                return Err(unsupported("stops that are let go at one time", start));
            }
            (Some((stop, time)), ..) if stops.contains(&stop) => {
                let what =
                    format!("impacts whose bouncing comes to rest on stop {stop} beside others");
                return Err(unsupported(&what, time));
            }
            (Some(_), ..) => {
                return Err(unsupported("accumulating impacts without rest", start));
            }
        };
        if !transition.is_nothing() {
            let stage = Stage {
                transition,
                regime: part.regime.clone(),
            };
            found.push(ReadInstant {
                instant: instant_at(trajectory, stage, (time, start))?,
                phase: phase_at(time),
                approach,
            });
        }
        before = stops;
    }
    Ok(found)
}

/// The instant at the end of a trajectory along which nothing happens.
pub(crate) fn uneventful_end(trajectory: &Trajectory, regime: &Regime) -> Result<ReadInstant> {
    let (_, end) = trajectory.span();
    let stage = Stage::uneventful(regime.clone());
    Ok(ReadInstant {
        instant: instant_at(trajectory, stage, (end, end))?,
        phase: trajectory.forcing_phase()(end),
        approach: 0.0,
    })
}

/// The instants of a period of arcs with some impacts, of which accumulating ones are one by one; with the state at a time.
pub(crate) fn instants_of_arcs<S>(
    arcs: &[MotionArc<S>],
    impacts: &[Impact],
    state: impl Fn(f64) -> DVector<f64>,
) -> Vec<ReadInstant> {
    let mut impacts = impacts.iter();
    let mut found = Vec::new();
    let mut chatter = None;
    for arc in arcs {
        if let Some(stop) = arc.accumulation() {
            chatter = Some((arc.start, Transition::Chatter(stop)));
            continue;
        }
        let usual = (arc.start, arc.stage.transition.clone());
        let (time, transition) = chatter.take().unwrap_or(usual);
        let speeds = impacts.by_ref().take(arc.hits().len());
        let stage = Stage {
            transition,
            regime: arc.regime().clone(),
        };
        found.push(ReadInstant {
            instant: Instant {
                stage,
                time,
                start: arc.start,
                state: state(arc.start),
            },
            phase: 0.0,
            approach: speeds.map(|impact| impact.approach).fold(0.0, f64::max),
        });
    }
    found
}

/// Instants whose last impacts before an accumulation are part of it, as far back as their speeds go by the ratio e.
pub(crate) fn folded(instants: Vec<ReadInstant>, scene: &Scene) -> Vec<ReadInstant> {
    let contacts = contacts(scene);
    let mut kept: Vec<ReadInstant> = Vec::with_capacity(instants.len());
    for mut read in instants {
        if let Transition::Chatter(stop) = read.instant.stage.transition {
            let law = contacts[stop].law();
            let bounce = Stage::free(Transition::Strike(vec![stop]));
            let is_bounce = |own: &ReadInstant| own.instant.stage == bounce;
            while let [.., before, last] = kept.as_slice() {
                let is_repeated = law.is_repeated(before.approach, last.approach);
                if !(is_bounce(before) && is_bounce(last) && is_repeated) {
                    break;
                }
                read.instant.time = last.instant.time;
                kept.pop();
            }
        }
        kept.push(read);
    }
    kept
}

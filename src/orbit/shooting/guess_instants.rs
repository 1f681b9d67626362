//! What happens along a trajectory, instant by instant: its impacts, and where contact lasts the landings and releases.

use crate::error::{Error, Result};
use crate::hybrid::{SegmentKind, joined};
use crate::impact::Impact;
use crate::law::{Stage, Transition};
use crate::path::Stretch;
use crate::simulate::{ImpactSide, Trajectory};
use nalgebra::DVector;

/// An instant of a motion: what happens at one time, and the state after it.
#[derive(Debug, Clone)]
pub(crate) struct Instant {
    pub time: f64,
    /// The start of the flight after it [s], at which `state` is taken.
    pub start: f64,
    pub phase: f64,
    pub stage: Stage,
    /// The approach speed of an impact.
    pub approach: f64,
    /// The state (q, v) at `start`, shape (2n,), [m, m/s].
    pub state: DVector<f64>,
}

/// The instants of a trajectory.
pub(crate) fn instants_of(trajectory: &Trajectory) -> Result<Vec<Instant>> {
    let stretches = trajectory.stretches()?;
    let mut kinds = stretches.iter().map(|stretch| stretch.kind);
    if kinds.any(|kind| kind != SegmentKind::Flight) {
        lasting(trajectory)
    } else {
        impacts(trajectory)
    }
}

/// The impacts of a trajectory without lasting contact.
fn impacts(trajectory: &Trajectory) -> Result<Vec<Instant>> {
    let mut found: Vec<Instant> = Vec::new();
    for &Impact {
        time,
        stop,
        phase,
        approach,
        ..
    } in trajectory.impacts()
    {
        if let Some(last) = found.last_mut().filter(|last| last.time == time)
            && let Transition::Strike(stops) = &mut last.stage.transition
            && !stops.contains(&stop)
        {
            stops.push(stop);
            continue;
        }
        found.push(Instant {
            time,
            start: time,
            phase,
            stage: Stage::free(Transition::Strike(vec![stop])),
            approach,
            state: joined(&trajectory.state(time, ImpactSide::After)?),
        });
    }
    Ok(found)
}

/// The instants of a trajectory with lasting contact, segment by segment.
fn lasting(trajectory: &Trajectory) -> Result<Vec<Instant>> {
    let phase_at = trajectory.forcing_phase();
    let stretches = trajectory.stretches()?;
    let is_part = |s: &&Stretch<'_>| s.end > s.start || s.is_chatter();
    let parts = stretches.iter().filter(is_part);
    let mut impacts = trajectory.impacts().iter().peekable();
    let mut found = Vec::new();
    let (mut chatter, mut before): (Option<(usize, f64)>, &[usize]) = (None, &[]);
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
        if part.is_chatter() {
            chatter = Some((stops[0], start));
            before = &[];
            continue;
        }
        let released: Vec<usize> = before
            .iter()
            .copied()
            .filter(|stop| !stops.contains(stop))
            .collect();
        let stage = |transition| Stage {
            transition,
            regime: part.regime.clone(),
        };
        let transition = match (chatter.take(), struck.is_empty(), released.as_slice()) {
            (Some((stop, time)), ..) if stops == [stop] => {
                found.push(Instant {
                    time,
                    start,
                    phase: phase_at(time),
                    stage: stage(Transition::Chatter(stop)),
                    approach,
                    state: joined(&trajectory.state(start, ImpactSide::After)?),
                });
                None
            }
            (None, false, _) => Some(Transition::Strike(struck)),
            (None, true, &[stop]) => Some(Transition::Release(stop)),
            (None, true, &[]) => None,
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
        if let Some(transition) = transition {
            found.push(Instant {
                time: start,
                start,
                phase: phase_at(start),
                stage: stage(transition),
                approach,
                state: joined(&trajectory.state(start, ImpactSide::After)?),
            });
        }
        before = stops;
    }
    Ok(found)
}

pub(in crate::orbit) fn unsupported(what: &str, time: f64) -> Error {
    let rule = "of an orbit through it there is no Jacobian";
    Error::bad_value(
        "guess",
        format!("a trajectory with {what} at t = {time}"),
        rule,
    )
}

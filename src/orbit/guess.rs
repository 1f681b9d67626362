//! What a search for a periodic motion starts from: a pattern, the times of its instants, the states after them; read off
//! another orbit, or off the end of a trajectory.

use crate::error::{Error, Result};
use crate::impact::Impact;
use crate::orbit::{Pattern, PeriodicOrbit};
use crate::simulate::{ImpactSide, Trajectory};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// A return as near as this, relative to the motion's size, is one; of a trajectory that has not settled so far the
/// nearest return is taken.
const RETURNED: f64 = 0.05;
/// Forcing periods in one period of the motion that are looked for in a trajectory.
const MOST_PERIODS: usize = 64;

/// What [`crate::find_orbit`] starts from.
#[derive(Debug, Clone, Copy)]
pub enum Guess<'a> {
    /// Another orbit: of other parameters, or of the linearised scene.
    Orbit(&'a PeriodicOrbit),
    /// A trajectory that comes near the orbit in the end; it must have kept its motion.
    Trajectory(&'a Trajectory),
}

impl<'a> From<&'a PeriodicOrbit> for Guess<'a> {
    fn from(orbit: &'a PeriodicOrbit) -> Self {
        Self::Orbit(orbit)
    }
}

impl<'a> From<&'a Trajectory> for Guess<'a> {
    fn from(trajectory: &'a Trajectory) -> Self {
        Self::Trajectory(trajectory)
    }
}

/// A guess as numbers.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub pattern: Pattern,
    /// Forcing periods in one period, 1 without forcing.
    pub n_periods: usize,
    /// The forcing phase at the first instant.
    pub phase: f64,
    /// The times of the instants, in parts of the period, the first one 0.
    pub parts: Vec<f64>,
    /// The period that the guess itself has.
    pub period: f64,
    /// The state (q, v) after each instant, or the one state of a motion without impacts.
    pub states: Vec<DVector<f64>>,
}

impl Guess<'_> {
    /// The guess as numbers, for so many forcing periods if that is given.
    pub(crate) fn read(self, frequency: Option<f64>, n_periods: Option<usize>) -> Result<Start> {
        if n_periods == Some(0) {
            return Err(Error::bad_value("n_periods", 0, "it must be at least 1"));
        }
        if let (None, Some(n)) = (frequency, n_periods) {
            let rule = "the scene has no forcing whose periods could be counted; leave it out";
            return Err(Error::bad_value("n_periods", n, rule));
        }
        match self {
            Self::Orbit(orbit) => from_orbit(orbit, n_periods),
            Self::Trajectory(trajectory) => from_trajectory(trajectory, frequency, n_periods),
        }
    }
}

fn joined((q, v): (DVector<f64>, DVector<f64>)) -> DVector<f64> {
    DVector::from_iterator(2 * q.len(), q.iter().chain(v.iter()).copied())
}

fn from_orbit(orbit: &PeriodicOrbit, n_periods: Option<usize>) -> Result<Start> {
    let once = orbit.n_periods();
    let wanted = n_periods.unwrap_or(once);
    if !wanted.is_multiple_of(once) {
        let rule =
            format!("the guess has {once} forcing periods, so it must be a multiple of that");
        return Err(Error::bad_value("n_periods", wanted, rule));
    }
    let times = wanted / once;
    let starts = orbit.flight_starts();
    let mut instants = Vec::new();
    let (mut parts, mut states) = (Vec::new(), Vec::new());
    for round in 0..times {
        instants.extend_from_slice(orbit.pattern().instants());
        for &start in &starts {
            parts.push((round as f64 + start / orbit.period()) / times as f64);
            states.push(joined(orbit.state(start, false)));
        }
    }
    if instants.is_empty() {
        (parts, states) = (vec![0.0], vec![states.swap_remove(0)]);
    }
    Ok(Start {
        pattern: Pattern::new(instants)?,
        n_periods: wanted,
        phase: orbit.phase(),
        parts,
        period: orbit.period() * times as f64,
        states,
    })
}

/// The stops hit at one time of a trajectory, and the state after.
struct Instant {
    time: f64,
    phase: f64,
    stops: Vec<usize>,
    state: DVector<f64>,
}

fn instants(trajectory: &Trajectory) -> Result<Vec<Instant>> {
    let mut found: Vec<Instant> = Vec::new();
    for &Impact {
        time, stop, phase, ..
    } in trajectory.impacts()
    {
        match found.last_mut() {
            Some(last) if last.time == time && !last.stops.contains(&stop) => last.stops.push(stop),
            _ => found.push(Instant {
                time,
                phase,
                stops: vec![stop],
                state: joined(trajectory.state(time, ImpactSide::After)?),
            }),
        }
    }
    Ok(found)
}

/// How far two instants are from being the same one a number of periods later, relative to the motion's size.
fn distance(a: &Instant, b: &Instant, lag: Option<f64>) -> f64 {
    if a.stops != b.stops {
        return f64::INFINITY;
    }
    let n = a.state.len() / 2;
    let apart = |first: usize| {
        let (x, y) = (a.state.rows(first, n), b.state.rows(first, n));
        let size = x.amax().max(y.amax());
        if size > 0.0 {
            (x - y).amax() / size
        } else {
            0.0
        }
    };
    let late = lag.map_or(0.0, |lag| ((b.time - a.time) / lag - 1.0).abs());
    apart(0).max(apart(n)).max(late)
}

fn from_trajectory(
    trajectory: &Trajectory,
    frequency: Option<f64>,
    n_periods: Option<usize>,
) -> Result<Start> {
    let all = instants(trajectory)?;
    let Some((last, earlier)) = all.split_last() else {
        return without_impacts(trajectory, frequency, n_periods);
    };
    let (start, end) = trajectory.span();
    let found = match frequency {
        None => latest(earlier, last).map(|k| (k, 1)),
        Some(w) => {
            let period = TAU / w;
            let recorded = ((end - start) / period).floor() as usize;
            let candidates = n_periods.map_or(1..=recorded.min(MOST_PERIODS), |n| n..=n);
            let returns = candidates.filter_map(|n| {
                let (k, d) = nearest(earlier, last, n as f64 * period)?;
                Some((k, n, d))
            });
            first_return(returns)
        }
    };
    let Some((first, n_periods)) = found else {
        let rule = "its last impact must have happened before, one period of the orbit earlier; simulate longer";
        return Err(Error::bad_value(
            "guess",
            "a trajectory without a return",
            rule,
        ));
    };
    let round = &earlier[first..];
    let period = frequency.map_or(last.time - round[0].time, |w| TAU / w * n_periods as f64);
    Ok(Start {
        pattern: Pattern::new(round.iter().map(|i| i.stops.clone()).collect())?,
        n_periods,
        phase: round[0].phase,
        parts: round
            .iter()
            .map(|i| (i.time - round[0].time) / (last.time - round[0].time))
            .collect(),
        period,
        states: round.iter().map(|i| i.state.clone()).collect(),
    })
}

/// The earlier instants that are like the last one, with how far they are from it.
fn alike<'a>(
    earlier: &'a [Instant],
    last: &'a Instant,
    lag: Option<f64>,
) -> impl DoubleEndedIterator<Item = (usize, f64)> + Clone + 'a {
    earlier
        .iter()
        .enumerate()
        .map(move |(k, instant)| (k, distance(instant, last, lag)))
        .filter(|(_, d)| *d < 1.0)
}

/// The instant most like the last one, `lag` before it.
fn nearest(earlier: &[Instant], last: &Instant, lag: f64) -> Option<(usize, f64)> {
    alike(earlier, last, Some(lag)).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The latest return, as near as any.
fn latest(earlier: &[Instant], last: &Instant) -> Option<usize> {
    let all = alike(earlier, last, None);
    let least = all.clone().map(|(_, d)| d).fold(f64::INFINITY, f64::min);
    let near = all.rev().find(|(_, d)| *d <= least.max(RETURNED));
    near.map(|(k, _)| k)
}

/// The fewest periods after which the motion returned, or those after which it came nearest.
fn first_return(returns: impl Iterator<Item = (usize, usize, f64)>) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize, f64)> = None;
    for (k, n, d) in returns {
        if d <= RETURNED {
            return Some((k, n));
        }
        if best.is_none_or(|(_, _, least)| d < least) {
            best = Some((k, n, d));
        }
    }
    best.map(|(k, n, _)| (k, n))
}

/// A trajectory without impacts is near a motion in step with the forcing.
fn without_impacts(
    trajectory: &Trajectory,
    frequency: Option<f64>,
    n_periods: Option<usize>,
) -> Result<Start> {
    let Some(w) = frequency else {
        let rule = "a trajectory without impacts in a scene without forcing has no period to find";
        return Err(Error::bad_value("guess", "a trajectory", rule));
    };
    let (_, end) = trajectory.span();
    let n = n_periods.unwrap_or(1);
    Ok(Start {
        pattern: Pattern::none(),
        n_periods: n,
        phase: trajectory.forcing_phase(end),
        parts: vec![0.0],
        period: TAU / w * n as f64,
        states: vec![joined(trajectory.state(end, ImpactSide::After)?)],
    })
}

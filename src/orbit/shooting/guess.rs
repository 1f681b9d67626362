//! What a search for a periodic motion starts from: what happens at its instants, their times, the states after them; read off
//! another orbit, or off the end of a trajectory. The first instant is an impact: the landing behind a release, if there is
//! one.

use crate::error::{Error, Result};
use crate::hybrid::joined;
use crate::itinerary::{
    Instant, Itinerary, ReadInstant, folded, instants_of, instants_of_arcs, uneventful_end,
    unsupported,
};
use crate::law::Regime;
use crate::model::Scene;

use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::path::{ImpactSide, KeptMotion};
use crate::quantity::positive;
use crate::simulate::{SimulateOptions, Trajectory, simulate};
use crate::tolerance::{GUESS_RUN_PERIODS, GUESS_WAIT_PERIODS, RETURNED, STATE_AT_REST};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// The most forcing periods in one period of the motion that are looked for in a trajectory. [work]
const MOST_GUESS_PERIODS: usize = 64;

/// What [`crate::find_orbit`] starts from.
#[derive(Debug, Clone, Copy)]
pub enum Guess<'a> {
    /// Another orbit: of other parameters, or of the linearised scene.
    Orbit(&'a PeriodicOrbit),
    /// A trajectory that comes near the orbit in the end; it must have kept its motion.
    Trajectory(&'a Trajectory),
    /// Position and velocity at time zero, at the forcing phase of the scene, from which the motion is followed for one period of the orbit.
    State {
        /// Position, shape `(n,)`.
        q: &'a DVector<f64>,
        /// Velocity, shape `(n,)`.
        v: &'a DVector<f64>,
        /// The period, of a scene without forcing alone.
        period: Option<f64>,
    },
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
    /// Its instants, times in parts of the period from the first one on; that is an impact, if there is any.
    pub instants: Vec<Instant>,
    /// Forcing periods in one period, 1 without forcing.
    pub n_periods: usize,
    /// The forcing phase at the first instant.
    pub phase: f64,
    /// The period that the guess itself has.
    pub period: f64,
}

impl Guess<'_> {
    /// The guess as numbers, for so many forcing periods if that is given.
    pub(crate) fn read(self, scene: &Scene, n_periods: Option<usize>) -> Result<Start> {
        let frequency = scene.frequency();
        match self {
            Self::Orbit(orbit) => from_orbit(orbit, n_periods),
            Self::Trajectory(trajectory) => from_trajectory(trajectory, frequency, n_periods),
            Self::State { q, v, period } => {
                let once = scene
                    .period()
                    .map(|once| once * n_periods.unwrap_or(1) as f64);
                let period = period_of_state(once, period)?;
                from_state(scene, (q, v), n_periods.unwrap_or(1), period)
            }
        }
    }
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
    let state = |time: f64| joined(&orbit.state_at(time, ImpactSide::After));
    let instants = instants_of_arcs(orbit.flights(), orbit.impacts(), state);
    let one_round = folded(instants, orbit.scene());
    // A motion without instants is one flight, however long.
    let is_one = one_round[0].instant.stage.transition.is_nothing();
    let rounds = (0..if is_one { 1 } else { times }).flat_map(|round| {
        let late = round as f64 * orbit.period();
        let each = one_round.iter().map(|own| own.instant.clone());
        each.map(move |instant| instant.later(late))
    });
    Ok(started(
        rounds.collect(),
        wanted,
        orbit.phase(),
        orbit.period() * times as f64,
    ))
}

/// A start from the instants of one round; the phase is that at the first.
pub(super) fn started(mut round: Vec<Instant>, n_periods: usize, phase: f64, period: f64) -> Start {
    let zero = round[0].time;
    for own in &mut round {
        own.time = (own.time - zero) / period;
        own.start = (own.start - zero) / period;
    }
    Start {
        instants: round,
        n_periods,
        phase,
        period,
    }
}

/// Sizes of position and velocity below which a state is at rest, as far as a return is concerned.
fn at_rest(all: &[ReadInstant], span: f64) -> [f64; 2] {
    let largest = |half: usize| {
        let sizes = all.iter().map(|ReadInstant { instant, .. }| {
            let n = instant.state.len() / 2;
            instant.state.rows(half * n, n).amax()
        });
        sizes.fold(0.0, f64::max)
    };
    let approach = all.iter().map(|own| own.approach);
    let (q, v) = (largest(0), approach.fold(largest(1), f64::max));
    [q.max(v * span), v.max(q / span)].map(|size| STATE_AT_REST * size)
}

/// How far two instants are from being the same one a number of periods later, relative to the motion's size.
fn distance(a: &Instant, b: &Instant, lag: Option<f64>, rest: [f64; 2]) -> f64 {
    if a.stage != b.stage {
        return f64::INFINITY;
    }
    let n = a.state.len() / 2;
    let apart = |half: usize| {
        let (x, y) = (a.state.rows(half * n, n), b.state.rows(half * n, n));
        let size = x.amax().max(y.amax()).max(rest[half]);
        if size > 0.0 {
            (x - y).amax() / size
        } else {
            0.0
        }
    };
    let late = lag.map_or(0.0, |lag| ((b.time - a.time) / lag - 1.0).abs());
    apart(0).max(apart(1)).max(late)
}

fn from_trajectory(
    trajectory: &Trajectory,
    frequency: Option<f64>,
    n_periods: Option<usize>,
) -> Result<Start> {
    let stretches = trajectory.stretches()?;
    if let (Some(last), Some(w)) = (stretches.last(), frequency)
        && !last.lasting().is_free()
        && last.end - last.start >= TAU / w * n_periods.unwrap_or(1) as f64
    {
        return without_instants(trajectory, frequency, n_periods, last.regime);
    }
    let mut all = instants_of(trajectory)?;
    // Between two releases of a stop the motion has one round; there is the least to go wrong with the number of impacts.
    let list = itinerary(&all);
    if let Some(last) = (0..all.len()).rfind(|&k| list.departure(k).is_some()) {
        all.truncate(last + 1);
    }
    let Some((last, earlier)) = all.split_last() else {
        return without_instants(trajectory, frequency, n_periods, Regime::free());
    };
    let (start, end) = trajectory.span();
    let rest = at_rest(&all, end - start);
    let found = match frequency {
        None => latest(earlier, last, rest).map(|k| (k, 1)),
        Some(w) => {
            let period = TAU / w;
            let recorded = ((end - start) / period).floor() as usize;
            let candidates = n_periods.map_or(1..=recorded.min(MOST_GUESS_PERIODS), |n| n..=n);
            let returns = candidates.filter_map(|n| {
                let (k, d) = nearest(earlier, last, (n, period), rest)?;
                Some((k, n, d))
            });
            first_return(returns)
        }
    };
    let Some((first, n_periods)) = found else {
        let earlier = n_periods.map_or("one period of the orbit".to_owned(), |n| {
            format!("n_periods = {n} forcing periods")
        });
        let rule = format!(
            "its last impact must have happened before, {earlier} earlier; simulate longer"
        );
        return Err(Error::bad_value(
            "guess",
            "a trajectory without a return",
            rule,
        ));
    };
    let spanned = last.instant.time - earlier[first].instant.time;
    let period = frequency.map_or(spanned, |w| TAU / w * n_periods as f64);
    let round = earlier[first..].to_vec();
    one_round(round, (spanned, period), n_periods, trajectory.scene())
}

/// The period for which a motion from a state is followed: that of the forcing, or what is given without one.
pub(super) fn period_of_state(forced: Option<f64>, given: Option<f64>) -> Result<f64> {
    match (forced, given) {
        (Some(period), None) => Ok(period),
        (None, Some(period)) => positive("guess[2]", period),
        (Some(_), Some(period)) => {
            let rule = "the scene has a forcing, whose periods n_periods counts; leave it out";
            Err(Error::bad_value("guess[2]", period, rule))
        }
        (None, None) => {
            let rule = "without forcing the period is to be guessed too: (q0, v0, period)";
            Err(Error::bad_value("guess", "a state without a period", rule))
        }
    }
}

/// What happens in one period from a state at time zero on: from the first instant to its return, which comes about a period later.
fn from_state(
    scene: &Scene,
    (q, v): (&DVector<f64>, &DVector<f64>),
    n_periods: usize,
    period: f64,
) -> Result<Start> {
    let span = (0.0, GUESS_RUN_PERIODS * period);
    let run = simulate(scene, q, v, span, &SimulateOptions::default())?;
    let stretches = run.stretches()?;
    let all = instants_of(&run)?;
    let Some(first) = all
        .first()
        .filter(|first| first.instant.time <= GUESS_WAIT_PERIODS * period)
    else {
        let regime = stretches.last().map_or(Regime::free(), |part| part.regime);
        return without_instants(&run, scene.frequency(), Some(n_periods), regime);
    };
    let (first, at) = (&first.instant, |k: usize| &all[k].instant);
    let off = |k: usize| (at(k).time - first.time - period).abs();
    let is_return = |k: &usize| at(*k).stage == first.stage && off(*k) < 0.5 * period;
    let returns = (1..all.len()).filter(is_return);
    let back = returns.min_by(|&i, &j| off(i).total_cmp(&off(j)));
    let (count, spanned) = back.map_or_else(
        || {
            let end = first.time + period;
            let count = all.partition_point(|own| own.instant.time < end);
            (count, period)
        },
        |k| (k, at(k).time - first.time),
    );
    one_round(all[..count].to_vec(), (spanned, period), n_periods, scene)
}

/// What happens at some instants.
fn itinerary(instants: &[ReadInstant]) -> Itinerary {
    let stages = instants.iter().map(|own| own.instant.stage.clone());
    stages.collect()
}

/// The start that one round is, whose time is stretched to the period.
fn one_round(
    mut round: Vec<ReadInstant>,
    (spanned, period): (f64, f64),
    n_periods: usize,
    scene: &Scene,
) -> Result<Start> {
    let zero = round[0].instant.time;
    let stretch = |time: f64| (time - zero) / spanned * period;
    for ReadInstant { instant, .. } in &mut round {
        (instant.time, instant.start) = (stretch(instant.time), stretch(instant.start));
    }
    let Some(landing) = itinerary(&round).first_contact() else {
        let time = round.last().map_or(0.0, |own| own.instant.time);
        return Err(unsupported(
            "no contact that begins but impacts that accumulate",
            time,
        ));
    };
    // Those before the first impact come a period later.
    for own in &mut round[..landing] {
        own.instant.time += period;
        own.instant.start += period;
    }
    round.rotate_left(landing);
    let phase = round[0].phase;
    let folded = folded(round, scene).into_iter().map(|own| own.instant);
    Ok(started(folded.collect(), n_periods, phase, period))
}

/// The earlier instants that are like the last one, with how far they are from it.
fn alike<'a>(
    earlier: &'a [ReadInstant],
    last: &'a ReadInstant,
    lag: Option<f64>,
    rest: [f64; 2],
) -> impl DoubleEndedIterator<Item = (usize, f64)> + Clone + 'a {
    earlier
        .iter()
        .enumerate()
        .map(move |(k, own)| (k, distance(&own.instant, &last.instant, lag, rest)))
        .filter(|(_, d)| *d < 1.0)
}

/// The instant most like the last one, so many periods before it to the nearest whole number: one of another number belongs
/// to another motion.
fn nearest(
    earlier: &[ReadInstant],
    last: &ReadInstant,
    (n, period): (usize, f64),
    rest: [f64; 2],
) -> Option<(usize, f64)> {
    let n = n as f64;
    alike(earlier, last, Some(n * period), rest)
        .filter(|(k, _)| ((last.instant.time - earlier[*k].instant.time) / period - n).abs() <= 0.5)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The latest return, as near as any.
fn latest(earlier: &[ReadInstant], last: &ReadInstant, rest: [f64; 2]) -> Option<usize> {
    let all = alike(earlier, last, None, rest);
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

/// A trajectory without instants is near a motion in step with the forcing, some stops perhaps held for good.
fn without_instants(
    trajectory: &Trajectory,
    frequency: Option<f64>,
    n_periods: Option<usize>,
    regime: &Regime,
) -> Result<Start> {
    let Some(w) = frequency else {
        let rule = "in a scene without forcing nothing gives it a period and a phase that could be looked for";
        return Err(Error::bad_value(
            "guess",
            "of a motion without impacts",
            rule,
        ));
    };
    let n = n_periods.unwrap_or(1);
    let ReadInstant { instant, phase, .. } = uneventful_end(trajectory, regime)?;
    Ok(started(vec![instant], n, phase, TAU / w * n as f64))
}

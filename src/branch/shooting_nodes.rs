//! A loop as a list of its instants (nodes of multiple shooting), and loops with other instants that are the same motion: several rounds of
//! it, one of several, one with an impact of no speed more or less. Times in \[s\].

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::error::Result;
use crate::law::{Stage, Transition};
use crate::orbit::{ShootingState, Signature};
use crate::tolerance::{SAME_ROUND, SHORT_FLIGHT_BACK};
use nalgebra::DVector;

/// A node of multiple shooting: an instant of a loop, and the flight that begins after it.
#[derive(Clone)]
pub(super) struct ShootingNode {
    /// What happens at the instant, and the stops held after it.
    pub stage: Stage,
    /// The time of the instant \[s\].
    pub time: f64,
    /// The time at which its flight begins \[s\]: later than the instant where impacts accumulate.
    pub start: f64,
    /// Positions and velocities at the start of the flight, shape `(2 n_dof,)`, \[m\] and \[m/s\].
    pub state: DVector<f64>,
}

impl ShootingNode {
    /// The node at a later time.
    pub fn later(mut self, by: f64) -> Self {
        self.time += by;
        self.start += by;
        self
    }
}

/// The period of a loop \[s\].
pub(super) fn period(state: &ShootingState) -> f64 {
    state.times[state.states.len()] - state.times[0]
}

/// The instants of the period that begins with another one of them.
pub(super) fn turned(
    mut instants: Vec<ShootingNode>,
    first: usize,
    period: f64,
) -> Vec<ShootingNode> {
    let later = instants.split_off(first);
    let earlier = instants.into_iter().map(|own| own.later(period));
    later.into_iter().chain(earlier).collect()
}

/// The instants of the period that begins with an impact, with the first one after a release if there is one; none if no impact is left but
/// those that accumulate.
pub(super) fn begun_with_strike(
    instants: Vec<ShootingNode>,
    period: f64,
) -> Option<Vec<ShootingNode>> {
    let is_release = |own: &ShootingNode| own.stage.transition.is_release();
    let is_strike = |own: &ShootingNode| own.stage.transition.is_strike();
    let after = instants.iter().position(is_release).map_or(0, |k| k + 1);
    let mut later = (after..instants.len()).chain(0..after);
    let first = later.find(|&k| is_strike(&instants[k]))?;
    Some(turned(instants, first, period))
}

/// A loop of other instants in the period of a loop, begun with an impact, and its problem.
pub(super) fn rebuilt<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    instants: Vec<ShootingNode>,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    match begun_with_strike(instants, period(&place.state)) {
        Some(instants) => as_loop(problem, place, instants),
        None => Ok(None),
    }
}

/// A loop of instants in the given order in the period of a loop, and its problem.
pub(super) fn as_loop<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    instants: Vec<ShootingNode>,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    let length = (period(&place.state), problem.signature.n_periods);
    problem
        .with_instants(place.value, instants, length)
        .map(Some)
}

/// Whether one stop is hit at each instant, or nothing happens, and all flights are free.
pub(super) fn are_impacts(stages: &[Stage]) -> bool {
    let is_one =
        |stage: &Stage| stage.transition.struck().len() == 1 || stage.transition.is_nothing();
    stages
        .iter()
        .all(|stage| stage.regime.is_free() && is_one(stage))
}

impl BranchProblem<'_> {
    /// The instants of a loop.
    pub fn instants(&self, state: &ShootingState) -> Vec<ShootingNode> {
        let stages = self.signature.stages.iter().cloned();
        let times = state.times.iter().zip(&state.starts);
        stages
            .zip(times)
            .zip(&state.states)
            .map(|((stage, (&time, &start)), state)| ShootingNode {
                stage,
                time,
                start,
                state: state.clone(),
            })
            .collect()
    }

    /// A loop of instants, and its problem; with its period and how many periods of the forcing that is.
    pub fn with_instants(
        &self,
        value: f64,
        instants: Vec<ShootingNode>,
        (period, n_periods): (f64, usize),
    ) -> Result<(Self, ParametricLoop)> {
        // Without forcing time counts from the first instant.
        let first = instants[0].time;
        let zero = if self.is_free { first } else { 0.0 };
        let mut stages = Vec::new();
        let mut state = ShootingState {
            times: Vec::new(),
            starts: Vec::new(),
            states: Vec::new(),
        };
        for instant in instants {
            stages.push(instant.stage);
            state.times.push(instant.time - zero);
            state.starts.push(instant.start - zero);
            state.states.push(instant.state);
        }
        state.times.push(first - zero + period);
        let has_pulses = self.has_pulses && are_impacts(&stages);
        let problem = Self {
            has_pulses,
            signature: Signature {
                stages,
                n_periods: if self.is_free { 1 } else { n_periods },
                images: None,
                ..self.signature
            },
            ..self.clone()
        };
        let scene = problem.scene(value)?;
        let place = problem.place(&scene, value, state)?;
        Ok((problem, place))
    }

    /// Several rounds of a loop as one loop, in each of which a deviation with a factor of its own is added; of half periods every second
    /// one is mirrored.
    pub fn repeated(
        &self,
        place: &ParametricLoop,
        by: &ShootingState,
        factors: &[f64],
    ) -> Result<(Self, ParametricLoop)> {
        let state = &place.state;
        let count = state.states.len();
        // Without forcing a round takes longer by the deviation of its last instant.
        let late = by.times[count] - by.times[0];
        let mut all = Vec::new();
        let mut begin = 0.0;
        for (round, factor) in factors.iter().enumerate() {
            let images = self.signature.images.as_ref();
            let images = images.filter(|_| round % 2 == 1);
            for (k, mut instant) in self.instants(state).into_iter().enumerate() {
                instant.time += begin + factor * by.times[k];
                instant.start += begin + factor * by.starts[k];
                instant.state += &by.states[k] * *factor;
                if let Some(images) = images {
                    instant.stage = instant.stage.mirrored(images);
                    instant.state.neg_mut();
                }
                all.push(instant);
            }
            begin += period(state) + factor * late;
        }
        if self.is_empty() {
            all.truncate(1);
        }
        let halves = if self.signature.images.is_some() {
            2
        } else {
            1
        };
        let n_periods = self.signature.n_periods * factors.len() / halves;
        self.with_instants(place.value, all, (begin, n_periods))
    }

    /// One round of a loop that consists of several equal ones; none if it does not.
    pub fn one_round(&self, place: &ParametricLoop) -> Result<Option<(Self, ParametricLoop)>> {
        let stages = &self.signature.stages;
        let (is_empty, count) = (self.is_empty(), stages.len());
        let n_periods = self.signature.n_periods;
        let periods = if self.is_free { count } else { n_periods };
        for rounds in (2..=periods).rev() {
            let own = if is_empty { 1 } else { count / rounds };
            let is_like = is_empty || (own..count).all(|k| stages[k] == stages[k - own]);
            if !periods.is_multiple_of(rounds) || own == 0 || !is_like {
                continue;
            }
            let instants = self.instants(&place.state)[..own].to_vec();
            let length = (
                period(&place.state) / rounds as f64,
                (n_periods / rounds).max(1),
            );
            let (one, found) = self.with_instants(place.value, instants, length)?;
            if one.mismatch(&found)? <= SAME_ROUND {
                return Ok(Some((one, found)));
            }
        }
        Ok(None)
    }

    /// The instant of an impact on a stop that is nearest to a time.
    pub fn instant_of(&self, place: &ParametricLoop, (stop, time): (usize, f64)) -> Option<usize> {
        let instants = self.instants(&place.state);
        let whole = period(&place.state);
        let off = |k: &usize| {
            let late = (time - instants[*k].time).rem_euclid(whole);
            late.min(whole - late)
        };
        let on_stop =
            (0..instants.len()).filter(|&k| instants[k].stage.transition.struck().contains(&stop));
        on_stop.min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The instant after which a stop is held for the least time.
    pub fn last_stick(&self, place: &ParametricLoop) -> Option<usize> {
        let state = &place.state;
        let held = |k: &usize| !self.signature.stages[*k].regime.is_free();
        let length = |k: usize| state.times[k + 1] - state.starts[k];
        let sticks = (0..state.states.len()).filter(held);
        sticks.min_by(|&a, &b| length(a).total_cmp(&length(b)))
    }

    /// The instant at which a stop is left for a small part of the period: the shortest such flight, or flights with impacts after a
    /// release, to where the stop is held again.
    pub fn short_flight(&self, place: &ParametricLoop) -> Option<usize> {
        let (stages, state) = (&self.signature.stages, &place.state);
        let count = stages.len();
        let comes_back = |k: usize| {
            let left = &stages[k].transition;
            let own = left.element().filter(|_| !left.is_chatter())?;
            let is_released = left.is_release();
            let mut span = 0.0;
            let mut at = k;
            while !stages[at].regime.holds(own) {
                span += state.times[at + 1] - state.starts[at];
                at = (at + 1) % count;
                let next = &stages[at].transition;
                let is_landing = next.meets(own) && (is_released || next.is_strike());
                let is_last = is_released || !next.is_strike();
                let is_back = stages[at].regime.holds(own);
                if !is_landing || !(is_back || is_last) || at == k {
                    return None;
                }
            }
            (at != k && span < SHORT_FLIGHT_BACK * period(state)).then_some((k, span))
        };
        let each = (0..count).filter_map(comes_back);
        let shortest = each.min_by(|a, b| a.1.total_cmp(&b.1));
        shortest.map(|(k, _)| k)
    }

    /// Whether an instant is an impact that throws the motion off a held stop to which it comes back at the next instant.
    pub fn is_low_bounce(&self, instant: usize) -> bool {
        let stages = &self.signature.stages;
        let count = stages.len();
        let (before, next) = (
            &stages[(instant + count - 1) % count],
            &stages[(instant + 1) % count],
        );
        let own = &stages[instant];
        let mut thrown = before
            .regime
            .constrained()
            .iter()
            .filter(|&&stop| !own.regime.holds(stop));
        let is_back = |&stop: &usize| next.transition.meets(stop);
        let is_impact = own.transition.is_strike();
        count > 2 && is_impact && next.regime == before.regime && thrown.any(is_back)
    }

    /// A loop without one of its impacts, and without the low bounce that this makes; none where no impact is left with which a period
    /// could begin.
    pub fn without(
        &self,
        place: &ParametricLoop,
        instant: usize,
    ) -> Result<Option<(Self, ParametricLoop)>> {
        let mut instants = self.instants(&place.state);
        let length = (period(&place.state), self.signature.n_periods);
        if instants.len() > 1 {
            let back = (instant + 1) % instants.len();
            let is_low_bounce = self.is_low_bounce(instant);
            instants.remove(instant);
            if is_low_bounce {
                instants.remove(if back > instant { back - 1 } else { back });
            }
            // A period begins with an impact after which nothing is held.
            let is_beginning =
                |own: &ShootingNode| own.stage.transition.is_strike() && own.stage.regime.is_free();
            let from = if instant > 0 && !(is_low_bounce && back == 0) {
                Some(0)
            } else {
                instants.iter().position(is_beginning)
            };
            let Some(from) = from else {
                return Ok(None);
            };
            instants = turned(instants, from, length.0);
        } else if self.is_free {
            return Ok(None);
        } else {
            instants[0].stage.transition = Transition::Nothing;
        }
        let (mut problem, place) = self.with_instants(place.value, instants, length)?;
        problem.signature.images.clone_from(&self.signature.images);
        Ok(Some((problem, place)))
    }
}

//! A loop as a list of its instants (nodes of multiple shooting), and loops with other instants that are the same motion: several rounds of
//! it, one of several, one with an impact of no speed more or less. Times in \[s\].

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::error::Result;
use crate::itinerary::{Instant, begun_with_impact, without_impact};
use crate::law::Stage;
use crate::orbit::{ShootingState, Signature};
use crate::tolerance::{SAME_ROUND, SHORT_FLIGHT_BACK};

/// The period of a loop \[s\].
pub(super) fn period(state: &ShootingState) -> f64 {
    state.times[state.states.len()] - state.times[0]
}

/// A loop of other instants in the period of a loop, begun with an impact, and its problem.
pub(super) fn rebuilt<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    instants: Vec<Instant>,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    let length = (period(&place.state), problem.signature.n_periods);
    let begun = begun_with_impact(instants, length.0);
    let loop_of = |instants| problem.with_instants(place.value, instants, length);
    begun.map(loop_of).transpose()
}

impl BranchProblem<'_> {
    /// The instants of a loop.
    pub fn instants(&self, state: &ShootingState) -> Vec<Instant> {
        state.instants(&self.signature.stages)
    }

    /// A loop of instants, and its problem; with its period and how many periods of the forcing that is.
    pub fn with_instants(
        &self,
        value: f64,
        instants: Vec<Instant>,
        (period, n_periods): (f64, usize),
    ) -> Result<(Self, ParametricLoop)> {
        // Without forcing time counts from the first instant.
        let first = instants[0].time;
        let zero = if self.is_free { first } else { 0.0 };
        let instants = instants.into_iter().map(|own| own.later(-zero)).collect();
        let (stages, state) = ShootingState::of_instants(instants, first - zero + period);
        let mut problem = Self {
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
        problem.formulation = problem.formulation.of_loop(&place);
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
        let n_periods = self.signature.n_periods;
        let periods = if self.is_free {
            stages.len()
        } else {
            n_periods
        };
        for rounds in (2..=periods).rev() {
            let own = stages.round(rounds);
            let Some(own) = own.filter(|_| periods.is_multiple_of(rounds)) else {
                continue;
            };
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
        let on_stop = self.signature.stages.impacts_on(stop);
        on_stop.min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The instant behind which contact lasts for the least time.
    pub fn last_stick(&self, place: &ParametricLoop) -> Option<usize> {
        let state = &place.state;
        let lasts = |k: &usize| !self.signature.stages[*k].regime.is_free();
        let length = |k: usize| state.times[k + 1] - state.starts[k];
        let sticks = (0..state.states.len()).filter(lasts);
        sticks.min_by(|&a, &b| length(a).total_cmp(&length(b)))
    }

    /// The instant at which a stop is left for a small part of the period: the shortest such flight, or flights with impacts after a
    /// release, to where the stop is held again.
    pub fn short_flight(&self, place: &ParametricLoop) -> Option<usize> {
        let state = &place.state;
        let returns = (self.signature.stages).returns(|k| state.times[k + 1] - state.starts[k]);
        let short = returns.filter(|(_, span)| *span < SHORT_FLIGHT_BACK * period(state));
        let shortest = short.min_by(|a, b| a.1.total_cmp(&b.1));
        shortest.map(|(k, _)| k)
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
            let Some(others) = without_impact(instants, instant, length.0) else {
                return Ok(None);
            };
            instants = others;
        } else if self.is_free {
            return Ok(None);
        } else {
            let regime = instants[0].stage.regime.clone();
            instants[0].stage = Stage::uneventful(regime);
        }
        let (mut problem, place) = self.with_instants(place.value, instants, length)?;
        problem.signature.images.clone_from(&self.signature.images);
        Ok(Some((problem, place)))
    }
}

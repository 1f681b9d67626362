//! A loop instant by instant, and loops with other instants that are the same motion: several rounds of it, one, an impact without speed
//! more or less.

use crate::branch::family::Family;
use crate::branch::place::Place;
use crate::error::Result;
use crate::orbit::{ContactStage, Event, ShootingState, Signature};
use crate::tolerance::SAME_ROUND;
use nalgebra::DVector;

/// A flight from a stop back to it that takes less than this part of the period may come to nothing.
const SHORT_FLIGHT: f64 = 0.05;

/// An instant of a loop, and the flight that begins there.
#[derive(Clone)]
pub(super) struct Instant {
    pub stage: ContactStage,
    pub time: f64,
    pub start: f64,
    pub state: DVector<f64>,
}

impl Instant {
    /// The same at a later time.
    pub fn later(mut self, by: f64) -> Self {
        self.time += by;
        self.start += by;
        self
    }
}

/// The period of a loop.
pub(super) fn period(state: &ShootingState) -> f64 {
    state.times[state.states.len()] - state.times[0]
}

/// The instants of a period that begins with another of them.
pub(super) fn turned(mut instants: Vec<Instant>, first: usize, period: f64) -> Vec<Instant> {
    let behind = instants.split_off(first);
    let earlier = instants.into_iter().map(|own| own.later(period));
    behind.into_iter().chain(earlier).collect()
}

/// The instants of a period that begins with an impact, behind a release if there is one; none where there is no impact but those that
/// accumulate.
pub(super) fn begun_with_strike(instants: Vec<Instant>, period: f64) -> Option<Vec<Instant>> {
    let is_release = |own: &Instant| matches!(own.stage.event, Event::Release(_));
    let is_strike = |own: &Instant| matches!(own.stage.event, Event::Strike(_));
    let after = instants.iter().position(is_release).map_or(0, |k| k + 1);
    let mut behind = (after..instants.len()).chain(0..after);
    let first = behind.find(|&k| is_strike(&instants[k]))?;
    Some(turned(instants, first, period))
}

/// The loop of other instants in the period of a loop, begun with an impact.
pub(super) fn rebuilt<'a>(
    family: &Family<'a>,
    place: &Place,
    instants: Vec<Instant>,
) -> Result<Option<(Family<'a>, Place)>> {
    match begun_with_strike(instants, period(&place.state)) {
        Some(instants) => as_loop(family, place, instants),
        None => Ok(None),
    }
}

/// The loop of instants in their order in the period of a loop.
pub(super) fn as_loop<'a>(
    family: &Family<'a>,
    place: &Place,
    instants: Vec<Instant>,
) -> Result<Option<(Family<'a>, Place)>> {
    let length = (period(&place.state), family.signature.n_periods);
    family
        .with_instants(place.value, instants, length)
        .map(Some)
}

/// Whether one stop is hit at each instant, between free flights, or nothing at all.
pub(super) fn are_impacts(stages: &[ContactStage]) -> bool {
    let is_one = |stage: &ContactStage| match &stage.event {
        Event::Strike(stops) => stops.len() == 1,
        Event::Nothing => true,
        _ => false,
    };
    stages
        .iter()
        .all(|stage| stage.held.is_empty() && is_one(stage))
}

impl Family<'_> {
    /// The instants of a loop.
    pub fn instants(&self, state: &ShootingState) -> Vec<Instant> {
        let stages = self.signature.stages.iter().cloned();
        let times = state.times.iter().zip(&state.starts);
        stages
            .zip(times)
            .zip(&state.states)
            .map(|((stage, (&time, &start)), state)| Instant {
                stage,
                time,
                start,
                state: state.clone(),
            })
            .collect()
    }

    /// The loop of some instants in a period of so many of the forcing, and its family.
    pub fn with_instants(
        &self,
        value: f64,
        instants: Vec<Instant>,
        (period, n_periods): (f64, usize),
    ) -> Result<(Self, Place)> {
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
        let family = Self {
            has_pulses,
            signature: Signature {
                stages,
                n_periods: if self.is_free { 1 } else { n_periods },
                images: None,
                ..self.signature
            },
            ..self.clone()
        };
        let scene = family.scene(value)?;
        let place = family.place(&scene, value, state)?;
        Ok((family, place))
    }

    /// Several rounds of a loop as one, deviations of it in each with a factor of its own; halves are mirrored by turns.
    pub fn repeated(
        &self,
        place: &Place,
        by: &ShootingState,
        factors: &[f64],
    ) -> Result<(Self, Place)> {
        let state = &place.state;
        let count = state.states.len();
        // Without forcing a round takes as much longer as its last instant is late.
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

    /// A loop that is one round of a loop, if that is several.
    pub fn one_round(&self, place: &Place) -> Result<Option<(Self, Place)>> {
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
    pub fn instant_of(&self, place: &Place, (stop, time): (usize, f64)) -> Option<usize> {
        let instants = self.instants(&place.state);
        let whole = period(&place.state);
        let off = |k: &usize| {
            let late = (time - instants[*k].time).rem_euclid(whole);
            late.min(whole - late)
        };
        let on_stop = (0..instants.len()).filter(
            |&k| matches!(&instants[k].stage.event, Event::Strike(stops) if stops.contains(&stop)),
        );
        on_stop.min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The instant from which a stop is held for the least time.
    pub fn last_stick(&self, place: &Place) -> Option<usize> {
        let state = &place.state;
        let held = |k: &usize| !self.signature.stages[*k].held.is_empty();
        let length = |k: usize| state.times[k + 1] - state.starts[k];
        let sticks = (0..state.states.len()).filter(held);
        sticks.min_by(|&a, &b| length(a).total_cmp(&length(b)))
    }

    /// The instant at which a stop is left to which the motion comes back for good in a small part of the period, after a few impacts if the stop
    /// was let go.
    pub fn short_flight(&self, place: &Place) -> Option<usize> {
        let (stages, state) = (&self.signature.stages, &place.state);
        let count = stages.len();
        let comes_back = |k: usize| {
            let (own, is_released) = match &stages[k].event {
                Event::Release(stop) => (*stop, true),
                Event::Strike(stops) => (stops[0], false),
                _ => return None,
            };
            let mut span = 0.0;
            let mut at = k;
            while !stages[at].held.contains(&own) {
                span += state.times[at + 1] - state.starts[at];
                at = (at + 1) % count;
                let (is_landing, is_last) = match &stages[at].event {
                    Event::Strike(stops) => (stops.contains(&own), is_released),
                    Event::Chatter(stop) => (*stop == own && is_released, true),
                    _ => (false, true),
                };
                let is_back = stages[at].held.contains(&own);
                if !is_landing || !(is_back || is_last) || at == k {
                    return None;
                }
            }
            (at != k && span < SHORT_FLIGHT * period(state)).then_some((k, span))
        };
        let each = (0..count).filter_map(comes_back);
        let shortest = each.min_by(|a, b| a.1.total_cmp(&b.1));
        shortest.map(|(k, _)| k)
    }

    /// Whether an instant is an impact that throws the motion off a stop that was held before it, and the next one is where it comes back to that.
    pub fn is_hop(&self, instant: usize) -> bool {
        let stages = &self.signature.stages;
        let count = stages.len();
        let (before, next) = (
            &stages[(instant + count - 1) % count],
            &stages[(instant + 1) % count],
        );
        let own = &stages[instant];
        let is_back = |stop: &usize| match &next.event {
            Event::Strike(stops) => stops.contains(stop),
            Event::Chatter(back) => back == stop,
            _ => false,
        };
        let mut thrown = before.held.iter().filter(|stop| !own.held.contains(stop));
        let is_impact = matches!(own.event, Event::Strike(_));
        count > 2 && is_impact && next.held == before.held && thrown.any(is_back)
    }

    /// A loop without one of its impacts, and what that throws off a stop; none where no impact is left from which a period could begin.
    pub fn without(&self, place: &Place, instant: usize) -> Result<Option<(Self, Place)>> {
        let mut instants = self.instants(&place.state);
        let length = (period(&place.state), self.signature.n_periods);
        if instants.len() > 1 {
            let back = (instant + 1) % instants.len();
            let is_hop = self.is_hop(instant);
            instants.remove(instant);
            if is_hop {
                instants.remove(if back > instant { back - 1 } else { back });
            }
            // A period begins with an impact behind which nothing is held.
            let is_beginning = |own: &Instant| {
                matches!(own.stage.event, Event::Strike(_)) && own.stage.held.is_empty()
            };
            let from = if instant > 0 && !(is_hop && back == 0) {
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
            instants[0].stage.event = Event::Nothing;
        }
        let (mut family, place) = self.with_instants(place.value, instants, length)?;
        family.signature.images.clone_from(&self.signature.images);
        Ok(Some((family, place)))
    }
}

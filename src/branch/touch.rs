//! A loop with one impact more, where a stop is touched: at zero speed it is the same motion. Where other stops are held there, the law of
//! impact decides what becomes of them (theory 19, "Switching").

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::{period, rebuilt};
use crate::error::Result;
use crate::hybrid::{ImpactOutcome, carried, impact_outcome, landing_on, reset};
use crate::itinerary::Instant;
use crate::law::{Stage, Transition};
use crate::model::contacts;
use crate::orbit::with_maps;

/// A loop with one impact more, where a stop is touched, and its problem.
pub(super) struct TouchingLoop<'a> {
    pub problem: BranchProblem<'a>,
    pub place: ParametricLoop,
    /// The index of the instant of the impact.
    pub instant: usize,
    /// Stops that the loop holds through the impact although the law of impact throws the motion off them: at zero speed they are left for
    /// no time.
    pub thrown: Vec<usize>,
}

impl<'a> BranchProblem<'a> {
    /// A loop with an impact on a stop at a time, where it is touched.
    pub fn with_touch(
        &self,
        place: &ParametricLoop,
        (stop, time): (usize, f64),
    ) -> Result<TouchingLoop<'a>> {
        let state = &place.state;
        let mut instants = self.instants(state);
        let first = instants[0].time;
        let time = first + (time - first).rem_euclid(period(state));
        let flight = instants.iter().rposition(|own| own.start <= time);
        let mut touched = instants[flight.unwrap_or(0)].clone();
        let span = (touched.start, time);
        let scene = self.scene(place.value)?;
        let is_rigid = scene.stops()[stop].contact().is_rigid();
        let ImpactOutcome { transition, thrown } = with_maps(&scene, &self.signature, |motion| {
            let regime = &touched.stage.regime;
            touched.state = carried(motion, regime, span, &touched.state)?;
            if is_rigid {
                return impact_outcome(motion, (stop, regime), time, &touched.state);
            }
            Ok(ImpactOutcome {
                transition: Transition::touch(stop),
                thrown: Vec::new(),
            })
        })?;
        (touched.time, touched.start) = (time, time);
        touched.stage.transition = transition;
        let instant = if self.is_empty() {
            instants.clear();
            0
        } else {
            flight.map_or(1, |flight| flight + 1)
        };
        instants.insert(instant, touched);
        let length = (period(state), self.signature.n_periods);
        let (mut problem, place) = self.with_instants(place.value, instants, length)?;
        problem.signature.images.clone_from(&self.signature.images);
        Ok(TouchingLoop {
            problem,
            place,
            instant,
            thrown,
        })
    }

    /// The loop in which a stop that is held through an impact of some speed is left there, as the law of impact says, and comes back at
    /// once: to rest, or to impacts that accumulate. To first order in the speed both are one motion: what the stop gives less while it is
    /// left is what it would have to pull at the impact. None where other stops are held beside one that bounces, or something else comes
    /// before.
    pub fn left_at(
        &self,
        place: &ParametricLoop,
        instant: usize,
        stop: usize,
    ) -> Result<Option<(Self, ParametricLoop)>> {
        let state = &place.state;
        let mut instants = self.instants(state);
        let own = instants[instant].clone();
        let (lasting, without) = (own.stage.regime.clone(), own.stage.regime.without(stop));
        let scene = self.scene(place.value)?;
        let impact = contacts(&scene)[stop].law();
        if !impact.is_inelastic() && !without.is_free() {
            return Ok(None);
        }
        let signature = self.signature.clone().beside(&without);
        let end = state.times[instant + 1];
        let found = with_maps(&scene, &signature, |motion| {
            let n = own.state.len() / 2;
            let speed = motion.gap(stop, own.time, &own.state)?;
            let speed = speed.speed(own.state.rows(n, n));
            let rate = motion.rate(&without, own.time, &own.state)?;
            let pull = -motion.gap_acceleration(stop, own.time, &own.state, &rate)?;
            let time = own.time + 2.0 * speed / pull;
            let start = own.time + 2.0 * speed / pull / (1.0 - impact.restitution);
            if !(speed > 0.0 && pull > 0.0 && own.time < time && start < end) {
                return Ok(None);
            }
            // Impacts that accumulate end in lasting contact.
            let regime = if impact.is_inelastic() {
                &without
            } else {
                &lasting
            };
            let before = carried(motion, regime, (own.time, start), &own.state)?;
            let Some(transition) = landing_on(motion, (stop, &without), start, &before)? else {
                return Ok(None);
            };
            Ok(Some(Instant {
                state: reset(motion, &transition, start, before)?,
                stage: Stage {
                    transition,
                    regime: lasting,
                },
                time,
                start,
            }))
        })?;
        let Some(landed) = found else {
            return Ok(None);
        };
        instants[instant].stage.regime = without;
        instants.insert(instant + 1, landed);
        rebuilt(self, place, instants)
    }
}

//! Impacts that accumulate, in a run: when what is left of them is completed at once (theory 9, "Chatter").
//!
//! On one stop, with no other in contact (`accumulates`): the last two approach speeds are in the ratio e to `RATIO_TOL`;
//! [`CHATTER_SAFETY`] times what the limit of low flights neglects is below the tolerance, or the next flight is lost in rounding; until
//! they end the force goes on drawing the motion to the stop, and all others stay open. Otherwise, as on several stops or beside stops that
//! are held (`are_spent`): impacts are gone through until their flights are rounding, and what is left of their speeds is taken away by
//! impacts without restitution.
//!
//! In place of impacts on one stop the motion is moved onto it along b and held there for the time that they would take,
//! `CompleteChatter::span` (`Holding::complete_chatter`). Those of orbits are completed in `hybrid/chatter_map.rs`.

use super::{Resolved, Resolver};
use crate::error::Result;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::{GapState, HybridSystem};
use crate::impact::CompleteChatter;
use crate::law::GuardKind;
use crate::model::impulses_of;
use crate::tolerance::{CHATTER_SAFETY, GAP_ROUNDING, LOST_FLIGHT, SPEED_ROUNDING};
use nalgebra::DVector;

impl Resolver {
    /// Completes impacts that accumulate, those before the end of the run.
    #[cold]
    pub(super) fn accumulate<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        stop: usize,
        t_end: f64,
        recorder: &mut R,
    ) -> Resolved {
        system.evaluate_gaps()?;
        let now = system.clock();
        let left = now.until(now.at(t_end)).max(0.0);
        recorder.accumulation(now.time(), stop, -system.gap(stop).speed);
        let span = chatter_at(system, stop).span();
        self.note_cut(span > left);
        system.complete_chatter(&[stop], span.min(left), recorder)?;
        self.last_impact = None;
        self.zero_speed.clear();
        self.zero_speed.push(stop);
        self.settle(system)
    }

    /// Whether the impacts on the stop that was reached, alone, accumulate, and so soon that what is left of them is below
    /// the tolerance, or the flights between them lost in rounding (theory 9).
    pub(super) fn accumulates<Y: HybridSystem + ?Sized>(
        &self,
        system: &mut Y,
        reached: usize,
    ) -> Result<bool> {
        let chatter = chatter_at(system, reached);
        let (law, speed, pull) = (chatter.law, chatter.speed, chatter.acceleration);
        let is_alone = self.touching.len() == 1;
        let regular = self
            .last_impact
            .is_some_and(|(stop, before)| stop == reached && law.is_repeated(before, -speed));
        if !(regular && is_alone && speed < 0.0 && pull < 0.0 && law.is_contracting()) {
            return Ok(false);
        }
        let residual = chatter.residual();
        let tolerance = system.tolerance(reached, self.reaches[reached]);
        // Impacts whose next flight rises by little more than rounding are not gone through one by one either.
        let is_low = chatter.height_by_acceleration()
            < LOST_FLIGHT * GAP_ROUNDING * self.sizes[reached] * -pull;
        let span = chatter.span();
        let is_due = CHATTER_SAFETY * residual < tolerance || is_low;
        if !is_due || pull + span * system.free_jerk(reached)?.abs() >= 0.0 {
            return Ok(false);
        }
        let others = (0..system.n_stops()).filter(|&stop| stop != reached);
        self.stay_open(system, (reached, chatter), others)
    }

    /// Whether each stop that is approached is struck for the last time, as the flight after it would rise by no more than rounding
    /// ([`GAP_ROUNDING`]). That counts where the last two approach speeds are in the ratio of restitution, and where the flight before was
    /// as low already and its length about that of a free fall: rounding alone keeps such flights up. After anything else an impact is the
    /// last one if the speed that it leaves is rounding itself ([`SPEED_ROUNDING`]).
    pub(super) fn are_spent<Y: HybridSystem + ?Sized>(&self, system: &Y) -> Result<bool> {
        // From most impacts flights rise by more than rounding, whatever came before.
        let may_rest = |&stop: &usize| {
            let GapState {
                speed,
                acceleration,
                ..
            } = system.gap(stop);
            let departure = system.law(stop).departure(speed);
            self.is_low((stop, departure), -acceleration, GAP_ROUNDING)
        };
        if self.held.is_empty() && !self.touching.iter().any(may_rest) {
            return Ok(false);
        }
        let mut any = false;
        for &stop in &self.touching {
            let state = system.gap(stop);
            if !self.closes_at(system, stop, state) {
                continue;
            }
            let (law, speed) = (system.law(stop), -state.speed);
            if !law.is_contracting() {
                return Ok(false);
            }
            let pull = -self.drawn(system, (stop, state), &self.held)?;
            let before = self.approaches[stop];
            let is_regular = law.is_repeated(before, speed);
            let is_low = |speed, part| self.is_low((stop, law.departure(speed)), pull, part);
            let flight = self.departure.map(|then| then.until(system.clock()));
            let is_fed = || {
                let fall = 2.0 * law.restitution * before / pull;
                is_low(before, GAP_ROUNDING) && flight.is_some_and(|flight| flight < 2.0 * fall)
            };
            let rounding = if is_regular || is_fed() {
                GAP_ROUNDING
            } else {
                SPEED_ROUNDING.powi(2)
            };
            if !is_low(speed, rounding) {
                return Ok(false);
            }
            any = true;
        }
        Ok(any)
    }

    /// Whether a flight that leaves a stop at a speed, drawn back to it, rises by no more than a part of the motion.
    fn is_low(&self, (stop, speed): (usize, f64), pull: f64, part: f64) -> bool {
        0.25 * speed * speed < part * self.sizes[stop] * pull
    }

    /// The end of impacts that lose speed, on several stops or beside stops that are held: what is left of the speeds is taken
    /// away. The rest of a sequence on one stop beside others that are held takes the time that it takes there; that of impacts on
    /// several stops, whose order nobody knows, none.
    #[cold]
    pub(super) fn come_to_rest<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        t_end: f64,
        recorder: &mut R,
    ) -> Resolved {
        let struck: Vec<usize> = self
            .touching
            .iter()
            .copied()
            .filter(|&stop| self.closes(system, stop))
            .collect();
        let lasting = self.lasting_rest(system, &struck)?;
        for &stop in &struck {
            recorder.accumulation(system.clock().time(), stop, -system.gap(stop).speed);
        }
        let now = system.clock();
        let left = now.until(now.at(t_end)).max(0.0);
        self.note_cut(lasting.is_some_and(|span| span > left));
        if lasting.is_none() {
            for &stop in &struck {
                system.record_chatter(stop, recorder)?;
            }
        }
        self.prior_sizes.fill(0.0);
        self.note_prior_sizes(system)?;
        let inelastic = DVector::zeros(self.touching.len());
        if let Err(unresolved) = self.strike_together(system, &inelastic, None::<&mut R>)? {
            return Ok(Err(unresolved));
        }
        system.evaluate_gaps()?;
        // What the last impulses throw off others, and no higher than rounding before what rests draws it back, comes to rest with them.
        let rest = self.zero_speed.clone();
        for k in 0..self.touching.len() {
            let stop = self.touching[k];
            if rest.contains(&stop) {
                continue;
            }
            let state = system.gap(stop);
            let pull = -self.drawn(system, (stop, state), &rest)?;
            if self.is_low((stop, state.speed), pull, GAP_ROUNDING) {
                self.zero_speed.push(stop);
            }
        }
        if let Some(span) = lasting {
            let beside = self.touching.iter().filter(|&stop| !struck.contains(stop));
            let all: Vec<usize> = struck.iter().chain(beside).copied().collect();
            system.complete_chatter(&all, span.min(left), recorder)?;
        }
        self.settle(system)
    }

    /// The time that the rest of impacts takes on the one stop that is struck, where all others in contact are held and stay so, and
    /// what is open stays open: they are those of a single stop, drawn to it by what the others leave of its acceleration.
    fn lasting_rest<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        struck: &[usize],
    ) -> Result<Option<f64>> {
        let &[stop] = struck else {
            return Ok(None);
        };
        let are_held = |other: &usize| *other == stop || self.held.contains(other);
        if !self.touching.iter().all(are_held) {
            return Ok(None);
        }
        let state = system.gap(stop);
        let chatter = CompleteChatter {
            law: system.law(stop),
            speed: state.speed,
            acceleration: self.drawn(system, (stop, state), &self.held)?,
        };
        let open = (0..system.n_stops()).filter(|other| !self.touching.contains(other));
        let stays = chatter.acceleration < 0.0
            && self.push_with(system, stop)?
            && self.stay_open(system, (stop, chatter), open)?;
        Ok(stays.then(|| chatter.span()))
    }

    /// Whether an impact on a stop presses all that are held, which stay closed.
    fn push_with<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> Result<bool> {
        let all: Vec<usize> = self.held.iter().copied().chain([stop]).collect();
        let mut speeds = DVector::zeros(all.len());
        speeds[all.len() - 1] = 1.0;
        let impulses = impulses_of(&system.delassus(&all)?, &speeds)?;
        Ok(impulses.iter().all(|impulse| *impulse >= 0.0))
    }

    /// Whether other stops stay as they are while impacts on one accumulate, whatever their impulses, and what is left of the gap, do to them:
    /// open, or pressed as far as their approach alone ends that.
    fn stay_open<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        (reached, chatter): (usize, CompleteChatter),
        mut others: impl Iterator<Item = usize>,
    ) -> Result<bool> {
        let span = chatter.span();
        let stays = |stop: usize| -> Result<bool> {
            let state = self.regime.state(stop);
            let sign = match system.element_law(stop).by_state().guards(state) {
                [GuardKind::Gap] => 1.0,
                [GuardKind::Approach] => -1.0,
                _ => return Ok(false),
            };
            let other = system.gap(stop);
            let coupling = system.delassus(&[reached, stop])?;
            let share = coupling[(1, 0)].abs() / coupling[(0, 0)];
            let drift = (sign * other.speed).min(0.0) + chatter.kick(share);
            let pull = (sign * other.acceleration).min(0.0);
            let bend = 0.5 * span * (pull - span * other.jerk.unwrap_or(0.0).abs());
            let left = sign * other.gap + span * (drift + bend);
            Ok(left - CHATTER_SAFETY * share * chatter.residual() > 0.0)
        };
        others.try_fold(true, |all, stop| Ok(all && stays(stop)?))
    }
}

/// The impacts on a stop that is about to be struck, if they accumulate.
fn chatter_at<Y: HybridSystem + ?Sized>(system: &Y, stop: usize) -> CompleteChatter {
    let state = system.gap(stop);
    CompleteChatter {
        law: system.law(stop),
        speed: state.speed,
        acceleration: state.acceleration,
    }
}

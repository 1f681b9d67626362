//! Impacts on one stop that accumulate: when what is left of them is completed at once (theory 9).

use super::{Resolved, Resolver};
use crate::error::Result;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::HybridSystem;
use crate::impact::CompleteChatter;
use crate::tolerance::{CHATTER_SAFETY, GAP_ROUNDING, LOST_FLIGHT};

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
        let span = chatter_at(system, stop).span().min(left);
        system.complete_chatter(&[stop], span, recorder)?;
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
        stay_open(system, (reached, chatter), others)
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

/// Whether other stops stay open while impacts on one accumulate, whatever their impulses, and what is left of the gap, do to them.
pub(super) fn stay_open<Y: HybridSystem + ?Sized>(
    system: &Y,
    (reached, chatter): (usize, CompleteChatter),
    mut others: impl Iterator<Item = usize>,
) -> Result<bool> {
    let span = chatter.span();
    let stays = |stop: usize| -> Result<bool> {
        let other = system.gap(stop);
        let coupling = system.delassus(&[reached, stop])?;
        let share = coupling[(1, 0)].abs() / coupling[(0, 0)];
        let drift = other.speed.min(0.0) + chatter.kick(share);
        let bend =
            0.5 * span * (other.acceleration.min(0.0) - span * other.jerk.unwrap_or(0.0).abs());
        Ok(other.gap + span * (drift + bend) - CHATTER_SAFETY * share * chatter.residual() > 0.0)
    };
    others.try_fold(true, |all, stop| Ok(all && stays(stop)?))
}

//! What rounding leaves unknown of the accelerations of stops in contact, by which is decided whether they are held (theory 9).

use super::Resolver;
use super::resting::Resting;
use crate::error::Result;
use crate::hybrid::system::HybridSystem;
use crate::tolerance::{GAP_ROUNDING, IMPACT_ROUNDING, TIME_ROUNDING};

impl Resolver {
    /// The errors of the accelerations of contacts beside others that are held.
    pub(super) fn unknown_beside<Y: HybridSystem + ?Sized>(
        &self,
        system: &mut Y,
        resting: &Resting<'_>,
        held: &[usize],
        contacts: &[usize],
    ) -> Result<Vec<f64>> {
        let (stops, held) = (resting.stops_of(contacts), resting.stops_of(held));
        // Where nothing changes, the motion before had the accelerations of the motion to come.
        let rates = if held == self.were_held {
            system.gap_derivatives(&stops, &self.regime.holding_instead(&held), 3..4)?
        } else {
            Vec::new()
        };
        let jerk = |k: usize| match rates.first() {
            Some(rates) => rates[k][0],
            None => system.gap(stops[k]).jerk.unwrap_or(0.0),
        };
        let unknown = |(k, &i): (usize, &usize)| {
            // A motion with stops held has fewer terms, and what it moves by is known as well as forces tell.
            let size = if self.were_held.is_empty() {
                resting.sizes[i]
            } else {
                resting.prior_sizes[i]
            };
            self.acceleration_unknown(system, (stops[k], jerk(k)), size)
        };
        Ok(contacts.iter().enumerate().map(unknown).collect())
    }

    /// What the rounding of impacts, and of their time, leaves unknown of a derivative of gaps behind them: parts of the same derivative
    /// before them and of the next one there. Nothing where there were none.
    pub(super) fn unknown_by_impacts<Y: HybridSystem + ?Sized>(
        &self,
        system: &mut Y,
        stops: &[usize],
        held: &[usize],
        order: usize,
    ) -> Result<Vec<f64>> {
        if self.impulses.is_empty() {
            return Ok(Vec::new());
        }
        for &(stop, impulse) in &self.impulses {
            system.push(stop, -impulse)?;
        }
        // The first two of a free motion are there without the matrices of its equations.
        let before = if held.is_empty() && order == 2 {
            system.evaluate_gaps()?;
            let accelerations = system.free_accelerations(stops);
            let jerks = stops.iter().map(|&stop| Ok([system.free_jerk(stop)?, 0.0]));
            let jerks = jerks.collect::<Result<_>>()?;
            vec![accelerations.iter().map(|&a| [a, 0.0]).collect(), jerks]
        } else {
            system.gap_derivatives(stops, &self.regime.holding_instead(held), order..order + 2)?
        };
        for &(stop, impulse) in &self.impulses {
            system.push(stop, impulse)?;
        }
        system.evaluate_gaps()?;
        let parts = [IMPACT_ROUNDING, TIME_ROUNDING * self.flight_time(system)];
        let mut unknown = vec![0.0; stops.len()];
        for (part, values) in parts.into_iter().zip(before) {
            for (unknown, [value, _]) in unknown.iter_mut().zip(values) {
                *unknown += part * value.abs();
            }
        }
        Ok(unknown)
    }

    /// What rounding, that of the time since the last event too, leaves unknown of the acceleration of a gap of some third derivative
    /// with terms of a size.
    pub(super) fn acceleration_unknown<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        (stop, jerk): (usize, f64),
        size: f64,
    ) -> f64 {
        let flight = self
            .departure
            .map_or(0.0, |then| then.until(system.clock()));
        let by_time = TIME_ROUNDING * flight * jerk.abs();
        GAP_ROUNDING * size + system.acceleration_lost(stop) + by_time
    }
}

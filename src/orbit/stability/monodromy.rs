//! The monodromy matrix of motions that shooting found (theory 7; that of free flights in modes is in `multipliers.rs`): flow Jacobians and
//! saltation matrices, from the flights and impacts as the shooting has them.

use crate::error::Result;
use crate::hybrid::{HybridMaps, ImpactsAt, ScaledUnits, across_impacts, across_rest};
use crate::orbit::contact_mode::ContactMode;
use nalgebra::{DMatrix, DVector};

/// One flight: its start, its end and its first state.
#[derive(Debug)]
pub(crate) struct MonodromyFlight<'a> {
    pub start: f64,
    pub end: f64,
    /// The state (q, v) at its start, shape (2n,), [m, m/s].
    pub state: DVector<f64>,
    pub mode: &'a ContactMode,
}

/// The product over one period from just after the first instant, in (q, v). `order` has the stops of each instant one after
/// the other, but those held before it; `pattern` has all of them.
pub(crate) fn monodromy<M: HybridMaps>(
    motion: &M,
    pattern: &[Vec<usize>],
    order: &[Vec<usize>],
    flights: &[MonodromyFlight<'_>],
) -> Result<DMatrix<f64>> {
    let len = flights.first().map_or(0, |flight| flight.state.len());
    let mut deviations = DMatrix::identity(len, len);
    let (mut instant, mut before) = (0, DVector::zeros(len));
    let period = flights.iter().map(|flight| flight.end - flight.start).sum();
    let units = ScaledUnits::of(flights.iter().map(|flight| &flight.state), period);
    for (k, flight) in flights.iter().enumerate() {
        let next = flights[(k + 1) % flights.len()].mode;
        let mode = flight.mode;
        if mode.is_chatter() {
            let from = (flight.start, &before);
            let rest = across_rest(motion, mode.stops()[0], &units, from, deviations)?;
            deviations = rest.at_fixed_time(motion, next.lasting())?;
            continue;
        }
        let regime = mode.lasting();
        before.clone_from(&flight.state);
        motion.flow(
            regime,
            (flight.start, flight.end),
            &mut before,
            &mut deviations,
        )?;
        if !next.is_struck || pattern.is_empty() {
            continue;
        }
        instant = (instant + 1) % pattern.len();
        let (all, ordered) = (&pattern[instant], &order[instant]);
        let at = ImpactsAt {
            struck: all,
            order: ordered,
            is_joint: all.len() > ordered.len(),
            regimes: (regime, next.lasting()),
            time: flight.end,
        };
        across_impacts(motion, &at, &mut before, &mut deviations)?;
    }
    Ok(deviations)
}

//! Whether a motion closes by another route than the one that made it (theory 19): each of its flights gone through once more, and each of its
//! instants by the law that holds there. What was made by half a period or by impulses alone is followed for a whole one so.

use crate::error::Result;
use crate::hybrid::{HybridMaps, ScaledUnits};
use crate::modal::ModalState;
use crate::orbit::orbit_data::OrbitArc;
use crate::tolerance::FLIGHTS_CLOSED;
use nalgebra::{DMatrix, DVector};

/// The largest growth of a scaled deviation by a Jacobian [-].
fn growth(units: ScaledUnits, jacobian: &DMatrix<f64>) -> f64 {
    let scaled = units.scaled(jacobian).abs();
    scaled.row_iter().map(|row| row.sum()).fold(1.0, f64::max)
}

/// The largest scaled distance by which a motion misses its own ends, where that is more than rounding explains; the unit is its size, but
/// no less than `least`. `once_more` is the end of a flight by the other route, and the state after each instant has to be what the law of the instant
/// makes of the state before. The completion of accumulating impacts is left out.
pub(in crate::orbit) fn closure_defect<M: HybridMaps>(
    motion: &M,
    flights: &[OrbitArc],
    state: impl Fn(&ModalState) -> DVector<f64>,
    least: [f64; 2],
    mut once_more: impl FnMut(usize) -> Result<DVector<f64>>,
) -> Result<Option<f64>> {
    let after: Vec<DVector<f64>> = flights.iter().map(|own| state(&own.after)).collect();
    let before: Vec<DVector<f64>> = flights.iter().map(|own| state(&own.before_next)).collect();
    let period = flights.iter().map(|flight| flight.span).sum();
    let units = ScaledUnits::no_less(least, after.iter().chain(&before), period);
    let apart = |by: DVector<f64>| units.size_of(by.iter(), 0.0);
    let is_rest = |flight: &OrbitArc| flight.accumulation().is_some();
    let mut worst = 0.0f64;
    for (k, flight) in flights.iter().enumerate() {
        let next = &flights[(k + 1) % flights.len()];
        let end = flight.end;
        let mut y = before[k].clone();
        if !next.hits().is_empty() {
            let none = &mut DMatrix::zeros(y.len(), 0);
            motion.impact(next.hits(), end, &mut y, none)?;
        }
        if is_rest(flight) {
            continue;
        }
        if !is_rest(next) {
            let jump = apart(y - &after[(k + 1) % flights.len()]);
            worst = worst.max(if jump > FLIGHTS_CLOSED { jump } else { 0.0 });
        }
        let off = apart(once_more(k)? - &before[k]);
        if off > FLIGHTS_CLOSED {
            let mut jacobian = DMatrix::identity(before[k].len(), before[k].len());
            let span = (flight.start, end);
            motion.flow(flight.regime(), span, &mut after[k].clone(), &mut jacobian)?;
            let explained = FLIGHTS_CLOSED * growth(units, &jacobian);
            worst = worst.max(if off > explained { off } else { 0.0 });
        }
    }
    Ok((worst > 0.0).then_some(worst))
}

//! The instants of an itinerary as maps: what a transition does to a state and to deviations from it, and the condition at which it comes.

use crate::error::Result;
use crate::hybrid::chatter_map::{Chatter, complete, strike};
use crate::hybrid::maps::{GapAt, HybridMaps};
use crate::hybrid::scaled_units::ScaledUnits;
use crate::hybrid::timed::Timed;
use crate::law::{Stage, Transition};
use crate::tolerance::CENTRAL_DIFFERENCE_STEP;
use nalgebra::DVector;

/// Maps a state before a transition to the one after it; returns the impulses, and the accumulating impacts there.
pub(crate) fn pass<M: HybridMaps + ?Sized>(
    motion: &M,
    transition: &Transition,
    units: &ScaledUnits,
    y: &mut Timed,
) -> Result<(Vec<f64>, Option<Chatter>)> {
    Ok(match transition {
        Transition::Strike(stops) => (strike(motion, stops, y)?, None),
        Transition::Chatter(stop) => (Vec::new(), Some(complete(motion, *stop, units, y)?)),
        Transition::Release(_) | Transition::Nothing => (Vec::new(), None),
    })
}

/// The condition of a transition on a state before it and on its time, scaled, with what deviations make of it; none of a stop that is
/// struck, which has its own on the state after.
pub(crate) fn condition<M: HybridMaps + ?Sized>(
    motion: &M,
    stage: &Stage,
    units: &ScaledUnits,
    y: &Timed,
) -> Result<Option<(f64, DVector<f64>)>> {
    match stage.transition {
        Transition::Nothing | Transition::Strike(_) => Ok(None),
        Transition::Chatter(stop) => {
            let at = motion.gap(stop, y.time, &y.state)?;
            let scale = 1.0 / (at.gradient.amax() * units.position);
            let row = at.timed_deviations(&y.deviations, &y.delays);
            Ok(Some((at.gap * scale, row * scale)))
        }
        Transition::Release(stop) => {
            let GapAt { gradient, .. } = motion.gap(stop, y.time, &y.state)?;
            let scale = units.time / (gradient.amax() * units.velocity);
            let pull = |t: f64, x: &DVector<f64>| {
                let rate = motion.rate(&stage.regime, t, x)?;
                motion.gap_acceleration(stop, t, x, &rate)
            };
            let mut row = DVector::zeros(y.deviations.ncols());
            for (j, column) in y.deviations.column_iter().enumerate() {
                let size = units.size_of(column.iter(), y.delays[j]);
                if size > 0.0 {
                    let step = CENTRAL_DIFFERENCE_STEP / size;
                    let at = |s: f64| pull(y.time + s * y.delays[j], &(&y.state + column * s));
                    row[j] = (at(step)? - at(-step)?) / (2.0 * step) * scale;
                }
            }
            Ok(Some((pull(y.time, &y.state)? * scale, row)))
        }
    }
}

//! Deviations from a motion along its arcs and across its instants, at fixed times (theory 7): flow Jacobians and saltation matrices. Where the
//! times of instants are unknowns of their own, deviations of states and times go through the maps of `hybrid/instant.rs`.

use crate::error::Result;
use crate::hybrid::{HybridMaps, ScaledUnits, across, across_rest};
use crate::itinerary::arc::MotionArc;
use nalgebra::{DMatrix, DVector};

/// Transports deviations, columns of (q, v), over one period from just after the first instant. `order` has the stops of each instant one
/// after the other, but those held before it.
pub(crate) fn transport<M: HybridMaps>(
    motion: &M,
    order: &[Vec<usize>],
    arcs: &[MotionArc<DVector<f64>>],
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let period = arcs.iter().map(|arc| arc.end - arc.start).sum();
    let units = ScaledUnits::of(arcs.iter().map(|arc| &arc.after), period);
    let mut orders = order.iter().cycle().skip(1);
    let mut before = DVector::zeros(deviations.nrows());
    for (arc, next) in arcs.iter().zip(arcs.iter().cycle().skip(1)) {
        if let Some(stop) = arc.accumulation() {
            let (to, y) = ((stop, next.regime()), (&mut before, &mut *deviations));
            across_rest(motion, to, &units, arc.start, y)?;
            continue;
        }
        before.clone_from(&arc.after);
        let span = (arc.start, arc.end);
        motion.flow(arc.regime(), span, &mut before, deviations)?;
        let own = if next.hits().is_empty() {
            None
        } else {
            orders.next()
        };
        let own = own.map_or(&[][..], Vec::as_slice);
        let at = ((arc.regime(), next.regime()), arc.end);
        across(
            motion,
            (&next.stage.transition, own),
            at,
            &mut before,
            deviations,
        )?;
    }
    Ok(())
}

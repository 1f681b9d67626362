//! Deviations from a motion along its arcs and across its instants, at fixed times (theory 7): flow Jacobians and saltation matrices. Where the
//! times of instants are unknowns of their own, deviations of states and times go through the maps of `hybrid/instant.rs`.

use crate::error::Result;
use crate::hybrid::{HybridMaps, ScaledUnits, across, across_meeting, across_rest, place_left};
use crate::itinerary::arc::MotionArc;
use crate::law::{ElementState, Regime, Relaxation, Transition};
use nalgebra::{DMatrix, DVector, RowDVector};

/// The deviations of the place of an element that relaxes, at a time.
struct PlaceDeviations {
    element: usize,
    relaxation: Relaxation,
    time: f64,
    row: RowDVector<f64>,
}

impl PlaceDeviations {
    /// Those at a later time.
    fn at(&self, time: f64) -> RowDVector<f64> {
        &self.row * self.relaxation.left(time - self.time)
    }
}

/// The derivative of the map over one period from just after the first instant, in (q, v), and behind them in the places of the elements that
/// relax then and are met before they are back. `order` has the stops of each instant one after the other, but those held before it.
pub(crate) fn monodromy<M: HybridMaps + ?Sized>(
    motion: &M,
    order: &[Vec<usize>],
    arcs: &[MotionArc<DVector<f64>>],
) -> Result<DMatrix<f64>> {
    let period = arcs.iter().map(|arc| arc.end - arc.start).sum();
    let units = ScaledUnits::of(arcs.iter().map(|arc| &arc.after), period);
    let (two_n, out) = (arcs[0].after.len(), out_at_start(motion, arcs));
    let width = two_n + out.len();
    let mut deviations = DMatrix::identity(two_n, width);
    let unit = |(i, &(element, relaxation)): (usize, &(usize, Relaxation))| PlaceDeviations {
        element,
        relaxation,
        time: arcs[0].start,
        row: RowDVector::from_fn(width, |_, j| f64::from(u8::from(j == two_n + i))),
    };
    let mut places: Vec<PlaceDeviations> = out.iter().enumerate().map(unit).collect();
    let mut orders = order.iter().cycle().skip(1);
    let mut before = DVector::zeros(two_n);
    for (arc, next) in arcs.iter().zip(arcs.iter().cycle().skip(1)) {
        if let Some(stop) = arc.accumulation() {
            let y = (&mut before, &mut deviations);
            let regimes = [Regime::free(), next.regime()];
            across_rest(motion, (stop, regimes), &units, arc.start, y)?;
            continue;
        }
        before.clone_from(&arc.after);
        motion.flow(
            arc.regime(),
            (arc.start, arc.end),
            &mut before,
            &mut deviations,
        )?;
        let own = (!next.hits().is_empty()).then(|| orders.next()).flatten();
        let own = own.map_or(&[][..], Vec::as_slice);
        let (transition, at) = (
            &next.stage.transition,
            ((arc.regime(), next.regime()), arc.end),
        );
        match transition
            .met_again()
            .and_then(|element| places.iter().position(|own| own.element == element))
        {
            Some(known) => {
                let own = places.swap_remove(known);
                let columns = (&mut deviations, &own.at(arc.end));
                across_meeting(motion, (own.element, own.relaxation), at, &before, columns)?;
            }
            None => across(motion, (transition, own), at, &mut before, &mut deviations)?,
        }
        if let Some((element, relaxation)) = left(motion, transition) {
            let state = (arc.end, &before);
            let row = place_left(motion, (element, relaxation), state, (&deviations, None))?;
            places.push(PlaceDeviations {
                element,
                relaxation,
                time: arc.end,
                row,
            });
        }
    }
    let end = arcs[arcs.len() - 1].end;
    for (i, (element, _)) in out.iter().enumerate() {
        let own = places.iter().find(|own| own.element == *element);
        let row = own.expect("it is out at the end as at the start").at(end);
        deviations = deviations.insert_row(two_n + i, 0.0);
        deviations.set_row(two_n + i, &row);
    }
    Ok(deviations)
}

/// The element that begins to relax at a transition.
fn left<M: HybridMaps + ?Sized>(
    motion: &M,
    transition: &Transition,
) -> Option<(usize, Relaxation)> {
    let element = transition.left_to_relax()?;
    let law = motion.contact_law(element).by_state();
    Some((element, law.relaxation(ElementState::Relaxing)?))
}

/// The elements that relax at the start of a period and are met before they are back.
fn out_at_start<M: HybridMaps + ?Sized>(
    motion: &M,
    arcs: &[MotionArc<DVector<f64>>],
) -> Vec<(usize, Relaxation)> {
    let transitions: Vec<&Transition> = arcs.iter().map(|arc| &arc.stage.transition).collect();
    let all = transitions
        .iter()
        .filter_map(|transition| left(motion, transition));
    let is_out = |(element, _): &(usize, Relaxation)| {
        let own = |transition: &&&Transition| matches!(transition, Transition::Change(guard, _) if guard.element == *element);
        // At the start itself it is met in the period before.
        let first = transitions.iter().skip(1).find(own);
        first.is_some_and(|transition| transition.met_again().is_some())
    };
    let mut out: Vec<_> = all.filter(is_out).collect();
    out.sort_unstable_by_key(|own| own.0);
    out.dedup_by_key(|own| own.0);
    out
}

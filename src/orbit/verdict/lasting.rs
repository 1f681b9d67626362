//! What the rules of contact say of lasting contact: forces push; and of the low flights between impacts that accumulate,
//! whose extremum is a maximum and no touch.

use crate::error::Result;
use crate::event::levels::PropagatorLevels;
use crate::event::polynomial::Quartic;
use crate::event::walk::{FlightCheck, Sought, StopDepth, check_flight};
use crate::flow::{FlowRows, GapRow, LinearFlow, ModalScene, RegimeMotion, along, with_flow};
use crate::law::{ElementState, Guard, GuardKind, Transition};
use crate::modal::Pair;
use crate::model::Moment;
use crate::observer::Observer;
use crate::orbit::orbit_data::OrbitArc;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Rule};
use crate::tolerance::{FORCE_MARGIN, LOW_BOUNCE};
use std::sync::Arc;

/// Whether a flight between two contacts with one stop is a low one, drawn back at once: its extremum is a maximum. Gap, opening speed
/// and acceleration at both ends, which are alike: a long flight may begin with next to no speed, and end so.
pub(crate) fn is_low_bounce(start: [f64; 3], end: [f64; 3], span: f64, margin: f64) -> bool {
    let at_stop = start[0].abs() <= margin && end[0].abs() <= margin;
    let bend = start[2].abs().max(end[2].abs());
    let is_slow = start[1].max(-end[1]).max(bend * span) * span < LOW_BOUNCE * margin;
    at_stop && start[1] > 0.0 && end[1] < 0.0 && is_slow
}

/// Searches the flights of a linear scene in which stops are held: their contact forces, and the gaps of the other stops.
pub(crate) fn search_regimes(
    regimes: &[Arc<RegimeMotion>],
    (scene, phase): (&ModalScene, f64),
    margins: &[f64],
    flights: &[OrbitArc],
    found: &mut Admissibility,
    observer: &mut Observer,
) -> Result<()> {
    for (k, flight) in flights.iter().enumerate() {
        let next = &flights[(k + 1) % flights.len()];
        let known = regimes
            .iter()
            .find(|motion| motion.regime == *flight.regime());
        let Some(motion) = known else { continue };
        let angle = |t: f64| Moment::of_angle(scene.frequency * t + phase);
        with_flow!(&motion.flow, f => {
            let on_flow = |t: f64, state| {
                let (q, v) = scene.form.to_physical(state);
                let mut entered = Vec::new();
                let reduced = motion.reduce(&q, &v, angle(t));
                let place = |element| place_at(scene, flights, (k, t), element, &angle);
                let reduced = motion.with_places(reduced, place);
                f.state_from_modal(&reduced, angle(t), &mut entered);
                entered
            };
            let entered = on_flow(flight.start, &flight.after);
            let end = flight.end;
            let ended = on_flow(end, &flight.before_next);
            for (guard, quantity) in motion.guards() {
                let (stop, row) = (guard.element, f.gap_row(quantity));
                if guard.is_gap() {
                    let is_released = flight.departure() == Some(stop);
                    let stretch = SearchSpan { span: flight.span, margin: margins[stop], is_released };
                    let (skipped, check) = search_stretch(f, &row, &mut entered.clone(), stretch, observer)?;
                    let is_rigid = scene.geometry.laws[stop].is_rigid();
                    found.note_as(stop, flight.start + skipped, &check, |value| {
                        let guard = guard.kind;
                        if is_rigid { Rule::Passed } else { Rule::Changes { guard, value } }
                    });
                    continue;
                }
                let at = |state: &[Pair]| {
                    let mut derivatives = Vec::new();
                    f.derivatives(state, &mut derivatives);
                    row.model(&derivatives)
                };
                let margin = FORCE_MARGIN * at(&entered).size;
                let stretch = SearchSpan { span: flight.span, margin, is_released: false };
                let (_, check) = search_stretch(f, &row, &mut entered.clone(), stretch, observer)?;
                found.leave_open(stop, flight.start, &check);
                let lowest = check.violation.map(|lowest| (flight.start + lowest.time, lowest.gap));
                // The search leaves the end to what ends the flight: at the stop's own release the force is zero, anywhere else it has to push.
                let is_released = next.departure() == Some(stop) || is_ended_by(guard, next);
                let last = Some((end, at(&ended).c[0])).filter(|(_, force)| !is_released && *force < -margin);
                let worst = lowest.into_iter().chain(last).min_by(|a, b| a.1.total_cmp(&b.1));
                if let Some((time, value)) = worst {
                    let rule = match guard.kind {
                        GuardKind::Force => Rule::Holds { force: value },
                        guard => Rule::Changes { guard, value },
                    };
                    found.keep_worst(Breach { stop, time, depth: 0.0, rule });
                }
            }
        });
    }
    Ok(())
}

/// Whether a guard is what an arc begins with.
fn is_ended_by(guard: Guard, next: &OrbitArc) -> bool {
    matches!(next.stage.transition, Transition::Change(own, _) if own == guard)
}

/// The place of an element that relaxes, at a time on an arc of a period: it began where the body was, some arcs before.
fn place_at(
    scene: &ModalScene,
    arcs: &[OrbitArc],
    (k, t): (usize, f64),
    element: usize,
    angle: &impl Fn(f64) -> Moment,
) -> f64 {
    let count = arcs.len();
    let mut gone = t - arcs[k].start;
    for back in 0..count {
        let arc = &arcs[(k + count - back) % count];
        let begins =
            matches!(arc.stage.transition, Transition::Change(own, _) if own.element == element);
        if begins {
            let row = &scene.position_rows[element];
            let [moved, ..] = scene.stop_motion(element, angle(arc.start));
            let gap = scene.geometry.clearances[element] + moved - along(row, &arc.after);
            let law = scene.geometry.laws[element].by_state();
            let relaxation = law.relaxation(ElementState::Relaxing);
            return relaxation.map_or(0.0, |own| own.after(-gap, gone));
        }
        gone += arcs[(k + 2 * count - back - 1) % count].span;
    }
    0.0
}

/// The search of a quantity along a flight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchSpan {
    pub span: f64,
    pub margin: f64,
    /// Whether the quantity is the gap of a stop that is let go at the start.
    pub is_released: bool,
}

/// Searches a quantity along a flight for what lies below the margin. A gap that opens at a release has `h = h' = h'' = 0`
/// there: the search begins where `h''' s^3/6` has brought it out of the margin, which is returned too.
pub(crate) fn search_stretch<F: LinearFlow>(
    flow: &F,
    row: &GapRow,
    state: &mut [Pair],
    stretch: SearchSpan,
    observer: &mut Observer,
) -> Result<(f64, FlightCheck)> {
    let SearchSpan {
        span,
        margin,
        is_released,
    } = stretch;
    let mut skipped = 0.0;
    if is_released {
        let mut derivatives = Vec::new();
        flow.derivatives(state, &mut derivatives);
        let third = row.model(&derivatives).c[3];
        if third > 0.0 {
            skipped = (4.0 * margin / third).cbrt().min(span);
            let mut propagator = F::Propagator::default();
            flow.prepare(skipped, &mut propagator);
            flow.advance(&propagator, state);
        }
    }
    let mut levels = PropagatorLevels::new(flow);
    let sought = Sought {
        span: span - skipped,
        margin,
        stop_depth: StopDepth::FULL,
    };
    let check = check_flight(flow, &mut levels, row, state, sought, observer)?;
    Ok((skipped, check))
}

/// A contact force along one step: the step's start, its length, the force at the parts 0, 1/4, 1/2, 3/4 and 1 of it.
pub(crate) type ForceAlong = (f64, f64, [f64; 5]);

/// Judges the contact force of a stop: nowhere below zero by more than a margin, in parts of its size, or of its largest value if that is
/// more.
pub(crate) fn judge_force(
    stop: usize,
    along: &[ForceAlong],
    (margin, size): (f64, f64),
    found: &mut Admissibility,
) {
    let nodes = along.iter().flat_map(|(.., nodes)| nodes);
    let size = nodes.fold(size, |size, force| size.max(force.abs()));
    let mut worst = (0.0, f64::INFINITY);
    for &(start, h, nodes) in along {
        let quartic = Quartic::through(nodes);
        let (x, force) = quartic.lowest();
        if force < worst.1 {
            worst = (start + x * h, force);
        }
    }
    let (time, force) = worst;
    if force < -margin * size {
        found.keep_worst(Breach {
            stop,
            time,
            depth: 0.0,
            rule: Rule::Holds { force },
        });
    }
}

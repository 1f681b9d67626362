//! A loop taken apart: its flights as an orbit has them, impacts that accumulate one by one.

use crate::error::Result;
use crate::hybrid::{HybridMaps, project_onto};
use crate::law::{Regime, Stage, Transition};
use crate::orbit::contact_mode::ContactMode;
use crate::orbit::shooting::closure::{FlightEnd, ShootingState};
use nalgebra::DVector;

/// One flight, with its states (q, v) after the instant at its start and before the one at its end.
#[derive(Debug, Clone)]
pub(crate) struct ShootingFlight {
    pub start: f64,
    pub end: f64,
    /// The state (q, v) at its start, after the instant there, shape (2n,), [m, m/s].
    pub after: DVector<f64>,
    /// The state (q, v) at its end, before the instant there, shape (2n,), [m, m/s].
    pub before_next: DVector<f64>,
    pub mode: ContactMode,
}

/// The end of the flight before flight k.
fn opening(flight_ends: &[FlightEnd], k: usize) -> &FlightEnd {
    let count = flight_ends.len();
    &flight_ends[(k + count - 1) % count]
}

/// The flights of a loop in their order. They change smoothly with the loop; the completion of accumulating impacts may end a little before
/// it begins.
pub(crate) fn shooting_flights<M: HybridMaps + ?Sized>(
    stages: &[Stage],
    found: &ShootingState,
    flight_ends: &[FlightEnd],
    motion: &M,
) -> Result<Vec<ShootingFlight>> {
    let mut flights = Vec::with_capacity(stages.len());
    let mut push = |mode: ContactMode, (start, end), after: &_, before_next: &_| {
        flights.push(ShootingFlight {
            start,
            end,
            after: DVector::clone(after),
            before_next: DVector::clone(before_next),
            mode,
        });
    };
    for (k, stage) in stages.iter().enumerate() {
        let begun = found.starts[k];
        let mut mode = ContactMode::in_regime(stage.regime.clone());
        match &stage.transition {
            Transition::Nothing => mode.is_struck = stage.regime.is_free(),
            Transition::Release(stop) => mode.released = Some(*stop),
            Transition::Strike(_) => mode.is_struck = true,
            Transition::Chatter(stop) => {
                let chatter = opening(flight_ends, k).chatter.as_ref();
                let chatter = chatter.expect("completed at every instant where impacts accumulate");
                for (i, bounce) in chatter.bounces.iter().enumerate() {
                    let next = chatter.bounces.get(i + 1);
                    let (end, before_next) = next
                        .map_or((chatter.last_time, &chatter.last), |next| {
                            (next.time, &next.before)
                        });
                    let span = (bounce.time, end);
                    push(ContactMode::struck(), span, &bounce.after, before_next);
                }
                // The rest is over in no time: it begins without normal speed.
                let mut rest = chatter.last.clone();
                let regime = Regime::holding([*stop]);
                project_onto(motion, &regime, chatter.last_time, &mut rest)?;
                let span = (chatter.last_time, begun);
                push(ContactMode::rest_on(*stop), span, &rest, &found.states[k]);
            }
        }
        let mut after = found.states[k].clone();
        project_onto(motion, &stage.regime, begun, &mut after)?;
        let span = (begun, found.times[k + 1].max(begun));
        push(mode, span, &after, &flight_ends[k].before);
    }
    Ok(flights)
}

/// The flights of an orbit: a loop knows the end of impacts that are next to nothing no better than their speed, and it comes no earlier than
/// what is left of them begins.
pub(super) fn in_order(mut flights: Vec<ShootingFlight>) -> Vec<ShootingFlight> {
    for k in 1..flights.len() {
        let begun = flights[k - 1].start;
        if flights[k - 1].mode.is_chatter() && flights[k].start < begun {
            (flights[k - 1].end, flights[k].start) = (begun, begun);
            flights[k].end = flights[k].end.max(begun);
        }
    }
    flights
}

/// The stops struck at each instant of a period, and their impulses in this order.
pub(crate) fn struck_in_order(
    stages: &[Stage],
    flight_ends: &[FlightEnd],
) -> (Vec<Vec<usize>>, Vec<f64>) {
    let (mut instants, mut impulses) = (Vec::new(), Vec::new());
    for (k, stage) in stages.iter().enumerate() {
        let opening = opening(flight_ends, k);
        if let Transition::Strike(stops) = &stage.transition {
            instants.push(stops.clone());
            impulses.extend_from_slice(&opening.impulses);
        }
        if let (Transition::Chatter(stop), Some(chatter)) = (&stage.transition, &opening.chatter) {
            instants.extend(chatter.bounces.iter().map(|_| vec![*stop]));
            impulses.extend(chatter.bounces.iter().map(|bounce| bounce.impulse));
        }
    }
    (instants, impulses)
}

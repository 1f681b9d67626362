//! The impacts of a period, from the flights of an orbit and its impulses.

use crate::flow::{ModalScene, along};
use crate::impact::{Impact, wrapped};
use crate::modal::ModalState;
use crate::model::Moment;
use crate::orbit::orbit_data::OrbitArc;
use std::convert::Infallible;

/// The impacts of a period of a linear scene, instant by instant.
pub(crate) fn list_impacts(
    scene: &ModalScene,
    phase: f64,
    flights: &[OrbitArc],
    impulses: &[f64],
) -> Vec<Impact> {
    let law = |stop: usize, t: f64, before: &ModalState| -> std::result::Result<_, Infallible> {
        let at = Moment::new(t, scene.frequency * t + phase, scene.frequency);
        let receding = scene.stop_motion(stop, at)[1];
        let approach = along(&scene.velocity_rows[stop], before) - receding;
        Ok((approach, scene.geometry.law(stop).departure(approach)))
    };
    let Ok(impacts) = impacts_by(law, (scene.frequency, phase), flights, impulses);
    impacts
}

/// The impacts of a period, instant by instant; `law` gives the approach speed at a stop at the time and in the state before its impact,
/// and the departure after it.
pub(crate) fn impacts_by<E>(
    law: impl Fn(usize, f64, &ModalState) -> std::result::Result<(f64, f64), E>,
    (frequency, phase): (f64, f64),
    flights: &[OrbitArc],
    impulses: &[f64],
) -> std::result::Result<Vec<Impact>, E> {
    let mut impacts = Vec::with_capacity(impulses.len());
    let mut impulses = impulses.iter();
    for (k, flight) in flights.iter().enumerate() {
        let previous = &flights[(k + flights.len() - 1) % flights.len()].before_next;
        for (&stop, &impulse) in flight.hits().iter().zip(impulses.by_ref()) {
            let (approach, departure) = law(stop, flight.start, previous)?;
            impacts.push(Impact {
                time: flight.start,
                stop,
                approach,
                // The law of every stop struck, coupled or not, which the state after has to rounding; + 0.0: no minus zero.
                departure: departure + 0.0,
                impulse,
                phase: wrapped(frequency * flight.start + phase),
            });
        }
    }
    Ok(impacts)
}

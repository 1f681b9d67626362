//! Admissibility of an orbit (theory 6): the stops hit are approached and pushed, and no stop is passed at any other
//! time, by a search that proves what it passes over.

use crate::contact::walk::{Ladder, check_flight};
use crate::flow::LinearFlow;
use crate::modal::{ModalScene, Pair, along};
use crate::orbit::periodic_orbit::{Flight, Impact};

/// Margin within which a gap counts as touching, relative to the motion's size along the normal: what rounding makes of an
/// orbit's position, with room to spare.
const MARGIN: f64 = 2e-13;

/// Where and by how much an orbit breaks the rules of contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The stop.
    pub stop: usize,
    /// The time of the deepest point, or of the impact [s], counted from the first impact.
    pub time: f64,
    /// How far the stop is passed, in units of the gap; zero where an impulse pulls.
    pub depth: f64,
    /// The rule that is broken, in words.
    pub reason: String,
}

/// A touch within the margin, without an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// The stop.
    pub stop: usize,
    /// The time of the lowest point [s].
    pub time: f64,
    /// The gap there.
    pub gap: f64,
}

/// What the search of a whole period found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Admissibility {
    pub violation: Option<Violation>,
    pub touches: Vec<Touch>,
    /// An impact whose approach speed is within the margin of zero.
    pub has_grazing_impact: bool,
}

/// Searches every flight for every stop.
pub(crate) fn judge<F: LinearFlow>(
    flow: &F,
    scene: &ModalScene,
    ladder: &mut Ladder<F>,
    phase: f64,
    flights: &[Flight],
    impacts: &[Impact],
) -> Admissibility {
    let mut found = Admissibility::default();
    let margins: Vec<f64> = (0..scene.n_stops()).map(|i| MARGIN * motion_size(scene, i, flights)).collect();
    for impact in impacts {
        let stop = impact.stop;
        let slow = margins[stop] * scene.frequency;
        if impact.impulse < 0.0 || impact.approach < -slow {
            let (what, value) =
                if impact.impulse < 0.0 { ("needs a pulling impulse", impact.impulse) } else { ("is left, not approached", impact.approach) };
            keep_worst(&mut found.violation, Violation {
                stop,
                time: impact.time,
                depth: 0.0,
                reason: format!("stop {stop} {what} at its impact at t = {:.6} ({value:.3e})", impact.time),
            });
        } else if impact.approach <= slow {
            found.has_grazing_impact = true;
        }
    }
    let mut state: Vec<Pair> = Vec::new();
    for i in 0..scene.n_stops() {
        let row = flow.gap_row(scene.position_rows[i].clone(), scene.geometry.clearances[i]);
        for flight in flights {
            state.clone_from(&flight.after);
            let mut u = flow.phasor(scene.frequency * flight.start + phase);
            let check = check_flight(flow, ladder, &row, (&mut state, &mut u), flight.span, margins[i]);
            if let Some(lowest) = check.violation {
                let (time, depth) = (flight.start + lowest.time, -lowest.gap);
                let reason = format!("stop {i} is passed by {depth:.6e} at t = {time:.6}");
                keep_worst(&mut found.violation, Violation { stop: i, time, depth, reason });
            }
            if let Some(lowest) = check.graze {
                found.touches.push(Touch { stop: i, time: flight.start + lowest.time, gap: lowest.gap });
            }
        }
    }
    found
}

fn keep_worst(worst: &mut Option<Violation>, violation: Violation) {
    if worst.as_ref().is_none_or(|w| violation.depth > w.depth) {
        *worst = Some(violation);
    }
}

/// The size of the motion along one normal, as far as the states after the impacts show it.
fn motion_size(scene: &ModalScene, stop: usize, flights: &[Flight]) -> f64 {
    let row = &scene.position_rows[stop];
    let w = scene.frequency;
    flights
        .iter()
        .map(|flight| {
            let position: f64 = row.iter().zip(&flight.after).map(|(r, z)| (r[0] * z[0]).abs() + (r[1] * z[1]).abs()).sum();
            position + along(&scene.velocity_rows[stop], &flight.after).abs() / w
        })
        .fold(scene.geometry.clearances[stop].abs(), f64::max)
}

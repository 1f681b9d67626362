//! Whether an orbit keeps the rules of contact, from many samples of every gap along its flights.

use crate::look::Look;
use crate::script::{Event, Flight};
use crate::stepper::{motion, step};

/// Samples of a step.
const SAMPLES: usize = 8;

/// Where samples are what they are, beyond all that is rounding or a touch.
const CLEAR: f64 = 1e-6;

/// What the samples of an orbit say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// A rule is broken, beyond doubt: by so much.
    Broken(f64),
    /// All are kept, beyond doubt where it was looked.
    Kept,
    Unclear,
}

/// The least of all that must be positive, each in its own unit.
pub fn verdict(look: &Look<'_>) -> Verdict {
    let least = look
        .script
        .flights()
        .iter()
        .flat_map(|flight| [least_gap(look, flight), least_push(look, flight)])
        .fold(f64::INFINITY, f64::min);
    if least < -CLEAR {
        Verdict::Broken(least)
    } else if least > CLEAR {
        Verdict::Kept
    } else {
        Verdict::Unclear
    }
}

/// The least gap of a flight; next to an impact on its stop in parts of what it is at its speed.
fn least_gap(look: &Look<'_>, flight: &Flight) -> f64 {
    let x = look.state(flight.start, false);
    let all = motion(&look.body, flight.held, (flight.start, &x), flight.end);
    let faces: Vec<usize> = (0..look.body.faces().len())
        .filter(|face| flight.held != Some(*face))
        .collect();
    let mut least = f64::INFINITY;
    for pair in all.windows(2) {
        let ((start, x), (end, _)) = (&pair[0], &pair[1]);
        for k in 0..SAMPLES {
            let part = (k as f64 + 0.5) / SAMPLES as f64;
            let dt = part * (end - start);
            let y = step(&look.body, flight.held, (*start, x), dt);
            let weights = faces
                .iter()
                .map(|&face| look.body.gap(face, &y) / weight(look, flight, face, start + dt));
            least = weights.fold(least, f64::min);
        }
    }
    least
}

/// The size of a gap that is small because its stop is hit where the flight begins or ends.
fn weight(look: &Look<'_>, flight: &Flight, face: usize, time: f64) -> f64 {
    let rate = look.units[1] / look.units[0];
    let near = |late: f64, order: i32| (late.abs() * rate).min(1.0).powi(order);
    let mut weight = look.reach(face);
    if let Some(begun) = flight.begun {
        let late = time - flight.start;
        match begun.event {
            Event::Hit { face: own, impact } if own == face => {
                let is_slow = look.orbit.impacts()[impact].departure == 0.0;
                weight *= near(late, if is_slow { 2 } else { 1 });
            }
            Event::Release(own) if own == face => weight *= near(late, 3),
            _ => {}
        }
    }
    if let Some(over) = flight.over
        && matches!(over.event, Event::Hit { face: own, .. } if own == face)
    {
        weight *= near(flight.end - time, 1);
    }
    weight
}

/// The least of the speed before the impact that ends a flight and of the contact force on it, next to its release in parts of the
/// time to that.
fn least_push(look: &Look<'_>, flight: &Flight) -> f64 {
    let x = look.state(flight.start, false);
    let all = motion(&look.body, flight.held, (flight.start, &x), flight.end);
    let mut least = f64::INFINITY;
    if let Some((_, end)) = all.last()
        && let Some(over) = flight.over
        && let Event::Hit { face, .. } = over.event
    {
        least = -look.body.speed(face, end) / look.units[1];
    }
    if flight.held.is_none() {
        return least;
    }
    let force = |t: f64, x: &[f64]| look.body.acceleration(t, x, flight.held).1;
    let most = all.iter().map(|(t, x)| force(*t, x).abs());
    let most = most.fold(f64::MIN_POSITIVE, f64::max);
    let span = flight.end - flight.start;
    let pushes = all[..all.len() - 1]
        .iter()
        .map(|(t, x)| force(*t, x) / most / ((flight.end - t) / span));
    pushes.fold(least, f64::min)
}

//! Whether an orbit keeps the rules of contact, from many samples of every gap along its flights.

use crate::branches::look::Look;
use crate::branches::script::{Event, Flight};
use crate::branches::stepper::{motion, step, zero};

/// Samples of a step: a low bounce is over before it.
const SAMPLES: usize = 16;

/// Where samples are what they are, beyond all that is rounding or a touch.
const CLEAR: f64 = 1e-6;
/// The same of a gap where it turns: a hundred times the margin that the library says it has along flights that are integrated.
const DEEP: f64 = 1e-8;

/// Gaps of so small a size are what the motion is known to.
const BESIDE: f64 = 1e-4;

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

/// The least gap of a flight, at samples and where it turns; at those next to an impact on its stop in parts of what it is at
/// its speed.
fn least_gap(look: &Look<'_>, flight: &Flight) -> f64 {
    let faces = (0..look.body.faces().len()).filter(|face| flight.held != Some(*face));
    let mut least = f64::INFINITY;
    for face in faces {
        let reach = look.reach(face);
        let inside = |time: f64| time > flight.start && time < flight.end;
        for (time, x) in samples(look, flight).into_iter().flatten() {
            let weight = weight(look, flight, face, time);
            if inside(time) && weight > BESIDE {
                least = least.min(look.body.gap(face, &x) / reach / weight);
            }
        }
        let turns = turns(look, flight, face).into_iter();
        let gaps = turns.filter(|(time, _)| inside(*time));
        let parts = gaps.map(|(_, gap)| gap / reach * (CLEAR / DEEP));
        least = parts.fold(least, f64::min);
    }
    least
}

/// The states of a flight, with their times, of each step.
fn samples(look: &Look<'_>, flight: &Flight) -> Vec<Vec<(f64, Vec<f64>)>> {
    let x = look.state(flight.start, false);
    // A little more, as what is touched at the end of a period turns there.
    let late = if flight.over.is_none() {
        0.01 * (flight.end - flight.start)
    } else {
        0.0
    };
    let all = motion(
        &look.body,
        flight.held,
        (flight.start, &x),
        flight.end + late,
    );
    let steps = all.windows(2).map(|pair| {
        let ((start, x), (end, _)) = (&pair[0], &pair[1]);
        let at = |k: usize| {
            let dt = (end - start) * k as f64 / SAMPLES as f64;
            (start + dt, step(&look.body, flight.held, (*start, x), dt))
        };
        (0..=SAMPLES).map(at).collect()
    });
    steps.collect()
}

/// Where the gap of a stop turns from closing to opening on a flight, and what it is there.
pub fn turns(look: &Look<'_>, flight: &Flight, face: usize) -> Vec<(f64, f64)> {
    let mut all = Vec::new();
    for one in samples(look, flight) {
        let (start, x) = &one[0];
        let at = |time: f64| step(&look.body, flight.held, (*start, x), time - start);
        let speed = |time: f64| look.body.speed(face, &at(time));
        let closing: Vec<bool> = one
            .iter()
            .map(|(_, x)| look.body.speed(face, x) < 0.0)
            .collect();
        let pairs = (1..one.len()).filter(|&k| closing[k - 1] && !closing[k]);
        all.extend(pairs.map(|k| {
            let lowest = zero(speed, one[k - 1].0, one[k].0);
            (lowest, look.body.gap(face, &at(lowest)))
        }));
    }
    all
}

/// The size of a gap in parts of its reach, small where its stop is hit where the flight begins or ends.
fn weight(look: &Look<'_>, flight: &Flight, face: usize, time: f64) -> f64 {
    let rate = look.units[1] / look.units[0];
    let near = |late: f64, order: i32| (late.abs() * rate).min(1.0).powi(order);
    let mut weight = 1.0;
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

/// The least of the speed before the impact that ends a flight and of the contact force on it, next to its release in parts of
/// the time to that.
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

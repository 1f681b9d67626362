//! An orbit flight by flight: from its state behind an instant to the one before the next, and the laws that hold there.

use crate::branches::look::Look;
use crate::branches::script::Event;
use crate::branches::stepper::moved;

/// What an orbit misses its laws by, each in its own unit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Misses {
    /// The state at the end of a flight.
    pub end: f64,
    /// The gap of a stop that is hit, the contact force at a release.
    pub event: f64,
    /// The state behind an impact, its impulse and its speeds.
    pub law: f64,
}

impl Misses {
    pub fn worst(self) -> f64 {
        self.end.max(self.event).max(self.law)
    }
}

/// How an orbit keeps its laws.
pub fn misses(look: &Look<'_>) -> Misses {
    let mut all = Misses::default();
    for flight in look.script.flights() {
        let x = look.state(flight.start, false);
        let end = moved(&look.body, flight.held, (flight.start, &x), flight.end);
        // At the instant next to the period's end it is at its beginning.
        let stated = look.state(flight.end, true);
        all.end = all.end.max(look.distance(&end, &stated));
        let Some(over) = flight.over else {
            all.end = all.end.max(look.distance(&end, &x));
            continue;
        };
        let behind = look.state(over.time, false);
        match over.event {
            Event::Hit { face, impact } => {
                let own = &look.orbit.impacts()[impact];
                all.event = all
                    .event
                    .max(look.body.gap(face, &end).abs() / look.reach(face));
                let (after, impulse) = look.body.struck(face, &end);
                let approach = -look.body.speed(face, &end);
                let departure = look.body.speed(face, &after);
                let unit = look.mass(face) * look.units[1];
                let offs = [
                    look.distance(&after, &behind),
                    (impulse - own.impulse).abs() / unit,
                    (approach - own.approach).abs() / look.units[1],
                    (departure - own.departure).abs() / look.units[1],
                ];
                all.law = offs.into_iter().fold(all.law, f64::max);
            }
            Event::Release(face) => {
                let force = look.body.acceleration(flight.end, &end, flight.held).1;
                all.event = all.event.max(force.abs() / look.force(face));
                all.law = all.law.max(look.distance(&end, &behind));
            }
        }
    }
    all
}

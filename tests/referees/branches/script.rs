//! What happens along an orbit, and when, as the library has it: all that is taken from it besides states.

use vibroimpact::{Motion, PeriodicOrbit, SegmentKind};

/// What happens at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A stop is hit, of so many impacts.
    Hit {
        face: usize,
        impact: usize,
    },
    Release(usize),
}

/// An instant, and which stop is held behind it.
#[derive(Debug, Clone, Copy)]
pub struct Instant {
    pub time: f64,
    pub event: Event,
    pub held: Option<usize>,
}

/// The instants of a period in order of time.
#[derive(Debug, Clone)]
pub struct Script {
    pub period: f64,
    pub instants: Vec<Instant>,
}

/// Instants nearer than this part of the period are one.
const TOGETHER: f64 = 1e-12;

/// The script of an orbit, or why this referee has none.
pub fn script(orbit: &PeriodicOrbit) -> Result<Script, &'static str> {
    let period = orbit.period();
    let is_one = |a: f64, b: f64| (a - b).abs() <= TOGETHER * period;
    let hits = orbit.impacts().iter().enumerate();
    let hits = hits.map(|(impact, own)| Instant {
        time: own.time,
        event: Event::Hit {
            face: own.stop,
            impact,
        },
        held: None,
    });
    let mut instants: Vec<Instant> = hits.collect();
    let segments = orbit.segments().map_err(|_| "segments that are refused")?;
    for own in segments {
        let Some(stop) = own.stop.filter(|_| own.kind == SegmentKind::Stick) else {
            if own.kind == SegmentKind::Chatter {
                return Err("impacts that accumulate");
            }
            continue;
        };
        let landing = instants.iter_mut().find(|at| {
            matches!(at.event, Event::Hit { face, .. } if face == stop)
                && is_one(at.time, own.start)
        });
        landing.ok_or("a stay without a landing")?.held = Some(stop);
        instants.push(Instant {
            time: own.end,
            event: Event::Release(stop),
            held: None,
        });
    }
    instants.sort_by(|a, b| a.time.total_cmp(&b.time));
    let inside = |at: &Instant| matches!(at.event, Event::Hit { .. });
    for pair in instants.windows(2) {
        if is_one(pair[0].time, pair[1].time) {
            return Err("stops hit together");
        }
        if pair[0].held.is_some() && inside(&pair[1]) {
            return Err("an impact beside a stop that is held");
        }
    }
    let wraps = instants.last().is_some_and(|at| is_one(at.time, period));
    if wraps {
        return Err("a release at an impact");
    }
    Ok(Script { period, instants })
}

impl Script {
    /// The flights: of each where it starts, what is held, when it ends and the instant there; one, without an instant, where
    /// nothing happens.
    pub fn flights(&self) -> Vec<Flight> {
        let whole = Flight {
            start: 0.0,
            begun: None,
            held: None,
            end: self.period,
            over: None,
        };
        if self.instants.is_empty() {
            return vec![whole];
        }
        let each = self.instants.iter().enumerate();
        let flight = |(k, own): (usize, &Instant)| {
            let next = (k + 1) % self.instants.len();
            let late = if next == 0 { self.period } else { 0.0 };
            Flight {
                start: own.time,
                begun: Some(*own),
                held: own.held,
                end: self.instants[next].time + late,
                over: Some(self.instants[next]),
            }
        };
        each.map(flight).collect()
    }
}

/// A part of a period in which nothing happens.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    pub start: f64,
    pub begun: Option<Instant>,
    pub held: Option<usize>,
    pub end: f64,
    pub over: Option<Instant>,
}

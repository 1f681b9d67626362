//! The referee's simulator: slow, in double-double numbers, from node to node. Every minimum of every gap and every fall of a
//! contact force is found on the Taylor polynomial of a step; impacts that accumulate are gone through one by one, down to
//! flights of `1e-9` of the fastest motion's time, whose rest is the geometric series.

use crate::runs::double_double::Dd;
use crate::runs::instants::SEVERAL;
use crate::runs::motion::{Model, Motion};
use crate::runs::polynomial::{first_fall, polish};
use crate::runs::record::{Record, Stretch};
use std::collections::HashMap;
use std::rc::Rc;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    Open,
    /// In lasting contact.
    Held,
    /// The gap has a zero of this order at the present instant, and opens.
    Leaving(usize),
}

#[derive(Clone, Copy)]
enum Event {
    Touch(usize),
    Release,
}

/// How far ahead, in steps, the sign of a force or gap is looked at that vanishes now.
pub const AHEAD: f64 = 1e-6;
/// Gaps in double-double numbers below this part of their terms are closed.
pub const CLOSED: f64 = 1e-22;

/// What a computation in doubles cannot know better, for the runs aside.
#[derive(Debug, Clone, Copy)]
pub struct Roughness {
    /// Impacts that accumulate are completed where the error of doing so is below this part of the motion.
    pub completion: f64,
    /// Or below this.
    pub least: f64,
    /// By what part of its terms a gap is off at a contact.
    pub gap: f64,
    /// Size of positions that the motion is the small difference of.
    pub terms: f64,
    /// Which pattern the signs of the gaps' errors have.
    pub pattern: u64,
}

/// The bits of a number without its pattern.
pub fn scattered(number: u64) -> u64 {
    number.wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

pub struct Run<'a> {
    pub model: &'a Model,
    pub motions: HashMap<Vec<usize>, Option<Rc<Motion>>>,
    pub x: Vec<Dd>,
    pub time: Dd,
    pub contacts: Vec<Contact>,
    /// Independent stops whose forces are the unknowns of lasting contact; the others held follow from them.
    pub held: Vec<usize>,
    pub since: Vec<Option<Dd>>,
    /// Which stops were left at rest by the rounding of an impact that was almost none.
    pub faded: Vec<bool>,
    pub samples: &'a [Dd],
    pub roughness: Option<Roughness>,
    pub record: Record,
    /// Changes of contact since the time last went on.
    pub at_once: usize,
}

/// Follows a motion over a time, with states at given times (ascending, from 0).
pub fn follow(
    model: &Model,
    start: Vec<Dd>,
    duration: Dd,
    samples: &[Dd],
    roughness: Option<Roughness>,
    most_hits: usize,
) -> Record {
    let k = model.stops.len();
    let mut run = Run {
        model,
        motions: HashMap::new(),
        x: start,
        time: Dd::ZERO,
        contacts: vec![Contact::Open; k],
        held: Vec::new(),
        since: vec![None; k],
        faded: vec![false; k],
        samples,
        roughness,
        record: Record::default(),
        at_once: 0,
    };
    run.begin();
    // Nodes, and events between them: what never gets on is not waited for.
    let nodes = (duration.to_f64() / model.step).ceil();
    let mut left = 10.0 * nodes + 1e5;
    while run.time < duration && run.record.stopped.is_none() {
        if run.record.hits.len() > most_hits {
            run.stop("too many impacts");
            break;
        }
        if left <= 0.0 {
            run.stop("too many events");
            break;
        }
        left -= 1.0;
        run.step(duration);
    }
    run.finish()
}

impl Run<'_> {
    pub fn stop(&mut self, reason: &'static str) {
        if self.record.stopped.is_none() {
            self.record.stopped = Some((self.time.to_f64(), reason));
        }
    }

    pub fn doubt(&mut self, reason: &'static str) {
        self.record.doubts.push((self.time.to_f64(), reason));
    }

    pub fn motion(&mut self, held: &[usize]) -> Option<Rc<Motion>> {
        let model = self.model;
        self.motions
            .entry(held.to_vec())
            .or_insert_with(|| Motion::new(model, held).map(Rc::new))
            .clone()
    }

    /// Size of the terms of a gap.
    pub fn size(&self, stop: usize) -> f64 {
        let plane = &self.model.stops[stop];
        let terms = plane
            .normal
            .iter()
            .zip(&self.x)
            .map(|(n, q)| (*n * *q).abs().to_f64());
        plane.clearance.abs().to_f64() + terms.sum::<f64>()
    }

    pub fn speed_size(&self) -> f64 {
        self.x[self.model.n..2 * self.model.n]
            .iter()
            .map(|v| v.abs().to_f64())
            .fold(self.record.v_size, f64::max)
    }

    pub fn begin(&mut self) {
        let touching = (0..self.contacts.len())
            .filter(|&i| self.model.gap(i, &self.x).abs().to_f64() <= 1e-13 * self.size(i));
        let touching: Vec<usize> = touching.collect();
        self.measure();
        self.strike(&touching);
    }

    pub fn measure(&mut self) {
        let n = self.model.n;
        let largest = |x: &[Dd]| x.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max);
        self.record.q_size = self.record.q_size.max(largest(&self.x[..n]));
        self.record.v_size = self.record.v_size.max(largest(&self.x[n..2 * n]));
    }

    /// One node on, or up to the first event before it.
    pub fn step(&mut self, duration: Dd) {
        let held = self.held.clone();
        let motion = self.motion(&held).expect("independent stops");
        let step = self.model.step;
        let remaining = duration - self.time;
        let is_full = remaining.to_f64() > step;
        let end = if is_full {
            1.0
        } else {
            remaining.to_f64() / step
        };
        let (mut first, mut event) = (Dd::from(end), None);
        let rough: Vec<f64> = self.x.iter().map(|x| x.to_f64()).collect();
        for stop in 0..self.contacts.len() {
            let order = match self.contacts[stop] {
                Contact::Held => continue,
                Contact::Leaving(order) => order,
                Contact::Open if motion.stays_open(stop, &rough) => continue,
                Contact::Open => 0,
            };
            let series = motion.gap_series(stop, &self.x);
            if let Some(at) = self.fall_of_gap(stop, &series[order..], order, end)
                && at < first
            {
                (first, event) = (at, Some(Event::Touch(stop)));
            }
        }
        for k in 0..motion.held.len() {
            let series = motion.force_series(k, &self.x);
            if let Some(at) = self.fall_of_force(&series, end)
                && at < first
            {
                (first, event) = (at, Some(Event::Release));
            }
        }
        let passed = if event.is_none() && !is_full {
            remaining
        } else {
            first * step
        };
        self.sample(&motion, passed);
        self.x = if event.is_none() && is_full {
            motion.step(&self.x)
        } else {
            motion.advance(&self.x, passed)
        };
        let before = self.time.to_f64();
        self.time += passed;
        self.measure();
        if self.is_one_of_several() {
            self.record.doubts.push((before, SEVERAL));
        }
        for contact in &mut self.contacts {
            if let Contact::Leaving(_) = contact {
                *contact = Contact::Open;
            }
        }
        if passed.to_f64() > 1e-14 * step {
            self.at_once = 0;
        } else {
            self.at_once += 1;
            if self.at_once > 100 {
                return self.stop("contacts change without end at one instant");
            }
        }
        match event {
            None => {}
            Some(Event::Touch(stop)) => self.touch(stop),
            Some(Event::Release) => {
                let before = (self.contacts.clone(), self.held.clone());
                let all: Vec<usize> = self.held_stops();
                self.settle(&all);
                if before == (self.contacts.clone(), self.held.clone()) {
                    self.stop("a force falls and nothing is let go");
                }
            }
        }
    }

    pub fn held_stops(&self) -> Vec<usize> {
        (0..self.contacts.len())
            .filter(|&i| self.contacts[i] == Contact::Held)
            .collect()
    }

    /// Where a gap falls through zero, its zero of the given order at the left end divided out.
    pub fn fall_of_gap(
        &mut self,
        stop: usize,
        series: &[Dd],
        order: usize,
        end: f64,
    ) -> Option<Dd> {
        let rough: Vec<f64> = series.iter().map(|c| c.to_f64()).collect();
        let fall = first_fall(&rough, end, 0.0);
        let (size, largest) = (
            self.size(stop),
            rough.iter().fold(0.0, |m: f64, c| m.max(c.abs())),
        );
        for &(at, value) in &fall.minima {
            let is_low = value.abs() < 1e-4 * largest
                && (0..order).fold(value.abs(), |gap, _| gap * at) < 1e-13 * size;
            if is_low {
                let time = self.time.to_f64() + at * self.model.step;
                self.record.doubts.push((time, "a graze"));
            }
        }
        fall.bracket.map(|bracket| polish(series, bracket))
    }

    pub fn fall_of_force(&mut self, series: &[Dd], end: f64) -> Option<Dd> {
        let rough: Vec<f64> = series.iter().map(|c| c.to_f64()).collect();
        let largest = rough.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        self.record.force_size = self.record.force_size.max(largest);
        let margin = 1e-24 * self.record.force_size;
        if largest <= margin {
            return None;
        }
        let fall = first_fall(&rough, end, margin);
        for &(at, value) in &fall.minima {
            if value.abs() < 1e-12 * self.record.force_size {
                let time = self.time.to_f64() + at * self.model.step;
                self.record
                    .doubts
                    .push((time, "a contact force that touches zero"));
            }
        }
        fall.bracket.map(|bracket| polish(series, bracket))
    }

    /// States at the times of the samples within what is passed.
    pub fn sample(&mut self, motion: &Motion, passed: Dd) {
        while let Some(&time) = self.samples.get(self.record.samples.len()) {
            if time >= self.time + passed {
                break;
            }
            let x = motion.advance(&self.x, time - self.time);
            self.record
                .samples
                .push(x[..2 * self.model.n].iter().map(|x| x.to_f64()).collect());
        }
    }

    pub fn finish(mut self) -> Record {
        for (stop, since) in self.since.clone().into_iter().enumerate() {
            if let Some(start) = since {
                self.record.sticks.push(Stretch {
                    stop,
                    start: start.to_f64(),
                    end: self.time.to_f64(),
                });
            }
        }
        self.record
            .sticks
            .sort_by(|a, b| a.start.total_cmp(&b.start).then(a.stop.cmp(&b.stop)));
        self.record.end = self.time.to_f64();
        self.record
    }
}

//! The referee's simulator: slow, in double-double numbers, from node to node. Every minimum of every gap and every fall of a
//! contact force is found on the Taylor polynomial of a step; impacts that accumulate are gone through one by one, down to
//! flights of `1e-9` of the fastest motion's time, whose rest is the geometric series.

use crate::double_double::{Dd, Matrix, dot};
use crate::law::{complementary, impulses};
use crate::motion::{Model, Motion};
use crate::polynomial::{first_fall, polish};
use crate::record::{Hit, Record, Stretch};
use std::collections::HashMap;
use std::rc::Rc;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Contact {
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
const AHEAD: f64 = 1e-6;
/// Gaps in double-double numbers below this part of their terms are closed.
const CLOSED: f64 = 1e-22;

/// What a computation in doubles cannot know better, for the runs aside.
#[derive(Debug, Clone, Copy)]
pub struct Roughness {
    /// Impacts that accumulate are completed where the error of doing so is below this part of the motion.
    pub completion: f64,
    /// By what part of its terms a gap is off at a contact.
    pub gap: f64,
}

pub struct Run<'a> {
    model: &'a Model,
    motions: HashMap<Vec<usize>, Option<Rc<Motion>>>,
    x: Vec<Dd>,
    time: Dd,
    contacts: Vec<Contact>,
    /// Independent stops whose forces are the unknowns of lasting contact; the others held follow from them.
    held: Vec<usize>,
    since: Vec<Option<Dd>>,
    samples: &'a [Dd],
    roughness: Option<Roughness>,
    record: Record,
    /// Changes of contact since the time last went on.
    at_once: usize,
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
        samples,
        roughness,
        record: Record::default(),
        at_once: 0,
    };
    run.begin();
    while run.time < duration && run.record.stopped.is_none() {
        if run.record.hits.len() > most_hits {
            run.stop("too many impacts");
            break;
        }
        run.step(duration);
    }
    run.finish()
}

impl Run<'_> {
    fn stop(&mut self, reason: &'static str) {
        if self.record.stopped.is_none() {
            self.record.stopped = Some((self.time.to_f64(), reason));
        }
    }

    fn doubt(&mut self, reason: &'static str) {
        self.record.doubts.push((self.time.to_f64(), reason));
    }

    fn motion(&mut self, held: &[usize]) -> Option<Rc<Motion>> {
        let model = self.model;
        self.motions
            .entry(held.to_vec())
            .or_insert_with(|| Motion::new(model, held).map(Rc::new))
            .clone()
    }

    /// Size of the terms of a gap.
    fn size(&self, stop: usize) -> f64 {
        let plane = &self.model.stops[stop];
        let terms = plane
            .normal
            .iter()
            .zip(&self.x)
            .map(|(n, q)| (*n * *q).abs().to_f64());
        plane.clearance.abs().to_f64() + terms.sum::<f64>()
    }

    fn speed_size(&self) -> f64 {
        self.x[self.model.n..2 * self.model.n]
            .iter()
            .map(|v| v.abs().to_f64())
            .fold(self.record.v_size, f64::max)
    }

    fn begin(&mut self) {
        let touching = (0..self.contacts.len())
            .filter(|&i| self.model.gap(i, &self.x).abs().to_f64() <= 1e-13 * self.size(i));
        let touching: Vec<usize> = touching.collect();
        self.measure();
        self.strike(&touching);
    }

    fn measure(&mut self) {
        let n = self.model.n;
        let largest = |x: &[Dd]| x.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max);
        self.record.q_size = self.record.q_size.max(largest(&self.x[..n]));
        self.record.v_size = self.record.v_size.max(largest(&self.x[n..2 * n]));
    }

    /// One node on, or up to the first event before it.
    fn step(&mut self, duration: Dd) {
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
        self.time += passed;
        self.measure();
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

    fn held_stops(&self) -> Vec<usize> {
        (0..self.contacts.len())
            .filter(|&i| self.contacts[i] == Contact::Held)
            .collect()
    }

    /// Where a gap falls through zero, its zero of the given order at the left end divided out.
    fn fall_of_gap(&mut self, stop: usize, series: &[Dd], order: usize, end: f64) -> Option<Dd> {
        let rough: Vec<f64> = series.iter().map(|c| c.to_f64()).collect();
        let fall = first_fall(&rough, end, 0.0);
        let (size, largest) = (
            self.size(stop),
            rough.iter().fold(0.0, |m: f64, c| m.max(c.abs())),
        );
        for &(at, value) in &fall.minima {
            let is_low =
                value.abs() < 1e-4 * largest && value.abs() * at.powi(order as i32) < 1e-13 * size;
            if is_low {
                let time = self.time.to_f64() + at * self.model.step;
                self.record.doubts.push((time, "a graze"));
            }
        }
        fall.bracket.map(|bracket| polish(series, bracket))
    }

    fn fall_of_force(&mut self, series: &[Dd], end: f64) -> Option<Dd> {
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
    fn sample(&mut self, motion: &Motion, passed: Dd) {
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

    /// A gap closes.
    fn touch(&mut self, stop: usize) {
        self.blur(stop);
        self.near_place(stop);
        let touching: Vec<usize> = (0..self.contacts.len())
            .filter(|&i| {
                i == stop
                    || self.contacts[i] == Contact::Held
                    || self.model.gap(i, &self.x).abs().to_f64() <= CLOSED * self.size(i)
            })
            .collect();
        self.strike(&touching);
    }

    /// Shifts a contact by what the rounding of its gap does to its time.
    fn blur(&mut self, stop: usize) {
        let Some(roughness) = self.roughness else {
            return;
        };
        let held = self.held.clone();
        let motion = self.motion(&held).expect("independent stops");
        let a = dot(
            &self.model.stops[stop].normal,
            &motion.acceleration(&self.x),
        );
        let speed = -self.model.opening(stop, &self.x).to_f64();
        let depth = roughness.gap * self.size(stop);
        if speed > 0.0 && speed * speed > 10.0 * a.abs().to_f64() * depth.abs() {
            let shift = Dd::from(depth / speed);
            self.x = motion.advance(&self.x, shift);
            self.time += shift;
        }
    }

    /// Another stop that closes at practically this place, and depends on this one: which is hit is one of rounding.
    fn near_place(&mut self, stop: usize) {
        let g = &self.model.delassus;
        let is_near = (0..self.contacts.len()).any(|j| {
            let gap = self.model.gap(j, &self.x).to_f64();
            j != stop
                && self.contacts[j] == Contact::Open
                && (g.rows[stop][j] != Dd::ZERO || g.rows[j][stop] != Dd::ZERO)
                && self.model.opening(j, &self.x) < Dd::ZERO
                && gap.abs() > CLOSED * self.size(j)
                && gap < 1e-13 * self.size(j)
        });
        if is_near {
            self.doubt("two stops at almost one place");
        }
    }

    /// Impulses of the stops in contact, then what stays in contact.
    fn strike(&mut self, touching: &[usize]) {
        let part: Vec<Vec<Dd>> = touching
            .iter()
            .map(|&i| {
                touching
                    .iter()
                    .map(|&j| self.model.delassus.rows[i][j])
                    .collect()
            })
            .collect();
        let opening: Vec<Dd> = touching
            .iter()
            .map(|&i| match self.contacts[i] {
                Contact::Held => Dd::ZERO,
                _ => self.opening_at_contact(i),
            })
            .collect();
        let restitution: Vec<f64> = touching
            .iter()
            .map(|&i| self.model.stops[i].restitution)
            .collect();
        let reach = touching
            .iter()
            .flat_map(|&i| &self.model.stops[i].normal)
            .map(|x| x.abs().to_f64())
            .fold(0.0, f64::max);
        let scale = reach * self.speed_size();
        let accelerations = self.model.free.times(&self.x);
        let result = impulses(&Matrix { rows: part }, &opening, &restitution, scale);
        if let Some(reason) = result.doubt {
            self.doubt(reason);
            if result.opening.iter().any(|s| s.to_f64() < -CLOSED * scale) {
                return self.stop(reason);
            }
        }
        let n = self.model.n;
        for (&i, &p) in touching.iter().zip(&result.impulses) {
            for (v, &b) in self.x[n..2 * n]
                .iter_mut()
                .zip(&self.model.stops[i].reaction)
            {
                *v -= b * p;
            }
        }
        let mut hit = Vec::new();
        for (k, &i) in touching.iter().enumerate() {
            if result.impulses[k] > Dd::ZERO {
                self.near_coincidence(i);
                hit.push(i);
                self.record.hits.push(Hit {
                    time: self.time,
                    stop: i,
                    approach: -opening[k].to_f64(),
                    departure: result.opening[k].to_f64(),
                    impulse: result.impulses[k].to_f64(),
                    curvature: -dot(&self.model.stops[i].normal, &accelerations).to_f64(),
                    rounds: if result.is_shared { 0 } else { result.rounds },
                });
            }
        }
        let mut stays = Vec::new();
        for (k, &i) in touching.iter().enumerate() {
            if result.opening[k].to_f64() > 0.0 {
                self.leave(i, 1);
            } else {
                stays.push(i);
            }
        }
        self.settle(&stays);
        if let [stop] = hit[..]
            && self.contacts[stop] == Contact::Leaving(1)
        {
            self.complete(stop);
        }
    }

    /// The opening speed; at the start what is zero but for the rounding of the velocity given is zero.
    fn opening_at_contact(&self, stop: usize) -> Dd {
        let opening = self.model.opening(stop, &self.x);
        let terms = self.model.stops[stop]
            .normal
            .iter()
            .zip(&self.x[self.model.n..]);
        let size: f64 = terms.map(|(n, v)| (*n * *v).abs().to_f64()).sum();
        let is_rounding = self.time == Dd::ZERO && opening.abs().to_f64() <= 1e-15 * size;
        if is_rounding { Dd::ZERO } else { opening }
    }

    /// Stops that depend on each other and are hit almost together: their order is one of rounding.
    fn near_coincidence(&mut self, stop: usize) {
        let g = &self.model.delassus;
        let near = self
            .record
            .hits
            .iter()
            .rev()
            .take_while(|hit| ((self.time - hit.time).to_f64() * self.model.rate) < 1e-10);
        let is_near = near.into_iter().any(|hit| {
            let j = hit.stop;
            j != stop
                && hit.time != self.time
                && (g.rows[stop][j] != Dd::ZERO || g.rows[j][stop] != Dd::ZERO)
        });
        if is_near {
            self.doubt("two stops hit almost together");
        }
    }

    fn leave(&mut self, stop: usize, order: usize) {
        if let Some(start) = self.since[stop].take() {
            self.record.sticks.push(Stretch {
                stop,
                start: start.to_f64(),
                end: self.time.to_f64(),
            });
        }
        self.contacts[stop] = Contact::Leaving(order);
    }

    /// Which of the stops in contact with no normal speed stay, by the signs of forces and accelerations just ahead.
    fn settle(&mut self, stays: &[usize]) {
        let delassus = Matrix {
            rows: stays
                .iter()
                .map(|&i| {
                    stays
                        .iter()
                        .map(|&j| self.model.delassus.rows[i][j])
                        .collect()
                })
                .collect(),
        };
        let ahead = Dd::from(AHEAD * self.model.step);
        let mut held: Vec<usize> = stays
            .iter()
            .copied()
            .filter(|i| self.held.contains(i))
            .collect();
        let mut is_settled = false;
        for _ in 0..12 {
            let Some(motion) = self.motion(&held) else {
                held.clear();
                continue;
            };
            let y = motion.advance(&self.x, ahead);
            let free = self.model.free.times(&y);
            let pull: Vec<Dd> = stays
                .iter()
                .map(|&i| dot(&self.model.stops[i].normal, &free))
                .collect();
            let scale = free.iter().map(|a| a.abs().to_f64()).fold(0.0, f64::max);
            let solutions = complementary(&delassus, &pull, scale);
            let Some(forces) = solutions.first() else {
                return self.stop("no contact forces solve the law");
            };
            let effect = delassus.times(forces);
            if solutions.iter().any(|f| {
                delassus
                    .times(f)
                    .iter()
                    .zip(&effect)
                    .any(|(a, b)| (*a - *b).abs().to_f64() > 1e-15 * scale)
            }) {
                self.doubt("several sets of contact forces solve the law");
            }
            let mut next = Vec::new();
            for (k, &i) in stays.iter().enumerate() {
                if forces[k] > Dd::ZERO {
                    next.push(i);
                }
            }
            for (k, &i) in stays.iter().enumerate() {
                let opens = (effect[k] - pull[k]).to_f64();
                if !next.contains(&i) && opens.abs() <= 1e-19 * scale {
                    let mut more = next.clone();
                    more.push(i);
                    more.sort_unstable();
                    if self.motion(&more).is_some() {
                        next = more;
                    }
                }
            }
            if next == held {
                is_settled = true;
                break;
            }
            held = next;
        }
        if !is_settled {
            return self.stop("contact forces do not settle");
        }
        self.held.clone_from(&held);
        let motion = self.motion(&held).expect("settled");
        let y = motion.advance(&self.x, ahead);
        let a = motion.acceleration(&y);
        let scale = self
            .model
            .free
            .times(&y)
            .iter()
            .map(|a| a.abs().to_f64())
            .fold(0.0, f64::max);
        for &i in stays {
            let opens = -dot(&self.model.stops[i].normal, &a).to_f64();
            if held.contains(&i) || opens.abs() <= 1e-19 * scale {
                self.since[i].get_or_insert(self.time);
                self.contacts[i] = Contact::Held;
            } else {
                let series = motion.gap_series(i, &self.x);
                let weight = |k: usize| series[k].abs().to_f64() * AHEAD.powi(k as i32);
                let order = (2..8)
                    .max_by(|&a, &b| weight(a).total_cmp(&weight(b)))
                    .expect("not empty");
                if series[order].to_f64() < 0.0 {
                    self.doubt("a gap opens and closes at once");
                }
                self.leave(i, order);
            }
        }
    }

    /// The rest of impacts that accumulate, as a geometric series, once its flights are short enough.
    fn complete(&mut self, stop: usize) {
        let e = self.model.stops[stop].restitution;
        let held = self.held.clone();
        let motion = self.motion(&held).expect("settled");
        let accelerations = motion.acceleration(&self.x);
        let curvature = |i: usize| -dot(&self.model.stops[i].normal, &accelerations).to_f64();
        let (speed, a) = (self.model.opening(stop, &self.x), curvature(stop));
        if e >= 1.0 || e == 0.0 || a >= 0.0 {
            return;
        }
        let flight = 2.0 * speed.to_f64() / -a;
        let duration = flight / (1.0 - e);
        let mut is_short = flight * self.model.rate < 1e-9;
        if let Some(roughness) = self.roughness {
            let previous = self
                .record
                .hits
                .iter()
                .rev()
                .skip(1)
                .find(|hit| hit.stop == stop);
            let is_regular =
                previous.is_some_and(|hit| (speed.to_f64() / hit.departure / e - 1.0).abs() < 0.05);
            let residual = 8.0 * speed.to_f64().powi(2) / (e * (1.0 - e)) / -a;
            is_short |= is_regular
                && residual < roughness.completion * self.size(stop).max(self.record.q_size);
        }
        let others_stay = (0..self.contacts.len()).all(|i| {
            if i == stop || self.contacts[i] == Contact::Held {
                return true;
            }
            let (gap, opening, bend) = (
                self.model.gap(i, &self.x).to_f64(),
                self.model.opening(i, &self.x).to_f64(),
                curvature(i),
            );
            match self.contacts[i] {
                Contact::Leaving(_) => bend >= 0.0 || 2.0 * opening / -bend > 2.0 * duration,
                _ => gap > 2.0 * duration * (opening.abs() + duration * bend.abs()),
            }
        });
        let mut all = held;
        all.push(stop);
        all.sort_unstable();
        if !is_short || !others_stay || duration > 0.5 * self.model.step {
            return;
        }
        let Some(motion) = self.motion(&all) else {
            return;
        };
        // The normal speeds vanish; the held motion takes the time of the series.
        let inner = Matrix {
            rows: all
                .iter()
                .map(|&i| {
                    all.iter()
                        .map(|&j| self.model.delassus.rows[i][j])
                        .collect()
                })
                .collect(),
        };
        let closing: Vec<Dd> = all
            .iter()
            .map(|&i| -self.model.opening(i, &self.x))
            .collect();
        let Some(p) = inner.solve(&closing) else {
            return;
        };
        let n = self.model.n;
        for (&i, &p) in all.iter().zip(&p) {
            for (v, &b) in self.x[n..2 * n]
                .iter_mut()
                .zip(&self.model.stops[i].reaction)
            {
                *v -= b * p;
            }
        }
        let passed = speed * 2.0 / Dd::from(-a) / (Dd::ONE - Dd::from(e));
        self.sample(&motion, passed);
        self.x = motion.advance(&self.x, passed);
        let start = self.time.to_f64();
        self.time += passed;
        self.record.chatters.push(Stretch {
            stop,
            start,
            end: self.time.to_f64(),
        });
        let mut stays = self.held_stops();
        stays.push(stop);
        self.settle(&stays);
    }

    fn finish(mut self) -> Record {
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
        self.record.last = self.x[..2 * self.model.n]
            .iter()
            .map(|x| x.to_f64())
            .collect();
        self.record
    }
}

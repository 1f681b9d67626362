//! A slow run of a chain: extrapolated midpoint steps that are much shorter than the motion, gaps looked at at the end of each
//! and where they turn, and a halt as soon as an answer is not this referee's to give.

use crate::extrapolated::extrapolated;
use crate::pendulums::chain::Chain;

/// Step, relative to the fastest turn.
const STEP: f64 = 0.1;
/// A gap that turns this near to its face, relative to the length of the chain, may touch it or not.
const NEAR: f64 = 1e-6;

/// An impact.
#[derive(Debug, Clone)]
pub struct Hit {
    pub time: f64,
    pub face: usize,
    pub approach: f64,
    pub impulse: f64,
}

/// A face held from one time to another.
#[derive(Debug, Clone)]
pub struct Held {
    pub face: usize,
    pub start: f64,
    pub end: f64,
}

/// What happened up to where it is known.
#[derive(Debug, Default)]
pub struct Record {
    pub hits: Vec<Hit>,
    pub held: Vec<Held>,
    /// States at the times asked for, up to the end.
    pub samples: Vec<Vec<f64>>,
    pub end: f64,
    pub why: Option<&'static str>,
}

fn step(chain: &Chain, held: Option<usize>, t: f64, x: &[f64], dt: f64) -> Vec<f64> {
    let n = chain.n();
    let slope = |t: f64, x: &[f64]| -> Vec<f64> {
        let (a, _) = chain.acceleration(t, &x[..n], &x[n..], held);
        x[n..].iter().copied().chain(a.iter().copied()).collect()
    };
    extrapolated(slope, (t, x), dt)
}

/// A zero between two arguments at which a function has other signs, by regula falsi (Illinois).
fn zero(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..100 {
        let c = b - fb * (b - a) / (fb - fa);
        if fb == 0.0 || fa == fb || (b - a).abs() <= 1e-15 * b.abs() {
            return b;
        }
        let fc = f(c);
        if (fc < 0.0) == (fb < 0.0) {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (c, fc);
    }
    b
}

/// What ends a flight.
enum Event {
    Hit(usize),
    Release,
    Doubt(&'static str),
}

/// A run in progress.
struct Run<'a> {
    chain: &'a Chain,
    time: f64,
    x: Vec<f64>,
    held: Option<usize>,
    /// The face that is left, whose gap begins at zero.
    leaving: Option<usize>,
    record: Record,
}

impl Run<'_> {
    fn after(&self, dt: f64) -> Vec<f64> {
        step(self.chain, self.held, self.time, &self.x, dt)
    }

    fn gap(&self, face: usize, x: &[f64]) -> f64 {
        self.chain.gap(face, &x[..self.chain.n()])
    }

    fn speed(&self, face: usize, x: &[f64]) -> f64 {
        let (q, v) = x.split_at(self.chain.n());
        self.chain.speed(face, q, v)
    }

    fn force(&self, t: f64, x: &[f64]) -> f64 {
        let (q, v) = x.split_at(self.chain.n());
        self.chain.acceleration(t, q, v, self.held).1
    }

    /// The fastest turn: of the links as they swing and as they fly, of the base.
    fn rate(&self) -> f64 {
        let shortest = self
            .chain
            .lengths
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let lightest = self.chain.masses.iter().sum::<f64>()
            / self
                .chain
                .masses
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
        let swing = (lightest * self.chain.gravity / shortest).sqrt();
        let fly = self.x[self.chain.n()..]
            .iter()
            .map(|v| v.abs())
            .sum::<f64>();
        swing + fly + self.chain.base.map_or(0.0, |[_, w, _]| w)
    }

    /// Where a gap that was open is closed within a step, if it is; an error where that cannot be told.
    fn closing(&self, face: usize, dt: f64, end: &[f64]) -> Result<Option<f64>, &'static str> {
        let gap = |s: f64| self.gap(face, &self.after(s));
        let speed = |s: f64| self.speed(face, &self.after(s));
        let (before, after) = (self.speed(face, &self.x), self.speed(face, end));
        let leaves = self.leaving == Some(face);
        let mut from = 0.0;
        if leaves {
            if before <= 0.0 && after <= 0.0 {
                return Err("a gap that begins to close");
            }
            if after >= 0.0 {
                return Ok(None);
            }
            from = zero(speed, 0.0, dt);
        }
        if self.gap(face, end) <= 0.0 {
            return Ok(Some(zero(gap, from, dt)));
        }
        if !leaves && before < 0.0 && after > 0.0 {
            let lowest = zero(speed, 0.0, dt);
            let least = gap(lowest);
            if least.abs() < NEAR {
                return Err("a graze");
            }
            if least < 0.0 {
                return Ok(Some(zero(gap, 0.0, lowest)));
            }
        }
        Ok(None)
    }

    /// The first that happens within a step, and when.
    fn first(&self, dt: f64, end: &[f64]) -> Option<(Event, f64)> {
        let mut found: Option<(Event, f64)> = None;
        for face in (0..self.chain.faces.len()).filter(|&face| self.held != Some(face)) {
            let at = match self.closing(face, dt, end) {
                Err(why) => return Some((Event::Doubt(why), 0.0)),
                Ok(None) => continue,
                Ok(Some(at)) => at,
            };
            match &found {
                Some((_, first)) if (first - at).abs() < NEAR => {
                    return Some((Event::Doubt("two faces at one time"), at));
                }
                Some((_, first)) if *first < at => {}
                _ => found = Some((Event::Hit(face), at)),
            }
        }
        if self.held.is_some() && self.force(self.time + dt, end) <= 0.0 {
            let force = |s: f64| self.force(self.time + s, &self.after(s));
            if force(0.0) <= 0.0 {
                return Some((Event::Doubt("a force that begins at zero"), 0.0));
            }
            let at = zero(force, 0.0, dt);
            match &found {
                Some((_, first)) if (first - at).abs() < NEAR => {
                    return Some((Event::Doubt("an impact as a face is left"), at));
                }
                Some((_, first)) if *first < at => {}
                _ => found = Some((Event::Release, at)),
            }
        }
        found
    }

    /// A face at rest is held where the motion presses to it.
    fn rest(&mut self, face: usize) -> Result<(), &'static str> {
        let (q, v) = self.x.split_at(self.chain.n());
        let opening = self.chain.opening(face, self.time, q, v);
        if opening.abs() < 1e-6 {
            return Err("neither pressed nor drawn");
        }
        if opening < 0.0 {
            self.held = Some(face);
            self.record.held.push(Held {
                face,
                start: self.time,
                end: f64::INFINITY,
            });
        } else {
            self.leaving = Some(face);
        }
        Ok(())
    }

    fn strike(&mut self, face: usize, rtol: f64) -> Result<(), &'static str> {
        if self.held.is_some() {
            return Err("an impact beside a face that is held");
        }
        let n = self.chain.n();
        let approach = -self.speed(face, &self.x);
        let (q, v) = self.x.split_at(n);
        let e = self.chain.faces[face].restitution;
        let pull = self.chain.opening(face, self.time, q, v);
        let (after, impulse) = self.chain.struck(face, q, v);
        if e > 0.0 && e < 1.0 && pull < 0.0 {
            let rest = 2.0 * e / (1.0 - e) * approach * approach / -pull;
            if rest < 1e3 * rtol {
                return Err("impacts that accumulate");
            }
        }
        self.x[n..].copy_from_slice(&after);
        self.record.hits.push(Hit {
            time: self.time,
            face,
            approach,
            impulse,
        });
        self.leaving = None;
        if e > 0.0 {
            self.leaving = Some(face);
            return Ok(());
        }
        self.rest(face)
    }

    fn release(&mut self) {
        let face = self.held.take();
        if let Some(held) = self.record.held.last_mut() {
            held.end = self.time;
        }
        self.leaving = face;
    }

    fn go(&mut self, end: f64, times: &[f64], rtol: f64) -> Result<(), &'static str> {
        while self.time < end {
            let dt = (STEP / self.rate()).min(end - self.time);
            let ahead = self.after(dt);
            if ahead.iter().any(|x| !x.is_finite()) {
                return Err("numbers that overflow");
            }
            let found = self.first(dt, &ahead);
            if let Some((Event::Doubt(why), _)) = found {
                return Err(why);
            }
            let span = found.as_ref().map_or(dt, |(_, at)| *at);
            while let Some(&t) = times.get(self.record.samples.len()) {
                if t > self.time + span {
                    break;
                }
                self.record.samples.push(self.after(t - self.time));
            }
            self.x = self.after(span);
            self.time += span;
            if span > 0.0 && found.is_none() {
                self.leaving = self.leaving.filter(|&face| self.gap(face, &self.x) < 1e-9);
            }
            match found {
                Some((Event::Hit(face), _)) => self.strike(face, rtol)?,
                Some((Event::Release, _)) => self.release(),
                _ => {}
            }
            if self.record.hits.len() + self.record.held.len() > 300 {
                return Err("many impacts or releases");
            }
        }
        Ok(())
    }
}

/// A run from zero to an end; `rtol` tells which bounces are too low to be compared.
pub fn run(chain: &Chain, x: Vec<f64>, end: f64, times: &[f64], rtol: f64) -> Record {
    let mut run = Run {
        chain,
        time: 0.0,
        x,
        held: None,
        leaving: None,
        record: Record::default(),
    };
    let mut why = None;
    let near = |&face: &usize| run.gap(face, &run.x).abs() < NEAR;
    let near: Vec<usize> = (0..chain.faces.len()).filter(near).collect();
    if near.len() > 1 {
        why = Some("a start on two faces");
    }
    for face in near {
        if run.gap(face, &run.x) == 0.0 {
            let speed = run.speed(face, &run.x);
            let begun = if speed < 0.0 {
                run.strike(face, rtol)
            } else if speed == 0.0 {
                run.rest(face)
            } else {
                run.leaving = Some(face);
                Ok(())
            };
            why = why.or(begun.err());
        }
    }
    why = why.or_else(|| run.go(end, times, rtol).err());
    if let Some(held) = run.record.held.last_mut() {
        held.end = held.end.min(run.time);
    }
    Record {
        end: run.time,
        why,
        ..run.record
    }
}

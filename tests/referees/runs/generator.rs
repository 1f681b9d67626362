//! Scenes at random, the same for the same seed and number: what is usual, and what breaks. Half of them have round numbers,
//! for which things coincide exactly.

use crate::random::Random;
use crate::roots::eigenvalues;
use crate::runs::case::{Case, Push, StopCase};
use crate::runs::draw::{Draw, round_to};
use crate::runs::shallow::make_shallow;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use vibroimpact::Method;

impl Draw<'_> {
    fn normal(&mut self) -> Vec<f64> {
        if self.random.chance(65) {
            let mut normal = vec![0.0; self.n];
            normal[self.random.below(self.n)] = 1.0;
            return normal;
        }
        if self.n > 1 && self.random.chance(40) {
            // Two masses strike each other.
            let i = self.random.below(self.n - 1);
            let mut normal = vec![0.0; self.n];
            (normal[i], normal[i + 1]) = (1.0, -1.0);
            return normal;
        }
        let normal = self.vector(1.0);
        if normal.iter().all(|&x| x == 0.0) {
            vec![1.0; self.n]
        } else {
            normal
        }
    }

    fn push(&mut self, normal: &[f64]) -> Push {
        match self.random.below(10) {
            0..=6 => Push::Inertia,
            7 | 8 => Push::Coordinate,
            _ => {
                let aside = self.vector(0.4);
                let b: Vec<f64> = normal.iter().zip(&aside).map(|(n, a)| n + a).collect();
                let along: f64 = normal.iter().zip(&b).map(|(n, b)| n * b).sum();
                let size: f64 = normal.iter().map(|n| n * n).sum();
                if along > 0.2 * size {
                    Push::Direction(b)
                } else {
                    Push::Coordinate
                }
            }
        }
    }

    fn restitution(&mut self) -> f64 {
        match self.random.below(12) {
            0 | 1 => 0.0,
            2 => 1e-3,
            3..=5 => 0.5,
            6 | 7 => 0.9,
            8 => 1.0,
            _ => self.number(0.0, 1.0),
        }
    }

    fn clearance(&mut self) -> f64 {
        match self.random.below(10) {
            0..=2 => 0.0,
            3 => self.random.log(1e-6, 1e-2),
            4 => -self.number(0.01, 0.3),
            _ => self.number(0.05, 1.0),
        }
    }

    fn stops(&mut self) -> Vec<StopCase> {
        let count = self.random.of(&[0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 4, 6]);
        let mut stops: Vec<StopCase> = Vec::new();
        let same_push = self.random.chance(50);
        while stops.len() < count {
            if let Some(last) = stops.last().cloned()
                && self.random.chance(30)
            {
                let mut other = last;
                match self.random.below(6) {
                    0 => {}
                    1 => other.restitution = self.restitution(),
                    _ => {
                        other.lower = !other.lower;
                        let room = self.random.of(&[0.0, 1e-9, 1e-3, 0.1, 0.3, 1.0]);
                        other.clearance = room - other.clearance;
                    }
                }
                stops.push(other);
                continue;
            }
            let normal = self.normal();
            let push = match stops.first() {
                Some(first) if same_push && !matches!(first.push, Push::Direction(_)) => {
                    first.push.clone()
                }
                _ => self.push(&normal),
            };
            stops.push(StopCase {
                normal,
                clearance: self.clearance(),
                restitution: self.restitution(),
                lower: self.random.chance(50),
                push,
            });
        }
        stops
    }

    fn start(&mut self, stops: &[StopCase]) -> (Vec<f64>, Vec<f64>) {
        let zero = vec![0.0; self.n];
        match self.random.below(10) {
            0..=3 => (zero.clone(), zero),
            4 => (zero, self.vector(1.0)),
            5 => (self.vector(0.5), zero),
            6 | 7 if !stops.is_empty() => {
                let count = 1 + self.random.below(stops.len());
                let q = on_stops(self.n, &stops[..count]).unwrap_or_else(|| zero.clone());
                let v = if self.random.chance(60) {
                    zero
                } else {
                    self.vector(1.0)
                };
                (q, v)
            }
            _ => (self.vector(0.5), self.vector(1.0)),
        }
    }
}

/// The position of least length on all these stops.
fn on_stops(n: usize, stops: &[StopCase]) -> Option<Vec<f64>> {
    let normals = DMatrix::from_fn(stops.len(), n, |i, j| stops[i].outward()[j]);
    let clearances = DVector::from_iterator(stops.len(), stops.iter().map(|s| s.clearance));
    let inverse = normals.clone().pseudo_inverse(1e-9).ok()?;
    let q = &inverse * &clearances;
    // Once more for what rounding left.
    let q = &q + &inverse * (&clearances - &normals * &q);
    Some(q.as_slice().to_vec())
}

/// Seeds up to this one keep the scenes that were found with them: nothing was driven at one coordinate alone.
const ALL_DRIVEN: u64 = 106;

/// Seeds up to this one have scenes of one force.
const ONE_FORCE: u64 = 201;

/// Leaves forces, and perhaps the load and the start, at one coordinate alone: what happens there reaches others late.
fn drive_one(case: &mut Case, random: &mut Random) {
    let one = random.below(case.q0.len());
    let leave = |vector: &mut Vec<f64>| {
        for (i, x) in vector.iter_mut().enumerate() {
            if i != one {
                *x = 0.0;
            }
        }
    };
    for force in case.forces_mut() {
        leave(&mut force.re);
        leave(&mut force.im);
    }
    if random.chance(70) {
        leave(&mut case.load);
    }
    if random.chance(70) {
        leave(&mut case.v0);
    }
    case.label += ", driven at one coordinate";
}

/// The methods of scenes that are integrated: which of them takes a scene, its number says.
pub const STEPPED: [Method; 3] = [Method::Rk45, Method::Dop853, Method::Radau];

/// Scene number `number` of a seed.
pub fn scene(seed: u64, number: u64) -> Case {
    let mut random = Random::of_case(seed, number);
    let n = random.of(&[1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 4, 5, 6]);
    let is_round = random.chance(50);
    let mut draw = Draw {
        random: &mut random,
        is_round,
        n,
    };
    let mass = draw.mass();
    let (stiffness, of_stiffness) = draw.stiffness();
    let (damping, of_damping) = draw.damping(&mass, &stiffness);
    let load = if draw.random.chance(35) {
        draw.vector(1.0)
    } else {
        vec![0.0; n]
    };
    let natural = Draw::frequencies(&mass, &stiffness);
    let (force, of_force) = draw.force(&natural);
    let several = seed > ONE_FORCE && force.is_some() && draw.random.chance(40);
    let more = if several {
        draw.more_forces(&natural)
    } else {
        Vec::new()
    };
    let mut stops = draw.stops();
    let (q0, v0) = draw.start(&stops);
    // A start behind a stop moves the stop: to where it is touched, or beyond.
    for stop in &mut stops {
        let behind = stop.gap(&q0);
        if behind < 0.0 && behind.abs() > 1e-13 {
            let room = draw.random.of(&[0.0, 0.1]);
            stop.clearance += room - behind;
        }
    }
    let fastest = natural.iter().fold(0.3, |m: f64, &w| m.max(w));
    let eigenvalues = state_eigenvalues(&mass, &damping, &stiffness);
    let rate = eigenvalues
        .iter()
        .map(|l| l.0.hypot(l.1))
        .fold(fastest, f64::max);
    let growth = eigenvalues.iter().map(|l| l.0).fold(1e-9, f64::max);
    let forces = force.iter().chain(&more);
    let slowest = force.as_ref().map_or(fastest, |f| f.frequency.max(0.2));
    let top = forces.map(|f| f.frequency).fold(rate, f64::max);
    let duration = (TAU / slowest * draw.random.between(2.0, 30.0))
        .min(600.0 / top)
        .min(6.0 / growth);
    let duration = round_to(is_round, duration);
    let start = match draw.random.below(10) {
        0..=6 => 0.0,
        7 => -1e6,
        8 => 1e9,
        _ => draw.random.between(-100.0, 100.0),
    };
    // Frequencies of a common period are taken as multiples of one, as far as their last digits tell: far from zero those count.
    let start = if more.is_empty() || start.abs() < 1e3 {
        start
    } else {
        0.0
    };
    let method = if draw.random.chance(80) {
        Method::Exact
    } else {
        STEPPED[(number % 3) as usize]
    };
    let rtol = if method == Method::Exact && draw.random.chance(50) {
        1e-13
    } else {
        1e-9
    };
    let mut case = Case {
        label: format!(
            "n = {n}, {of_stiffness}, {of_damping}, {of_force} and {} more, {} stops",
            more.len(),
            stops.len()
        ),
        mass,
        damping,
        stiffness,
        load,
        force,
        more,
        stops,
        q0,
        v0,
        span: (start, start + duration),
        method,
        rtol,
        atol: 1e-3 * rtol,
    };
    if draw.random.chance(6) {
        let overshoot = draw.random.log(1e-13, 1e-2);
        let mut shallow = case.clone();
        if make_shallow(&mut shallow, overshoot) {
            shallow.label += &format!(", passed by {overshoot:.0e}");
            return shallow;
        }
    }
    if seed > ALL_DRIVEN && n > 1 && draw.random.chance(10) {
        drive_one(&mut case, draw.random);
    }
    case
}

fn state_eigenvalues(
    mass: &DMatrix<f64>,
    damping: &DMatrix<f64>,
    stiffness: &DMatrix<f64>,
) -> Vec<(f64, f64)> {
    let n = mass.nrows();
    let inverse = mass.clone().try_inverse().expect("positive definite");
    let (k, c) = (&inverse * stiffness, &inverse * damping);
    let a = DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, _) => f64::from(u8::from(j == n + i)),
        (false, true) => -k[(i - n, j)],
        (false, false) => -c[(i - n, j - n)],
    });
    eigenvalues(&a).iter().map(|l| (l.re, l.im)).collect()
}

//! Scenes at random, the same for the same seed and number: what is usual, and what breaks. Half of them have round numbers,
//! for which things coincide exactly.

use crate::case::{Case, ForceCase, Push, StopCase};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use vibroimpact::Method;

/// Steele, Lea and Flood's SplitMix64 (OOPSLA 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64, number: u64) -> Self {
        let mut random = Self(
            seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ number.wrapping_mul(0xD1B5_4A32_D192_ED03),
        );
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// True in so many of a hundred cases.
    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub fn of<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())].clone()
    }
}

/// A number with one significant digit, or itself.
fn round_to(is_round: bool, x: f64) -> f64 {
    if !is_round || x == 0.0 || !x.is_finite() {
        return x;
    }
    format!("{x:.0e}").parse().expect("a number")
}

struct Draw<'a> {
    random: &'a mut Random,
    is_round: bool,
    n: usize,
}

impl Draw<'_> {
    fn number(&mut self, low: f64, high: f64) -> f64 {
        let x = self.random.between(low, high);
        round_to(self.is_round, x)
    }

    fn vector(&mut self, size: f64) -> Vec<f64> {
        (0..self.n).map(|_| self.number(-size, size)).collect()
    }

    fn matrix(&mut self) -> DMatrix<f64> {
        let n = self.n;
        let mut a = DMatrix::zeros(n, n);
        for x in a.iter_mut() {
            *x = self.number(-1.0, 1.0);
        }
        a
    }

    /// Symmetric positive definite; products of round numbers are exact.
    fn positive(&mut self) -> DMatrix<f64> {
        let a = self.matrix();
        &a * a.transpose() + DMatrix::identity(self.n, self.n) * self.number(0.1, 2.0)
    }

    fn diagonal(&mut self, low: f64, high: f64) -> DMatrix<f64> {
        let entries: Vec<f64> = (0..self.n)
            .map(|_| self.random.log(low, high))
            .map(|x| round_to(self.is_round, x))
            .collect();
        DMatrix::from_diagonal(&DVector::from_vec(entries))
    }

    /// Springs from mass to mass, the first and last to ground or not.
    fn chain(&mut self, is_grounded: bool) -> DMatrix<f64> {
        let n = self.n;
        let mut k = DMatrix::zeros(n, n);
        let same = self.number(0.5, 3.0);
        for i in 0..=n {
            let spring = if self.is_round {
                same
            } else {
                self.number(0.3, 3.0)
            };
            let ends: Vec<usize> = [i.checked_sub(1), (i < n).then_some(i)]
                .into_iter()
                .flatten()
                .collect();
            if ends.len() == 1 && !is_grounded {
                continue;
            }
            for &a in &ends {
                for &b in &ends {
                    k[(a, b)] += if a == b { spring } else { -spring };
                }
            }
        }
        k
    }

    fn mass(&mut self) -> DMatrix<f64> {
        match self.random.below(10) {
            0..=3 => DMatrix::identity(self.n, self.n),
            4..=6 => self.diagonal(0.3, 3.0),
            7 | 8 => self.positive(),
            _ => self.diagonal(1e-3, 1e3),
        }
    }

    fn stiffness(&mut self) -> (DMatrix<f64>, &'static str) {
        match self.random.below(20) {
            0..=4 => (self.diagonal(0.1, 10.0), "diagonal"),
            5..=8 => (self.positive(), "full"),
            9..=12 => (self.chain(true), "chain"),
            13 | 14 => (self.chain(false), "free-free"),
            15 | 16 => (DMatrix::zeros(self.n, self.n), "no stiffness"),
            17 => (
                self.positive() - DMatrix::identity(self.n, self.n) * self.number(0.1, 1.5),
                "negative stiffness",
            ),
            18 => (
                self.matrix() * 0.3 + self.diagonal(0.5, 3.0),
                "nonsymmetric stiffness",
            ),
            _ => (self.diagonal(1e-2, 1e4), "stiff"),
        }
    }

    fn damping(
        &mut self,
        mass: &DMatrix<f64>,
        stiffness: &DMatrix<f64>,
    ) -> (DMatrix<f64>, &'static str) {
        let skew = |a: &DMatrix<f64>| a - a.transpose();
        match self.random.below(20) {
            0..=5 => (DMatrix::zeros(self.n, self.n), "undamped"),
            6..=9 => (
                stiffness * self.number(0.002, 0.1) + mass * self.number(0.002, 0.1),
                "proportional",
            ),
            10..=12 => (self.diagonal(0.01, 1.0), "diagonal damping"),
            13 | 14 => (self.positive() * 0.1, "full damping"),
            15 | 16 => (
                skew(&self.matrix()) + mass * self.number(0.0, 0.05),
                "gyroscopic",
            ),
            17 => (mass * -self.number(0.005, 0.03), "negative damping"),
            18 => (self.positive() * 10.0, "overdamped"),
            _ => {
                let mut c = DMatrix::zeros(self.n, self.n);
                let i = self.random.below(self.n);
                c[(i, i)] = self.number(0.1, 2.0);
                (c, "one dashpot")
            }
        }
    }

    /// Frequencies of the undamped system that are real.
    fn frequencies(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Vec<f64> {
        let inverse = mass.clone().try_inverse().expect("positive definite");
        let values = (inverse * stiffness).complex_eigenvalues();
        values
            .iter()
            .filter(|z| z.re > 1e-9 && z.im.abs() < 1e-9 * z.re)
            .map(|z| z.re.sqrt())
            .collect()
    }

    fn force(&mut self, natural: &[f64]) -> (Option<ForceCase>, &'static str) {
        let one = if natural.is_empty() {
            1.0
        } else {
            self.random.of(natural)
        };
        let (frequency, label) = match self.random.below(20) {
            0..=3 => return (None, "unforced"),
            4..=11 => {
                let factor = self.random.log(0.3, 3.0);
                (round_to(self.is_round, one * factor), "forced")
            }
            12..=15 => {
                let off = self
                    .random
                    .of(&[0.0, 1e-2, 1e-4, -1e-6, 1e-8, -1e-10, 1e-12]);
                (one * (1.0 + off), "resonant")
            }
            16 | 17 => {
                let w = self.random.log(1e-9, 1e-3);
                (round_to(self.is_round, w), "slow")
            }
            _ => {
                let w = self.random.log(1e2, 1e4);
                (round_to(self.is_round, w), "fast")
            }
        };
        let size = self.random.of(&[0.3, 1.0, 3.0]);
        let mut re = self.vector(size);
        if re.iter().all(|&x| x == 0.0) {
            re[0] = 1.0;
        }
        let im = if self.random.chance(20) {
            self.vector(size)
        } else {
            vec![0.0; self.n]
        };
        let phase = match self.random.below(10) {
            0..=3 => -FRAC_PI_2,
            4 => 0.0,
            5 => FRAC_PI_2,
            6 => PI,
            _ => self.number(-3.0, 3.0),
        };
        (
            Some(ForceCase {
                re,
                im,
                frequency,
                phase,
            }),
            label,
        )
    }

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

fn gap(stop: &StopCase, q: &[f64]) -> f64 {
    stop.clearance
        - stop
            .outward()
            .iter()
            .zip(q)
            .map(|(n, q)| n * q)
            .sum::<f64>()
}

/// The position of least length on all these stops.
fn on_stops(n: usize, stops: &[StopCase]) -> Option<Vec<f64>> {
    let normals = DMatrix::from_fn(stops.len(), n, |i, j| stops[i].outward()[j]);
    let clearances = DVector::from_iterator(stops.len(), stops.iter().map(|s| s.clearance));
    let inverse = normals.pseudo_inverse(1e-9).ok()?;
    Some((inverse * clearances).as_slice().to_vec())
}

/// Scene number `number` of a seed.
pub fn scene(seed: u64, number: u64) -> Case {
    let mut random = Random::new(seed, number);
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
    let mut stops = draw.stops();
    let (q0, v0) = draw.start(&stops);
    // A start behind a stop moves the stop: to where it is touched, or beyond.
    for stop in &mut stops {
        let behind = gap(stop, &q0);
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
    let slowest = force.as_ref().map_or(fastest, |f| f.frequency.max(0.2));
    let top = force.as_ref().map_or(rate, |f| rate.max(f.frequency));
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
    let method = if draw.random.chance(80) {
        Method::Exact
    } else {
        Method::Rk45
    };
    let rtol = if method == Method::Exact && draw.random.chance(50) {
        1e-13
    } else {
        1e-9
    };
    Case {
        label: format!(
            "n = {n}, {of_stiffness}, {of_damping}, {of_force}, {} stops",
            stops.len()
        ),
        mass,
        damping,
        stiffness,
        load,
        force,
        stops,
        q0,
        v0,
        span: (start, start + duration),
        method,
        rtol,
        atol: 1e-3 * rtol,
    }
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
    a.complex_eigenvalues()
        .iter()
        .map(|l| (l.re, l.im))
        .collect()
}

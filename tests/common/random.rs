//! Numbers at random, the same on every machine, and the random cases that a test looks at; which they are comes from the environment.

#![allow(
    dead_code,
    reason = "each test crate that includes this file uses a part of it"
)]

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Steele, Lea and Flood's `SplitMix64` (OOPSLA 2014).
pub struct Random(u64);

impl Random {
    /// The numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self::of_case(seed, 0)
    }

    /// The numbers of one case of a seed.
    pub fn of_case(seed: u64, case: u64) -> Self {
        let mut random = Self(
            seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ case.wrapping_mul(0xD1B5_4A32_D192_ED03),
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

    /// A number of `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A number whose logarithm is uniform.
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

    pub fn vector(&mut self, n: usize) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.between(-1.0, 1.0))
    }

    pub fn matrix(&mut self, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |_, _| self.between(-1.0, 1.0))
    }
}

/// So many random cases of a seed, or one of them alone, each with numbers of its own. Where they are set, `VIBROIMPACT_CASES` says
/// how many, `VIBROIMPACT_SEED` of which seed, and `VIBROIMPACT_CASE` which one alone, to look at it.
#[derive(Clone, Copy)]
pub struct Cases {
    pub seed: u64,
    count: usize,
    only: Option<usize>,
    /// The cases among which what is seen in a hundred of the usual seed must be seen: others have fewer of what is rare.
    hundred: usize,
}

impl Cases {
    /// What is looked at where the environment says nothing.
    pub fn new(seed: u64, count: usize) -> Self {
        let own = chosen("VIBROIMPACT_SEED");
        Self {
            seed: own.unwrap_or(seed),
            count: chosen("VIBROIMPACT_CASES").unwrap_or(count),
            only: chosen("VIBROIMPACT_CASE"),
            hundred: if own.is_some() { 500 } else { 100 },
        }
    }

    pub fn numbers(&self) -> Range<usize> {
        self.only.map_or(0..self.count, |only| only..only + 1)
    }

    pub fn each(&self) -> impl Iterator<Item = (usize, Random)> + use<> {
        let seed = self.seed;
        self.numbers()
            .map(move |number| (number, Random::of_case(seed, number as u64)))
    }

    /// Whether one case alone is looked at, which need not have all that is counted.
    pub fn is_one(&self) -> bool {
        self.only.is_some()
    }

    /// Whether so many in a hundred cases, or more, have shown what is looked for: else a test would say little.
    pub fn have(&self, seen: usize, in_a_hundred: usize) -> bool {
        self.is_one() || seen >= in_a_hundred * self.count / self.hundred
    }
}

fn chosen<T: std::str::FromStr>(name: &str) -> Option<T> {
    let text = std::env::var(name).ok()?;
    let number = text.parse().ok();
    Some(number.unwrap_or_else(|| panic!("{name} = {text:?} is not a number")))
}

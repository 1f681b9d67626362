//! Random cases that are the same on every machine; their number and seed come from the environment.

#![allow(
    dead_code,
    reason = "each test crate that includes this file uses a part of it"
)]

use nalgebra::{DMatrix, DVector};

/// A small reproducible source of numbers in (0, 1).
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 >> 11
    }

    pub fn unit(&mut self) -> f64 {
        self.next() as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % n as u64).expect("below n")
    }

    pub fn vector(&mut self, n: usize) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.between(-1.0, 1.0))
    }

    pub fn matrix(&mut self, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |_, _| self.between(-1.0, 1.0))
    }
}

/// A number from the environment, such as `VIBROIMPACT_CASES` or `VIBROIMPACT_SEED`.
pub fn number(name: &str, default: usize) -> usize {
    chosen(name).unwrap_or(default)
}

/// A number that the environment may have, such as `VIBROIMPACT_CASE`.
pub fn chosen(name: &str) -> Option<usize> {
    std::env::var(name).ok()?.parse().ok()
}

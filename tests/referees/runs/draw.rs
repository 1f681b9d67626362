//! Parts of systems at random: matrices and forces, usual ones and such as break things.

use crate::random::Random;
use crate::roots::eigenvalues;
use crate::runs::case::ForceCase;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{FRAC_PI_2, PI};

/// A number with one significant digit, or itself.
pub fn round_to(is_round: bool, x: f64) -> f64 {
    if !is_round || x == 0.0 || !x.is_finite() {
        return x;
    }
    format!("{x:.0e}").parse().expect("a number")
}

pub struct Draw<'a> {
    pub random: &'a mut Random,
    pub is_round: bool,
    pub n: usize,
}

impl Draw<'_> {
    pub fn number(&mut self, low: f64, high: f64) -> f64 {
        let x = self.random.between(low, high);
        round_to(self.is_round, x)
    }

    pub fn vector(&mut self, size: f64) -> Vec<f64> {
        (0..self.n).map(|_| self.number(-size, size)).collect()
    }

    pub fn matrix(&mut self) -> DMatrix<f64> {
        let n = self.n;
        let mut a = DMatrix::zeros(n, n);
        for x in a.iter_mut() {
            *x = self.number(-1.0, 1.0);
        }
        a
    }

    /// Symmetric positive definite; products of round numbers are exact.
    pub fn positive(&mut self) -> DMatrix<f64> {
        let a = self.matrix();
        &a * a.transpose() + DMatrix::identity(self.n, self.n) * self.number(0.1, 2.0)
    }

    pub fn diagonal(&mut self, low: f64, high: f64) -> DMatrix<f64> {
        let entries: Vec<f64> = (0..self.n)
            .map(|_| self.random.log(low, high))
            .map(|x| round_to(self.is_round, x))
            .collect();
        DMatrix::from_diagonal(&DVector::from_vec(entries))
    }

    /// Springs from mass to mass, the first and last to ground or not.
    pub fn chain(&mut self, is_grounded: bool) -> DMatrix<f64> {
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

    pub fn mass(&mut self) -> DMatrix<f64> {
        match self.random.below(10) {
            0..=3 => DMatrix::identity(self.n, self.n),
            4..=6 => self.diagonal(0.3, 3.0),
            7 | 8 => self.positive(),
            _ => self.diagonal(1e-3, 1e3),
        }
    }

    pub fn stiffness(&mut self) -> (DMatrix<f64>, &'static str) {
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

    pub fn damping(
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
    pub fn frequencies(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Vec<f64> {
        let inverse = mass.clone().try_inverse().expect("positive definite");
        let values = eigenvalues(&(inverse * stiffness));
        values
            .iter()
            .filter(|z| z.re > 1e-9 && z.im.abs() < 1e-9 * z.re)
            .map(|z| z.re.sqrt())
            .collect()
    }

    /// One or two more forces, of frequencies of their own.
    pub fn more_forces(&mut self, natural: &[f64]) -> Vec<ForceCase> {
        let count = 1 + self.random.below(2);
        let forces = (0..4).filter_map(|_| self.force(natural).0);
        let mut forces: Vec<ForceCase> = forces.collect();
        // What is fast or slow beside all else is alone in other scenes.
        forces.retain(|f| (1e-2..50.0).contains(&f.frequency));
        forces.truncate(count);
        forces
    }

    pub fn force(&mut self, natural: &[f64]) -> (Option<ForceCase>, &'static str) {
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
}

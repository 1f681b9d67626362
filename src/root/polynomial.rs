//! The roots of a polynomial of low order: its derivative's part it into monotone pieces.

use crate::root::bracket::Bracket;
use crate::root::newton::{NewtonPoint, newton};
use std::convert::Infallible;

/// Values of a polynomial for a root in its bracket, halvings among them. [work]
const MOST_POLYNOMIAL_POLISHES: usize = 200;
/// Number of coefficients of the longest polynomial of a gap, a quintic. [exact]
pub(crate) const QUINTIC_SIZE: usize = 6;

/// Real numbers in ascending order, fewer than N.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Few<const N: usize = QUINTIC_SIZE> {
    values: [f64; N],
    count: usize,
}

impl<const N: usize> Few<N> {
    const NONE: Self = Self {
        values: [0.0; N],
        count: 0,
    };

    fn push(&mut self, x: f64) {
        self.values[self.count] = x;
        self.count += 1;
    }

    pub fn slice(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

#[inline]
pub(crate) fn value(c: &[f64], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

pub(crate) fn derivative<const N: usize>(c: &[f64]) -> ([f64; N], usize) {
    let mut d = [0.0; N];
    for (k, c) in c.iter().enumerate().skip(1) {
        d[k - 1] = k as f64 * c;
    }
    (d, c.len() - 1)
}

/// The root in an interval over whose ends a monotone polynomial changes its sign.
pub(crate) fn bracketed_root(c: &[f64], low: f64, high: f64) -> f64 {
    bracketed::<QUINTIC_SIZE>(c, low, high)
}

fn bracketed<const N: usize>(c: &[f64], low: f64, high: f64) -> f64 {
    let (d, size) = derivative::<N>(c);
    let sign = if value(c, low) > 0.0 { 1.0 } else { -1.0 };
    let between = Bracket::new([low, high]);
    let Ok(step) = newton(between, between.middle(), MOST_POLYNOMIAL_POLISHES, |x| {
        Ok::<_, Infallible>(NewtonPoint {
            value: sign * value(c, x),
            slope: sign * value(&d[..size], x),
            resolution: f64::EPSILON * x.abs(),
        })
    });
    step.to
}

/// The roots of a polynomial inside (0, 1) at which it changes its sign, by way of those of its derivative.
pub(crate) fn roots(c: &[f64]) -> Few {
    roots_of::<QUINTIC_SIZE>(c)
}

/// The same of one of at most N coefficients.
pub(crate) fn roots_of<const N: usize>(c: &[f64]) -> Few<N> {
    let mut found = Few::NONE;
    if c.len() < 2 {
        return found;
    }
    let (d, size) = derivative::<N>(c);
    let turning = roots_of::<N>(&d[..size]);
    let mut left = 0.0;
    for &right in turning.slice().iter().chain(&[1.0]) {
        if (value(c, left) > 0.0) != (value(c, right) > 0.0) && right > left {
            found.push(bracketed::<N>(c, left, right));
        }
        left = right;
    }
    found
}

/// `scale (x - r_1) (x - r_2) ...`, for tests.
#[cfg(test)]
pub(crate) fn from_roots(at: &[f64], scale: f64) -> Vec<f64> {
    at.iter().fold(vec![scale], |c, root| {
        let mut next = vec![0.0; c.len() + 1];
        for (k, c) in c.iter().enumerate() {
            next[k + 1] += c;
            next[k] -= root * c;
        }
        next
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_change_is_found() {
        for at in [
            vec![0.5],
            vec![0.1, 0.9],
            vec![0.3, 0.300_01],
            vec![0.2, 0.4, 0.6, 0.8],
            vec![0.01, 0.02, 0.5, 0.98, 0.99],
            vec![-0.5, 0.25, 1.5],
        ] {
            let found = roots(&from_roots(&at, 2.0));
            let inside: Vec<f64> = at
                .iter()
                .copied()
                .filter(|x| (0.0..1.0).contains(x))
                .collect();
            assert_eq!(found.count, inside.len(), "{at:?}");
            for (a, b) in found.slice().iter().zip(&inside) {
                assert!((a - b).abs() < 1e-10, "{a} {b}");
            }
        }
    }
}

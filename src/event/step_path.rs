//! The motion along one step of an integrator as polynomials in the part x of the step, `0 <= x <= 1`, and expanded about any
//! place: with the Taylor series of each coordinate there, speeds and accelerations are bounded over a width ahead by sums of sizes.

use crate::tolerance::ERROR_FACTOR;

/// The motion along a step.
#[derive(Debug, Clone)]
pub(crate) struct StepPath {
    /// Each coordinate in powers of x.
    powers: Vec<Vec<f64>>,
    /// The error of each half-way.
    errors: Vec<f64>,
}

/// The motion about a place of the step.
#[derive(Debug, Clone)]
pub(crate) struct Expansion {
    /// Each coordinate in powers of the part of the step since that place.
    powers: Vec<Vec<f64>>,
    /// The sum of the sizes of the terms that each coordinate is summed from there, shape `(n_dof,)`, in units of the coordinates \[m\] or
    /// \[rad\].
    pub sizes: Vec<f64>,
}

impl StepPath {
    /// A motion by each coordinate in powers of x, and what each may be off half-way.
    pub fn new(powers: Vec<Vec<f64>>, errors: Vec<f64>) -> Self {
        Self { powers, errors }
    }

    /// What it may be off the motion at x, weighted by sizes: both agree in values and slopes at the ends, and the estimate half-way is as
    /// good as it is.
    pub fn error_at(&self, x: f64, weights: &[f64]) -> f64 {
        let errors = self.errors.iter().zip(weights);
        let error: f64 = errors.map(|(error, weight)| error * weight.abs()).sum();
        ERROR_FACTOR * error * (4.0 * x * (1.0 - x)).max(0.0).powi(3)
    }

    /// Its expansion about a place.
    pub fn about(&self, x: f64) -> Expansion {
        let size = |c: &Vec<f64>| c.iter().rev().fold(0.0, |sum, c| sum * x + c.abs());
        let sizes = self.powers.iter().map(size).collect();
        let mut powers = self.powers.clone();
        for c in &mut powers {
            for first in 0..c.len().saturating_sub(1) {
                for k in (first..c.len() - 1).rev() {
                    c[k] += x * c[k + 1];
                }
            }
        }
        Expansion { powers, sizes }
    }
}

impl Expansion {
    /// The position there.
    pub fn position(&self) -> Vec<f64> {
        self.powers.iter().map(|c| c[0]).collect()
    }

    /// The motion along a direction, in powers.
    pub fn along(&self, direction: &[f64]) -> Vec<f64> {
        let degrees = self.powers.iter().map(Vec::len).max().unwrap_or(0);
        let mut along = vec![0.0; degrees];
        for (c, n) in self.powers.iter().zip(direction) {
            for (sum, c) in along.iter_mut().zip(c) {
                *sum += n * c;
            }
        }
        along
    }

    /// Bounds on the speed and on the acceleration over a width from there on, as lengths of vectors.
    pub fn bounds(&self, width: f64) -> [f64; 2] {
        let (mut speed, mut bend) = (0.0, 0.0);
        for c in &self.powers {
            let [rate, turn] = derivative_bounds(c, width);
            speed += rate * rate;
            bend += turn * turn;
        }
        [speed.sqrt(), bend.sqrt()]
    }
}

/// Bounds on the sizes of the first two derivatives of a polynomial, over a width from zero on.
pub(crate) fn derivative_bounds(powers: &[f64], width: f64) -> [f64; 2] {
    let (mut rate, mut turn) = (0.0, 0.0);
    for (k, c) in powers.iter().enumerate().skip(1).rev() {
        let k = k as f64;
        rate = rate * width + k * c.abs();
        if k > 1.0 {
            turn = turn * width + k * (k - 1.0) * c.abs();
        }
    }
    [rate, turn]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_about_a_place_is_the_same_motion_and_its_bounds_hold() {
        let c = vec![
            vec![0.3, -1.0, 2.0, 0.5, -0.7, 0.2],
            vec![-1.0, 0.0, 4.0, -3.0],
        ];
        let path = StepPath::new(c.clone(), Vec::new());
        let derivatives = |x: f64| {
            let terms = |c: &Vec<f64>, of: fn(f64, f64) -> f64| -> f64 {
                let terms = c.iter().enumerate();
                terms.map(|(k, c)| c * of(k as f64, x)).sum()
            };
            let rate = |k: f64, x: f64| if k < 1.0 { 0.0 } else { k * x.powf(k - 1.0) };
            let bend = |k: f64, x: f64| {
                if k < 2.0 {
                    0.0
                } else {
                    k * (k - 1.0) * x.powf(k - 2.0)
                }
            };
            let all = [|k: f64, x: f64| x.powf(k), rate, bend];
            all.map(|of| c.iter().map(|c| terms(c, of)).collect::<Vec<f64>>())
        };
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        for from in [0.0, 0.2, 0.7] {
            let about = path.about(from);
            let [q, rates, _] = derivatives(from);
            for (a, b) in about.position().into_iter().zip(q) {
                assert!((a - b).abs() < 1e-14);
            }
            for (direction, b) in [[1.0, 0.0], [0.0, 1.0]].iter().zip(&rates) {
                assert!((about.along(direction)[1] - b).abs() < 1e-14);
            }
            for width in [1e-3, 0.1, 0.3] {
                let [speed, bend] = about.bounds(width);
                for part in 0..=10 {
                    let [_, rates, bends] = derivatives(from + width * f64::from(part) / 10.0);
                    assert!(norm(&rates) <= speed * (1.0 + 1e-14));
                    assert!(norm(&bends) <= bend * (1.0 + 1e-14));
                }
            }
        }
    }
}

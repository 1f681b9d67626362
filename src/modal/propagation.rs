//! The matrix exponential of a block of two unknowns, in the form that its roots ask for, and the response to a constant
//! input that goes with it (theory 4).

use crate::linalg::elementary::{exp, sin_cos};
use crate::linalg::exponential::{phi1, sinc};
use crate::linalg::plane::Pair;
use crate::modal::oscillator_roots::{over_load_response, under_one_minus_cp};
use crate::tolerance::{FAR_FROM_ONE, SINC_SERIES};
use nalgebra::Complex;

/// A 2 by 2 real matrix by rows.
pub(super) type Matrix = [Pair; 2];

/// A block in the form in which it is propagated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Propagation {
    Under {
        w2: f64,
        eta: f64,
        damped_frequency: f64,
    },
    Over {
        w2: f64,
        l1: f64,
        l2: f64,
        half_gap: f64,
    },
    Spiral {
        sigma: f64,
        omega: f64,
    },
    Decays {
        roots: Pair,
    },
}

impl Propagation {
    /// The rates of the angle and of the exponent that `e^{A t}` is made of; zero where it is not.
    #[inline]
    pub fn rates(self) -> Pair {
        match self {
            Self::Under {
                eta,
                damped_frequency,
                ..
            } => [damped_frequency, -eta],
            Self::Spiral { sigma, omega } => [omega, sigma],
            Self::Over { .. } | Self::Decays { .. } => [0.0, 0.0],
        }
    }

    /// `e^{A t}`.
    #[inline]
    pub fn over(self, t: f64) -> Matrix {
        let [turn, growth] = self.rates().map(|rate| rate * t);
        self.made_of(t, sin_cos(turn), exp(growth))
    }

    /// The same from the sine and cosine of its angle and the power of its exponent.
    #[inline]
    pub fn made_of(self, t: f64, (sin, cos): (f64, f64), power: f64) -> Matrix {
        match self {
            Self::Under {
                w2,
                eta,
                damped_frequency: wd,
            } => {
                let s = if (wd * t).abs() < SINC_SERIES {
                    power * t * sinc(wd * t)
                } else {
                    power * sin / wd
                };
                let c = power * cos;
                [[c + eta * s, s], [-w2 * s, c - eta * s]]
            }
            Self::Over {
                w2,
                l1,
                l2,
                half_gap,
            } => {
                let (e1, e2) = (exp(l1 * t), exp(l2 * t));
                let s = -e1 * (-2.0 * half_gap * t).exp_m1() / (2.0 * half_gap);
                // Of one root that grows and one that does not, a sum of terms of one sign; beside a slower one that grows too, the
                // fast one has its part in this as it is.
                let first = if l1 > 0.0 && l2 <= 0.5 * l1 {
                    (l1 * e2 - l2 * e1) / (2.0 * half_gap)
                } else {
                    e1 - l1 * s
                };
                [[first, s], [-w2 * s, e2 + l1 * s]]
            }
            Self::Spiral { .. } => [[power * cos, -power * sin], [power * sin, power * cos]],
            Self::Decays { roots } => [[exp(roots[0] * t), 0.0], [0.0, exp(roots[1] * t)]],
        }
    }

    /// Response from rest over `t` to the constant input `g`: `A^-1 (e^{A t} - I) g`, from the `exponential` of the same time
    /// where that does not cancel, else from forms that keep their digits and need no inverse.
    #[inline]
    pub fn loaded(self, t: f64, exponential: &Matrix, g: Pair) -> Pair {
        if g == [0.0, 0.0] {
            return g;
        }
        let [[first, s], [cross, second]] = *exponential;
        match self {
            // Not beside a root that grows: the rounding of the first entry grows with it.
            Self::Under { w2, .. } | Self::Over { w2, l1: ..=0.0, .. }
                if is_far_from_one(first) =>
            {
                [g[1] * ((1.0 - first) / w2), g[1] * s]
            }
            // (1 - cos)/w2 = s^2/(1 + cos)
            Self::Under { eta: 0.0, .. } => [g[1] * (s * s / (1.0 + first)), g[1] * s],
            Self::Under {
                w2,
                eta,
                damped_frequency,
            } => {
                let rise = if w2 > 0.0 {
                    under_one_minus_cp(eta, damped_frequency, t) / w2
                } else {
                    0.5 * t * t
                };
                [g[1] * rise, g[1] * s]
            }
            Self::Over { l1, l2, .. } => [g[1] * over_load_response(l1, l2, t), g[1] * s],
            Self::Spiral { sigma, omega } => {
                let (root, moved) = (Complex::new(sigma, omega), Complex::new(first - 1.0, cross));
                let grown = if moved.norm_sqr() > FAR_FROM_ONE * FAR_FROM_ONE {
                    moved / root
                } else {
                    t * phi1(root * t)
                };
                let x = Complex::new(g[0], g[1]) * grown;
                [x.re, x.im]
            }
            Self::Decays { roots } => [(0, first), (1, second)].map(|(k, e)| {
                let grown = if is_far_from_one(e) {
                    (e - 1.0) / roots[k]
                } else {
                    t * phi1((roots[k] * t).into()).re
                };
                g[k] * grown
            }),
        }
    }
}

fn is_far_from_one(x: f64) -> bool {
    (x - 1.0).abs() > FAR_FROM_ONE
}

#[cfg(test)]
mod tests {
    use crate::linalg::plane::{plus, times};
    use crate::modal::Block;

    #[test]
    fn a_position_beside_a_fast_root_that_grows_keeps_its_digits() {
        let block = Block::Oscillator {
            w2: 2.5e-4,
            eta: -20.0,
        };
        for t in [0.01, 0.05, 0.2, 0.4] {
            let [once, twice] = [t, 2.0 * t].map(|t| block.propagation().over(t));
            // e^{2 A t} = (e^{A t})^2
            let terms = [once[0][0] * once[0][0], once[0][1] * once[1][0]];
            let off = twice[0][0] - (terms[0] + terms[1]);
            let size = terms[0].abs() + terms[1].abs();
            assert!(off.abs() < 1e-14 * size, "{t} {off:e} {size:e}");
        }
    }

    #[test]
    fn the_response_to_a_load_keeps_its_digits_and_composes() {
        let blocks = [
            Block::Oscillator { w2: 2.0, eta: 0.0 },
            Block::Oscillator { w2: 2.0, eta: 0.1 },
            Block::Oscillator { w2: 2.0, eta: -0.1 },
            Block::Oscillator { w2: 9.0, eta: 3.0 },
            Block::Oscillator { w2: 3.0, eta: 40.0 },
            Block::Oscillator {
                w2: 1e-12,
                eta: 0.0,
            },
            Block::Oscillator {
                w2: 1e-12,
                eta: 0.3,
            },
            Block::Oscillator { w2: 0.0, eta: 0.0 },
            Block::Oscillator { w2: 0.0, eta: 0.3 },
            Block::Oscillator { w2: -0.5, eta: 0.1 },
            Block::Spiral {
                sigma: -0.1,
                omega: 2.0,
            },
            // Slow beside the time, so that one unknown of a load on the other is a small part of its response.
            Block::Spiral {
                sigma: 0.0,
                omega: 2e-8,
            },
            Block::Spiral {
                sigma: -0.2,
                omega: 1e-6,
            },
            Block::Decays {
                roots: [-0.2, -3.0],
            },
            Block::Decays { roots: [0.0, 0.4] },
        ];
        for block in blocks {
            let g = match block {
                Block::Oscillator { .. } => [0.0, 0.7],
                _ => [0.7, -0.4],
            };
            let propagation = block.propagation();
            let mut t = 1e-9;
            while t < 20.0 {
                let exponential = propagation.over(t);
                let once = propagation.loaded(t, &exponential, g);
                let twice = propagation.loaded(2.0 * t, &propagation.over(2.0 * t), g);
                // z(2t) = e^{A t} z(t) + z(t)
                let composed = plus(times(&exponential, once), once);
                let terms = [0, 1].map(|c| {
                    let row = exponential[c];
                    (row[0] * once[0]).abs() + (row[1] * once[1]).abs() + once[c].abs()
                });
                for c in 0..2 {
                    let error = (twice[c] - composed[c]).abs();
                    assert!(error <= 1e-14 * terms[c], "{block:?} {t} {c}: {error:e}");
                }
                t *= 1.07;
            }
        }
    }
}

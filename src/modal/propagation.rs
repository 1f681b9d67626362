//! The matrix exponential of a block of two unknowns, in the form that its roots ask for (theory 4).

use crate::linalg::exponential::sinc;
use crate::linalg::plane::Pair;

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
    /// `e^{A t}`.
    #[inline]
    pub fn over(self, t: f64) -> Matrix {
        match self {
            Self::Under {
                w2,
                eta,
                damped_frequency: wd,
            } => {
                let decay = (-eta * t).exp();
                let (sin, cos) = (wd * t).sin_cos();
                let s = if (wd * t).abs() < 1e-4 {
                    decay * t * sinc(wd * t)
                } else {
                    decay * sin / wd
                };
                let c = decay * cos;
                [[c + eta * s, s], [-w2 * s, c - eta * s]]
            }
            Self::Over {
                w2,
                l1,
                l2,
                half_gap,
            } => {
                let (e1, e2) = ((l1 * t).exp(), (l2 * t).exp());
                let s = -e1 * (-2.0 * half_gap * t).exp_m1() / (2.0 * half_gap);
                [[e1 - l1 * s, s], [-w2 * s, e2 + l1 * s]]
            }
            Self::Spiral { sigma, omega } => {
                let (sin, cos) = (omega * t).sin_cos();
                let growth = (sigma * t).exp();
                [[growth * cos, -growth * sin], [growth * sin, growth * cos]]
            }
            Self::Decays { roots } => [[(roots[0] * t).exp(), 0.0], [0.0, (roots[1] * t).exp()]],
        }
    }
}

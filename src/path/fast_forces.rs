//! Integrals of contact forces along exact flights with stops held, however fast the structure turns meanwhile.
//!
//! The motion that is left has blocks `z' = A z + g` of its own, and a contact force is `L = l - sum rho.z`, with g and l as slow as
//! what drives the motion. With `sigma = -A^-T rho` on those blocks that turn many times, `S = sum sigma.z` has the rate
//! `S' = -sum rho.z + sum sigma.g`: it takes everything fast out of L, so that
//!
//! ```text
//! integral of L dt = S(end) - S(start) + integral of (L - S') dt
//! ```
//!
//! holds for any S, and takes nodes for what is slow alone.

use crate::flow::{RegimeMotion, along};
use crate::law::Regime;
use crate::modal::{Block, Form, Pair};
use crate::path::evaluator::Evaluator;
use crate::path::fading::Rates;
use crate::tolerance::FAST_TURN;
use nalgebra::DVector;

/// The function S whose rate is the fast part of the contact forces along an arc.
pub(super) struct FastPart<'a> {
    motion: &'a RegimeMotion,
    /// sigma of each force, for every block; zero of those that are slow.
    sigmas: Vec<Vec<Pair>>,
    /// The rates of what is left.
    pub rates: Rates,
}

impl<'a> FastPart<'a> {
    /// The fast part on an arc of some length along which stops are held; `None` where nothing is fast, or the motion does not uncouple.
    pub fn new(evaluator: &'a Evaluator, regime: &Regime, span: f64) -> Option<Self> {
        let Evaluator::Exact { modal, regimes, .. } = evaluator else {
            return None;
        };
        let motion = regimes.iter().find(|motion| motion.regime == *regime)?;
        let Form::Blocks(blocks) = motion.form() else {
            return None;
        };
        let is_fast = |block: &Block| {
            block
                .roots()
                .iter()
                .all(|root| root.norm() * span > FAST_TURN)
        };
        if !blocks.iter().any(is_fast) {
            return None;
        }
        let sigma = |(block, &rho): (&Block, &Pair)| {
            if is_fast(block) {
                against(block.matrix(), rho)
            } else {
                [0.0; 2]
            }
        };
        let sigmas = motion.forces.iter();
        let sigmas = sigmas.map(|force| blocks.iter().zip(&force.row).map(sigma).collect());
        Some(Self {
            sigmas: sigmas.collect(),
            rates: Rates::without(motion.form(), modal, is_fast),
            motion,
        })
    }

    /// S of each force at a position and velocity; its rate, at a velocity and acceleration.
    pub fn of(&self, q: &DVector<f64>, v: &DVector<f64>) -> Vec<f64> {
        let state = self.motion.reduce_change(q, v);
        let each = self.sigmas.iter();
        each.map(|sigma| along(sigma, &state)).collect()
    }
}

/// `-A^-T rho`
fn against([[a, b], [c, d]]: [Pair; 2], rho: Pair) -> Pair {
    let determinant = a * d - b * c;
    [
        -(d * rho[0] - c * rho[1]) / determinant,
        -(a * rho[1] - b * rho[0]) / determinant,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sigma_solves_its_equation() {
        let (a, rho) = ([[0.3, 1.7], [-4.0, -0.2]], [0.6, -1.1]);
        let sigma = against(a, rho);
        for i in 0..2 {
            let along = a[0][i] * sigma[0] + a[1][i] * sigma[1];
            assert!((along + rho[i]).abs() < 1e-15);
        }
    }
}

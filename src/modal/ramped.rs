//! The responses of a block from rest to powers of time (theory 11): `R_m(t) = t^{m+1} phi_{m+1}(A t) g`, what `t^m/m!` along g leaves.

use crate::linalg::plane::{Pair, plus, times};
use crate::modal::block::Block;
use nalgebra::Complex;

/// Angle [rad] of a block up to which its response is taken by a power series; a longer time is halved until it is. [work]
const RAMP_TURN: f64 = 1.0;
/// Terms of that series: the next, below 1/20!, is below rounding. [exact]
const RAMP_TERMS: u32 = 20;

impl Block {
    /// `R_0` to `R_{orders-1}` over a time.
    ///
    /// Over a short time the highest is had by its series and those below from it, `R_m = A R_{m+1} + t^{m+1}/(m+1)! g`: no difference
    /// of like numbers. Over a longer one from its half, h: `R_m(2h) = e^{A h} R_m(h) + sum_k h^{m-k}/(m-k)! R_k(h)`.
    pub fn ramped(self, t: f64, orders: usize, g: Pair) -> Vec<Pair> {
        if g == [0.0, 0.0] || orders == 0 {
            return vec![[0.0, 0.0]; orders];
        }
        let turn = self
            .roots()
            .map(Complex::norm)
            .into_iter()
            .fold(0.0, f64::max)
            * t.abs();
        let doublings = if turn > RAMP_TURN {
            (turn / RAMP_TURN).log2().ceil() as i32
        } else {
            0
        };
        let mut h = t * 2f64.powi(-doublings);
        let mut responses = self.ramped_shortly(h, orders, g);
        for _ in 0..doublings {
            let carried = self.propagator(h);
            for m in (0..orders).rev() {
                let mut sum = times(&carried, responses[m]);
                let mut factor = 1.0;
                for k in (0..=m).rev() {
                    sum = plus(sum, responses[k].map(|r| factor * r));
                    factor *= h / (m - k + 1) as f64;
                }
                responses[m] = sum;
            }
            h *= 2.0;
        }
        responses
    }

    fn ramped_shortly(self, t: f64, orders: usize, g: Pair) -> Vec<Pair> {
        let matrix = self.matrix();
        // powers[m] = t^m/m!
        let powers: Vec<f64> = (1..=orders)
            .scan(1.0, |power, m| {
                *power *= t / m as f64;
                Some(*power)
            })
            .collect();
        let mut responses = vec![[0.0, 0.0]; orders];
        let mut term = g.map(|g| g * powers[orders - 1]);
        let mut highest = term;
        for k in 1..RAMP_TERMS {
            let factor = t / (orders as f64 + f64::from(k));
            term = times(&matrix, term).map(|x| factor * x);
            highest = plus(highest, term);
        }
        responses[orders - 1] = highest;
        for m in (0..orders - 1).rev() {
            let forced = g.map(|g| g * powers[m]);
            responses[m] = plus(times(&matrix, responses[m + 1]), forced);
        }
        responses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCKS: [Block; 11] = [
        Block::Oscillator { w2: 4.0, eta: 0.1 },
        Block::Oscillator { w2: 4.0, eta: 0.0 },
        Block::Oscillator { w2: 4.0, eta: 2.0 },
        Block::Oscillator {
            w2: 4.0,
            eta: 300.0,
        },
        Block::Oscillator { w2: 0.0, eta: 0.0 },
        Block::Oscillator { w2: 0.0, eta: 0.3 },
        Block::Oscillator { w2: -1.0, eta: 0.2 },
        Block::Oscillator {
            w2: 1e-14,
            eta: 0.0,
        },
        Block::Spiral {
            sigma: -0.2,
            omega: 3.0,
        },
        Block::Decays {
            roots: [-0.1, -40.0],
        },
        Block::Decays { roots: [0.0, -2.0] },
    ];

    /// By the equation itself: `R_m' = A R_m + t^m/m! g`, integrated by Gauss's rule over many short steps.
    fn integrated(block: Block, t: f64, m: i32, g: Pair) -> Pair {
        // int_0^t e^{A (t - s)} s^m/m! g ds
        let nodes = [
            -0.906_179_845_938_664,
            -0.538_469_310_105_683_1,
            0.0,
            0.538_469_310_105_683_1,
            0.906_179_845_938_664,
        ];
        let weights = [
            0.236_926_885_056_189_08,
            0.478_628_670_499_366_47,
            0.568_888_888_888_888_9,
            0.478_628_670_499_366_47,
            0.236_926_885_056_189_08,
        ];
        let count = 2000;
        let h = t / f64::from(count);
        let factorial: f64 = (1..=m).map(f64::from).product();
        let mut sum = [0.0, 0.0];
        for i in 0..count {
            for (x, w) in nodes.iter().zip(weights) {
                let s = h * (f64::from(i) + 0.5 * (1.0 + x));
                let input = g.map(|g| g * s.powi(m) / factorial);
                let response = times(&block.propagator(t - s), input);
                sum = plus(sum, response.map(|r| 0.5 * h * w * r));
            }
        }
        sum
    }

    #[test]
    fn powers_of_time_give_what_their_convolution_gives() {
        for block in BLOCKS {
            let g = match block {
                Block::Oscillator { .. } => [0.0, 0.7],
                _ => [0.7, -0.4],
            };
            for t in [0.01, 0.4, 3.0] {
                let responses = block.ramped(t, 6, g);
                let size = |z: Pair| z[0].abs().max(z[1].abs());
                for (m, response) in (0..).zip(responses) {
                    let expected = integrated(block, t, m, g);
                    let off = size([response[0] - expected[0], response[1] - expected[1]]);
                    assert!(
                        off <= 2e-13 * size(expected),
                        "{block:?} {t} {m}: {off:e} of {:e}",
                        size(expected)
                    );
                }
            }
        }
    }

    #[test]
    fn the_lowest_is_the_response_to_a_load_and_all_compose() {
        for block in BLOCKS {
            let g = match block {
                Block::Oscillator { .. } => [0.0, 0.7],
                _ => [0.7, -0.4],
            };
            let mut t = 1e-6;
            while t < 100.0 {
                let responses = block.ramped(t, 4, g);
                let loaded = block.loaded(t, g);
                for c in 0..2 {
                    let size = loaded[0].abs().max(loaded[1].abs());
                    let off = (responses[0][c] - loaded[c]).abs();
                    assert!(
                        off <= 1e-13 * size,
                        "{block:?} {t} {c}: {off:e} of {size:e}"
                    );
                }
                t *= 3.0;
            }
        }
    }
}

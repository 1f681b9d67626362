//! Periodic Green's functions (theory 5): what an impulse, repeated with the period T, has left of itself a time tau after
//! it, `e^{A tau} (I - e^{A T})^-1 jump` mode by mode, as functions of tau with proved bounds on their derivatives.

use crate::modal::{Block, Pair, times};
use crate::orbit::two_instants::taylor_model::{TAYLOR_TERMS, UnscaledModel};

/// A span of times and the point in it about which functions of time are expanded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimeInterval {
    /// Where the expansion is centred.
    pub origin: f64,
    /// Time per unit x; the cell lies within `|x| <= 1`.
    pub scale: f64,
    pub low: f64,
    pub high: f64,
}

/// The motion of uncoupled blocks after one impulse, tau = 0 right after it.
pub(crate) struct Green {
    blocks: Vec<(Block, Pair)>,
    /// `(weight, growth)` of the norm of each block.
    norms: Vec<(f64, f64)>,
}

impl Green {
    /// The blocks with their states at tau = 0; `softest` as in `Block::norm`.
    pub fn new(blocks: Vec<(Block, Pair)>, softest: f64) -> Self {
        let norms = blocks
            .iter()
            .map(|(block, _)| block.norm(softest))
            .map(|n| (n.weight, n.growth))
            .collect();
        Self { blocks, norms }
    }

    /// The states at tau, block by block.
    pub fn states(&self, tau: f64) -> impl Iterator<Item = Pair> {
        self.blocks
            .iter()
            .map(move |(block, z)| times(&block.propagator(tau), *z))
    }

    /// Adds to each of `out` its factor times what its row sees of the motion over a cell of tau. With `backward` the
    /// functions are of -tau: x counts against it.
    pub fn add(
        &self,
        cell: &TimeInterval,
        backward: bool,
        rows: &[(f64, Vec<Pair>)],
        out: &mut [UnscaledModel],
    ) {
        let step = if backward { -cell.scale } else { cell.scale };
        for (j, ((block, start), (weight, growth))) in
            self.blocks.iter().zip(&self.norms).enumerate()
        {
            let a = block.matrix().map(|row| row.map(|x| x * step));
            let mut chain = [[0.0; 2]; TAYLOR_TERMS + 2];
            chain[0] = times(&block.propagator(cell.origin), *start);
            for k in 1..TAYLOR_TERMS + 2 {
                chain[k] = times(&a, chain[k - 1]).map(|x| x / k as f64);
            }
            // The free motion is largest at the early end in this norm, whatever the derivative, but for its growth.
            let mut early = times(&block.propagator(cell.low), *start);
            for k in 1..=TAYLOR_TERMS {
                early = times(&a, early).map(|x| x / k as f64);
            }
            let grown = (growth * (cell.high - cell.low)).exp();
            let mut rest = [0.0; 3];
            for (i, rest) in rest.iter_mut().enumerate() {
                *rest = grown * (weight * early[0] * early[0] + early[1] * early[1]).sqrt();
                early = times(&a, early).map(|x| x / (TAYLOR_TERMS + 1 + i) as f64);
            }
            for ((factor, row), entry) in rows.iter().zip(out.iter_mut()) {
                let r = row[j];
                if r == [0.0, 0.0] {
                    continue;
                }
                for (c, z) in entry.c.iter_mut().zip(&chain) {
                    *c += factor * (r[0] * z[0] + r[1] * z[1]);
                }
                let dual = factor.abs() * (r[0] * r[0] / weight + r[1] * r[1]).sqrt();
                for (sum, rest) in entry.rest.iter_mut().zip(rest) {
                    *sum += dual * rest;
                }
                entry.size +=
                    factor.abs() * ((r[0] * chain[0][0]).abs() + (r[1] * chain[0][1]).abs());
            }
        }
    }
}

/// A steady response `cosine u_0 + sine u_1` at the time t later, as a function of t over an interval: the two coefficients of `u` at t = 0.
pub(crate) fn turned(
    cell: &TimeInterval,
    frequency: f64,
    [cosine, sine]: Pair,
) -> [UnscaledModel; 2] {
    let (s, c) = (frequency * cell.origin).sin_cos();
    let mut value = [cosine * c + sine * s, sine * c - cosine * s];
    let size = cosine.abs() + sine.abs();
    let mut entries = [UnscaledModel {
        size,
        ..UnscaledModel::default()
    }; 2];
    let amplitude = cosine.hypot(sine);
    let mut factor = 1.0;
    for k in 0..TAYLOR_TERMS + 3 {
        if k < TAYLOR_TERMS + 2 {
            entries[0].c[k] = factor * value[0];
            entries[1].c[k] = factor * value[1];
        }
        if k >= TAYLOR_TERMS {
            entries[0].rest[k - TAYLOR_TERMS] = factor.abs() * amplitude;
            entries[1].rest[k - TAYLOR_TERMS] = factor.abs() * amplitude;
        }
        // d/dt turns the response by a quarter: (a cos + b sin)' = w (b cos - a sin).
        value = [value[1], -value[0]];
        factor *= frequency * cell.scale / (k + 1) as f64;
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn green_functions_stay_inside_their_bounds() {
        let blocks = [
            Block::Oscillator { w2: 4.0, eta: 0.1 },
            Block::Oscillator { w2: 4.0, eta: 2.0 },
            Block::Oscillator { w2: 4.0, eta: 40.0 },
            Block::Oscillator { w2: 0.0, eta: 0.3 },
            Block::Oscillator { w2: -0.5, eta: 0.2 },
            Block::Spiral {
                sigma: -0.2,
                omega: 1.5,
            },
            Block::Decays {
                roots: [-0.5, -30.0],
            },
        ];
        for block in blocks {
            let green = Green::new(vec![(block, [0.7, -1.3])], 0.5);
            let rows = [(1.5, vec![[0.6, -0.2]]), (-1.0, vec![[0.0, 1.0]])];
            for (origin, low, scale) in [
                (0.4, 0.2, 0.2),
                (0.0, 0.0, 0.3),
                (0.05, 0.0, 0.05),
                (2.0, 1.7, 0.3),
            ] {
                let cell = TimeInterval {
                    origin,
                    scale,
                    low,
                    high: origin + scale,
                };
                let mut out = [UnscaledModel::default(); 2];
                green.add(&cell, false, &rows, &mut out);
                for i in 0..=20 {
                    let t = low + (cell.high - low) * f64::from(i) / 20.0;
                    let z: Vec<Pair> = green.states(t).collect();
                    for ((factor, row), entry) in rows.iter().zip(&out) {
                        let exact = factor * (row[0][0] * z[0][0] + row[0][1] * z[0][1]);
                        let (x, f) = ((t - origin) / scale, entry.series(1.0));
                        let miss = (f.value(x) - exact).abs();
                        assert!(
                            miss <= f.remainder() * x.abs().powi(8) + 1e-12,
                            "{block:?} {t} {miss:e}"
                        );
                        let next = entry.rest[1] * x.abs().powi(9);
                        assert!(
                            (f.value(x) + entry.c[TAYLOR_TERMS] * x.powi(8) - exact).abs()
                                <= next + 1e-12
                        );
                    }
                }
                let mut back = [UnscaledModel::default(); 2];
                green.add(&cell, true, &rows, &mut back);
                assert!(
                    (back[0].series(1.0).value(-0.3) - out[0].series(1.0).value(0.3)).abs() < 1e-12
                );
            }
        }
    }

    #[test]
    fn a_steady_response_turns_with_the_phase() {
        let cell = TimeInterval {
            origin: 1.1,
            scale: 0.2,
            low: 0.9,
            high: 1.3,
        };
        let [by_cos, by_sin] = turned(&cell, 2.0, [0.3, -0.8]);
        for (x, phase) in [(-1.0, 0.4), (0.6, 2.0f64)] {
            let angle = 2.0 * (1.1 + 0.2 * x) + phase;
            let exact = 0.3 * angle.cos() - 0.8 * angle.sin();
            let got = by_cos.series(1.0).value(x) * phase.cos()
                + by_sin.series(1.0).value(x) * phase.sin();
            assert!(
                (got - exact).abs() < 2.0 * by_cos.rest[0] + 1e-15,
                "{got} {exact}"
            );
        }
    }
}

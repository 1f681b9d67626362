//! Flows of linear systems in modal pairs: exact propagation over any time, and the gap of a stop as a jet with a
//! certified remainder (theory 4 and 8). The state is the whole motion, forcing included, so that nothing is subtracted
//! at a resonance.

use crate::flow::Drive;
use crate::flow::jet::Jet;
use crate::linalg::matrix_exponential::matrix_exponential;
use crate::modal::{Block, Pair};
use nalgebra::{Complex, DMatrix};

/// Smooth motion of a linear system: state in modal pairs, forcing as a phasor.
pub(crate) trait LinearFlow {
    /// `e^{i (w t + phase)}`, or nothing.
    type Phasor: Copy + Default;
    /// Everything needed to go forward by one fixed time.
    type Propagator: Default;

    /// The phasor at a forcing angle.
    fn phasor(&self, angle: f64) -> Self::Phasor;
    /// Fills the propagator for a time.
    fn prepare(&self, t: f64, propagator: &mut Self::Propagator);
    /// Moves a state and its phasor forward.
    fn advance(&self, propagator: &Self::Propagator, state: &mut [Pair], u: &mut Self::Phasor);
    /// The rate of change of a state.
    fn rate(&self, state: &[Pair], u: Self::Phasor, rate: &mut [Pair]);
    /// The rows with which the gap `clearance - row.z` is followed.
    fn gap_row(&self, row: Vec<Pair>, clearance: f64) -> GapRow;
    /// The jets of some gaps.
    fn jets(&self, state: &[Pair], u: Self::Phasor, rows: &[GapRow], jets: &mut [Jet]);
    /// The longest step for which the remainders of the jets hold.
    fn longest_step(&self) -> f64;
}

/// Carries a state over a span of time from a forcing angle.
pub(crate) fn carry<F: LinearFlow>(flow: &F, angle: f64, span: f64, state: &mut [Pair]) {
    let mut propagator = F::Propagator::default();
    flow.prepare(span, &mut propagator);
    flow.advance(&propagator, state, &mut flow.phasor(angle));
}

/// The gap of one stop in modal pairs, with the weights of its remainder.
#[derive(Debug, Clone)]
pub(crate) struct GapRow {
    row: Vec<Pair>,
    clearance: f64,
    /// Bound on what one unit of each block's third-derivative norm adds to the gap's fourth derivative.
    weights: Vec<f64>,
    /// Bound on the forcing's own part of the fourth derivative, constant and growing with time.
    forced: f64,
    forced_growth: f64,
}

/// A flow that uncouples into blocks of two.
#[derive(Debug, Clone)]
pub(crate) struct BlockFlow<D> {
    blocks: Vec<Block>,
    matrices: Vec<[Pair; 2]>,
    load: Vec<Pair>,
    /// Weight of the first unknown in each block's norm.
    norms: Vec<f64>,
    /// Growth of each block's norm over the longest step.
    growths: Vec<f64>,
    longest_step: f64,
    drive: D,
}

/// Propagator of a [`BlockFlow`].
pub(crate) struct BlockPropagator<D: Drive> {
    blocks: Vec<([Pair; 2], D::Reply, Pair)>,
    turn: D::Phasor,
}

impl<D: Drive> Default for BlockPropagator<D> {
    fn default() -> Self {
        Self {
            blocks: Vec::new(),
            turn: D::Phasor::default(),
        }
    }
}

/// The slowest rate in a list of them, 1 if all vanish.
fn softest_rate(rates: impl Iterator<Item = f64>) -> f64 {
    let least = rates
        .filter(|&r| r > 0.0 && r.is_finite())
        .fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1.0 }
}

impl<D: Drive> BlockFlow<D> {
    /// A flow of blocks under a constant load and a drive.
    pub fn new(blocks: Vec<Block>, load: Vec<Pair>, drive: D) -> Self {
        let rates = blocks.iter().flat_map(|b| b.roots().map(Complex::norm));
        let softest = softest_rate(rates.chain([drive.frequency()]));
        let norms: Vec<_> = blocks.iter().map(|b| b.norm(softest)).collect();
        let fastest_growth = norms.iter().map(|n| n.growth).fold(0.0, f64::max);
        // Steps so long that no bound more than doubles by growth.
        let longest_step = (1.0 / softest).min(0.7 / fastest_growth);
        Self {
            matrices: blocks.iter().map(|b| b.matrix()).collect(),
            norms: norms.iter().map(|n| n.weight).collect(),
            growths: norms
                .iter()
                .map(|n| (n.growth * longest_step).exp())
                .collect(),
            blocks,
            load,
            longest_step,
            drive,
        }
    }
}

#[inline]
fn times(a: &[Pair; 2], z: Pair) -> Pair {
    [
        a[0][0] * z[0] + a[0][1] * z[1],
        a[1][0] * z[0] + a[1][1] * z[1],
    ]
}

#[inline]
fn plus(a: Pair, b: Pair) -> Pair {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline]
fn dot(a: Pair, b: Pair) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl<D: Drive> LinearFlow for BlockFlow<D> {
    type Phasor = D::Phasor;
    type Propagator = BlockPropagator<D>;

    fn phasor(&self, angle: f64) -> D::Phasor {
        self.drive.phasor(angle)
    }

    fn prepare(&self, t: f64, propagator: &mut Self::Propagator) {
        propagator.turn = self.drive.turn(t);
        propagator.blocks.clear();
        propagator
            .blocks
            .extend(self.blocks.iter().enumerate().map(|(j, block)| {
                (
                    block.propagator(t),
                    self.drive.reply(j, *block, t),
                    block.loaded(t, self.load[j]),
                )
            }));
    }

    #[inline]
    fn advance(&self, propagator: &Self::Propagator, state: &mut [Pair], u: &mut D::Phasor) {
        for (z, (matrix, reply, loaded)) in state.iter_mut().zip(&propagator.blocks) {
            *z = plus(plus(times(matrix, *z), D::added(*reply, *u)), *loaded);
        }
        *u = D::turned(*u, propagator.turn);
    }

    fn rate(&self, state: &[Pair], u: D::Phasor, rate: &mut [Pair]) {
        for (j, (z, out)) in state.iter().zip(rate).enumerate() {
            *out = plus(
                plus(times(&self.matrices[j], *z), self.drive.inputs(j, u)[0]),
                self.load[j],
            );
        }
    }

    fn gap_row(&self, row: Vec<Pair>, clearance: f64) -> GapRow {
        let w = self.drive.frequency();
        let (mut weights, mut forced, mut forced_growth) =
            (Vec::with_capacity(row.len()), 0.0, 0.0);
        for (j, r) in row.iter().enumerate() {
            let a = &self.matrices[j];
            // row A, and its dual norm: |row A z| <= weight |z|
            let image = [
                r[0] * a[0][0] + r[1] * a[1][0],
                r[0] * a[0][1] + r[1] * a[1][1],
            ];
            let weight = (image[0] * image[0] / self.norms[j] + image[1] * image[1]).sqrt()
                * self.growths[j];
            let f = self.drive.force(j);
            let size = (f[1].norm_sqr() + self.norms[j] * f[0].norm_sqr()).sqrt();
            forced += (f[0] * r[0] + f[1] * r[1]).norm() * w.powi(3);
            forced_growth += weight * size * w.powi(3);
            weights.push(weight);
        }
        GapRow {
            row,
            clearance,
            weights,
            forced,
            forced_growth,
        }
    }

    #[inline]
    fn jets(&self, state: &[Pair], u: D::Phasor, rows: &[GapRow], jets: &mut [Jet]) {
        for (jet, row) in jets.iter_mut().zip(rows) {
            *jet = Jet {
                c: [row.clearance, 0.0, 0.0, 0.0],
                quartic: row.forced,
                quintic: row.forced_growth,
                size: row.clearance.abs(),
            };
        }
        for (j, &z) in state.iter().enumerate() {
            let a = &self.matrices[j];
            let [f0, f1, f2] = self.drive.inputs(j, u);
            let d1 = plus(plus(times(a, z), f0), self.load[j]);
            let d2 = plus(times(a, d1), f1);
            let d3 = plus(times(a, d2), f2);
            let norm = (d3[1] * d3[1] + self.norms[j] * d3[0] * d3[0]).sqrt();
            for (jet, gap) in jets.iter_mut().zip(rows) {
                let r = gap.row[j];
                jet.c[0] -= dot(r, z);
                jet.c[1] -= dot(r, d1);
                jet.c[2] -= dot(r, d2);
                jet.c[3] -= dot(r, d3);
                jet.quartic += gap.weights[j] * norm;
                jet.size += (r[0] * z[0]).abs() + (r[1] * z[1]).abs();
            }
        }
        for jet in jets {
            jet.c[2] *= 0.5;
            jet.c[3] *= 1.0 / 6.0;
            jet.quartic *= 1.0 / 24.0;
            jet.quintic *= 1.0 / 120.0;
        }
    }

    fn longest_step(&self) -> f64 {
        self.longest_step
    }
}

/// A flow that does not uncouple (defective state matrix): the matrix exponential of the state enlarged by 1, cos, sin.
#[derive(Debug, Clone)]
pub(crate) struct DenseFlow {
    /// State matrix in interleaved pairs, shape `(2n, 2n)`.
    matrix: DMatrix<f64>,
    /// The matrix enlarged by the load and the forcing, shape `(2n + 3, 2n + 3)`.
    enlarged: DMatrix<f64>,
    load: Vec<f64>,
    force: Vec<Complex<f64>>,
    frequency: f64,
    /// Scales of the unknowns for the norm, and its growth over the longest step.
    unit: Vec<f64>,
    growth: f64,
    longest_step: f64,
}

impl DenseFlow {
    /// A flow with the given state matrix, load and force in interleaved pairs; frequency zero without forcing.
    pub fn new(
        matrix: DMatrix<f64>,
        load: &[Pair],
        force: &[[Complex<f64>; 2]],
        frequency: f64,
    ) -> Self {
        let m = matrix.nrows();
        let load: Vec<f64> = load.iter().flatten().copied().collect();
        let force: Vec<Complex<f64>> = force.iter().flatten().copied().collect();
        let mut enlarged = DMatrix::zeros(m + 3, m + 3);
        enlarged.view_mut((0, 0), (m, m)).copy_from(&matrix);
        for i in 0..m {
            enlarged[(i, m)] = load[i];
            enlarged[(i, m + 1)] = force[i].re;
            enlarged[(i, m + 2)] = -force[i].im;
        }
        enlarged[(m + 1, m + 2)] = -frequency;
        enlarged[(m + 2, m + 1)] = frequency;
        // Positions in units of velocity over the system's own rate; the growth of the Euclidean norm is at most the
        // largest eigenvalue of the symmetric part, itself at most the norm of that part.
        let rate = {
            let stiffness = matrix.iter().fold(0.0f64, |a, &x| a.max(x.abs())).sqrt();
            if stiffness > 0.0 { stiffness } else { 1.0 }
        };
        let unit: Vec<f64> = (0..m)
            .map(|i| if i % 2 == 0 { rate } else { 1.0 })
            .collect();
        let scaled = DMatrix::from_fn(m, m, |i, j| matrix[(i, j)] * unit[i] / unit[j]);
        let growth_rate = ((&scaled + scaled.transpose()) * 0.5).norm();
        let longest_step =
            (1.0 / softest_rate([rate, frequency].into_iter())).min(0.7 / growth_rate);
        let growth = (growth_rate * longest_step).exp();
        Self {
            matrix,
            enlarged,
            load,
            force,
            frequency,
            unit,
            growth,
            longest_step,
        }
    }

    fn input(&self, u: Complex<f64>, i: usize) -> f64 {
        (self.force[i] * u).re
    }

    fn image(&self, z: &[f64]) -> Vec<f64> {
        let m = z.len();
        (0..m)
            .map(|i| (0..m).map(|j| self.matrix[(i, j)] * z[j]).sum())
            .collect()
    }
}

impl LinearFlow for DenseFlow {
    type Phasor = Complex<f64>;
    type Propagator = DMatrix<f64>;

    fn phasor(&self, angle: f64) -> Complex<f64> {
        Complex::new(angle.cos(), angle.sin())
    }

    fn prepare(&self, t: f64, propagator: &mut DMatrix<f64>) {
        *propagator = matrix_exponential(&(&self.enlarged * t));
    }

    fn advance(&self, propagator: &DMatrix<f64>, state: &mut [Pair], u: &mut Complex<f64>) {
        let m = self.matrix.nrows();
        let z: Vec<f64> = state
            .iter()
            .flatten()
            .copied()
            .chain([1.0, u.re, u.im])
            .collect();
        let row = |i: usize| (0..m + 3).map(|j| propagator[(i, j)] * z[j]).sum::<f64>();
        for (i, pair) in state.iter_mut().enumerate() {
            *pair = [row(2 * i), row(2 * i + 1)];
        }
        *u = Complex::new(row(m + 1), row(m + 2));
    }

    fn rate(&self, state: &[Pair], u: Complex<f64>, rate: &mut [Pair]) {
        let z: Vec<f64> = state.iter().flatten().copied().collect();
        let image = self.image(&z);
        for (i, out) in rate.iter_mut().enumerate() {
            *out =
                [0, 1].map(|k| image[2 * i + k] + self.input(u, 2 * i + k) + self.load[2 * i + k]);
        }
    }

    fn gap_row(&self, row: Vec<Pair>, clearance: f64) -> GapRow {
        let m = self.matrix.nrows();
        let flat: Vec<f64> = row.iter().flatten().copied().collect();
        let norm = (0..m)
            .map(|j| {
                let image: f64 = (0..m).map(|i| flat[i] * self.matrix[(i, j)]).sum();
                (image / self.unit[j]).powi(2)
            })
            .sum::<f64>()
            .sqrt();
        let w3 = self.frequency.powi(3);
        let direct: Complex<f64> = flat.iter().zip(&self.force).map(|(r, f)| f * *r).sum();
        let size = self
            .force
            .iter()
            .zip(&self.unit)
            .map(|(f, s)| f.norm_sqr() * s * s)
            .sum::<f64>()
            .sqrt();
        let weight = norm * self.growth;
        GapRow {
            row,
            clearance,
            weights: vec![weight],
            forced: direct.norm() * w3,
            forced_growth: weight * size * w3,
        }
    }

    fn jets(&self, state: &[Pair], u: Complex<f64>, rows: &[GapRow], jets: &mut [Jet]) {
        let z: Vec<f64> = state.iter().flatten().copied().collect();
        let iw = Complex::new(0.0, self.frequency);
        let mut derivatives = vec![z];
        let mut phasor = u;
        for order in 0..3 {
            let mut next = self.image(&derivatives[order]);
            for (i, x) in next.iter_mut().enumerate() {
                *x += self.input(phasor, i) + if order == 0 { self.load[i] } else { 0.0 };
            }
            phasor *= iw;
            derivatives.push(next);
        }
        let norm = derivatives[3]
            .iter()
            .zip(&self.unit)
            .map(|(d, s)| (d * s).powi(2))
            .sum::<f64>()
            .sqrt();
        for (jet, gap) in jets.iter_mut().zip(rows) {
            let along = |d: &[f64]| {
                gap.row
                    .iter()
                    .flatten()
                    .zip(d)
                    .map(|(r, x)| r * x)
                    .sum::<f64>()
            };
            let size = gap
                .row
                .iter()
                .flatten()
                .zip(&derivatives[0])
                .map(|(r, x)| (r * x).abs())
                .sum::<f64>();
            *jet = Jet {
                c: [
                    gap.clearance - along(&derivatives[0]),
                    -along(&derivatives[1]),
                    -along(&derivatives[2]) / 2.0,
                    -along(&derivatives[3]) / 6.0,
                ],
                quartic: (gap.forced + gap.weights[0] * norm) / 24.0,
                quintic: gap.forced_growth / 120.0,
                size: gap.clearance.abs() + size,
            };
        }
    }

    fn longest_step(&self) -> f64 {
        self.longest_step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::{HarmonicDrive, Undriven};

    fn flows() -> (Vec<Block>, Vec<Pair>, HarmonicDrive) {
        let blocks = vec![
            Block::Oscillator { w2: 2.0, eta: 0.1 },
            Block::Oscillator { w2: 30.0, eta: 9.0 },
            Block::Oscillator { w2: 0.0, eta: 0.0 },
            Block::Oscillator { w2: 9.0, eta: 3.0 },
            Block::Oscillator { w2: -0.5, eta: 0.1 },
        ];
        let force = [0.7, -0.3, 0.1, 0.9, 0.2]
            .map(|f| [0.0.into(), Complex::new(f, 0.4 * f)])
            .to_vec();
        (
            blocks,
            vec![[0.0, 0.2]; 5],
            HarmonicDrive {
                frequency: 1.5,
                force,
            },
        )
    }

    /// Every flow: composes, agrees with its rate, and keeps its jets' promise.
    fn contract<F: LinearFlow>(flow: &F, n: usize) {
        let start: Vec<Pair> = (0..n)
            .map(|i| [0.3 - 0.1 * i as f64, 0.5 + 0.2 * i as f64])
            .collect();
        let go = |t: f64, state: &mut Vec<Pair>, u: &mut F::Phasor| {
            let mut p = F::Propagator::default();
            flow.prepare(t, &mut p);
            flow.advance(&p, state, u);
        };
        let at = |t: f64| {
            let (mut state, mut u) = (start.clone(), flow.phasor(0.4));
            go(t, &mut state, &mut u);
            (state, u)
        };
        let close = |a: &[Pair], b: &[Pair], tolerance: f64| {
            let error = a
                .iter()
                .flatten()
                .zip(b.iter().flatten())
                .map(|(x, y)| (x - y).abs())
                .fold(0.0, f64::max);
            assert!(error < tolerance, "{error:e}");
        };
        let (mut state, mut u) = at(0.7);
        go(0.9, &mut state, &mut u);
        close(&state, &at(1.6).0, 1e-13);
        let step = 1e-5;
        let (mut rate, forward, backward) = (vec![[0.0; 2]; n], at(0.7 + step).0, at(0.7 - step).0);
        let (state, u) = at(0.7);
        flow.rate(&state, u, &mut rate);
        let difference: Vec<Pair> = forward
            .iter()
            .zip(&backward)
            .map(|(a, b)| [0, 1].map(|k| (a[k] - b[k]) / (2.0 * step)))
            .collect();
        close(&rate, &difference, 1e-7);

        let rows = [flow.gap_row((0..n).map(|i| [0.5 + 0.3 * i as f64, 0.1]).collect(), 1.0)];
        let mut jets = [Jet::default()];
        flow.jets(&state, u, &rows, &mut jets);
        for k in 1..=100 {
            let s = flow.longest_step() * f64::from(k) / 100.0;
            let (later, phasor) = at(0.7 + s);
            let mut there = [Jet::default()];
            flow.jets(&later, phasor, &rows, &mut there);
            let miss = (there[0].c[0] - jets[0].value(s)).abs();
            assert!(
                miss <= jets[0].remainder(s) + 1e-14 * there[0].size,
                "{s} {miss:e} {:e}",
                jets[0].remainder(s)
            );
        }
    }

    #[test]
    fn every_flow_keeps_the_contract() {
        let (blocks, load, drive) = flows();
        contract(&BlockFlow::new(blocks.clone(), load.clone(), Undriven), 5);
        contract(&BlockFlow::new(blocks, load, drive), 5);
        let pairs = vec![
            Block::Spiral {
                sigma: -0.1,
                omega: 2.0,
            },
            Block::Decays {
                roots: [-0.2, -3.0],
            },
        ];
        let force = vec![[Complex::new(0.3, 0.1), Complex::new(-0.2, 0.4)]; 2];
        contract(
            &BlockFlow::new(
                pairs,
                vec![[0.1, 0.2]; 2],
                HarmonicDrive {
                    frequency: 0.8,
                    force: force.clone(),
                },
            ),
            2,
        );
        let matrix = nalgebra::dmatrix![
            0.0, 1.0, 0.0, 0.0;
            -1.0, 0.0, -1.0, 0.0;
            0.0, 0.0, 0.0, 1.0;
            0.0, 0.0, -1.0, 0.0
        ];
        contract(
            &DenseFlow::new(matrix, &[[0.0, 0.2], [0.0, 0.1]], &force, 0.8),
            2,
        );
    }
}

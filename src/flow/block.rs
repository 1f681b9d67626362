//! A linear flow that uncouples into blocks of two (theory 4). The state is the whole motion, forcing included, so that
//! nothing is subtracted at a resonance; the `(cos, sin)` of each harmonic of the forcing is one more pair at its end, and the
//! derivatives of each signal are some.

use crate::flow::drive::{Alone, Drive};
use crate::flow::gap_row::{Derivatives, GapRow, Quantity};
use crate::flow::linear::{FlowRates, FlowRows, LinearFlow, fitted_step, softest_rate};
use crate::flow::registers::turned;
use crate::flow::samples::{SampleDerivatives, Stride};
use crate::linalg::plane::{longer_than, plus, times};
use crate::modal::{Block, ModalState, Pair, Propagation};
use crate::model::Moment;
use nalgebra::Complex;

/// Blocks whose exponentials are made at once. [work]
const BLOCKS_AT_ONCE: usize = 4;
/// Number of blocks up to which eight samples at once are faster than one after another. [work]
const MOST_SAMPLED_BLOCKS: usize = 64;

/// One block with what its propagation and its bounds need.
#[derive(Debug, Clone)]
struct FlowBlock {
    block: Block,
    propagation: Propagation,
    matrix: [Pair; 2],
    /// Where the load holds it at rest; the origin where it never rests.
    equilibrium: Pair,
    /// Weight of the first unknown in the block's norm.
    weight: f64,
    /// Its root.
    scale: f64,
    /// Whether the norm of the unforced block about its equilibrium never grows.
    is_bounded: bool,
    /// Growth of the third derivative's norm over the longest step.
    growth: f64,
}

/// A flow that uncouples into blocks of two.
#[derive(Debug, Clone)]
pub(crate) struct BlockFlow<D> {
    parts: Vec<FlowBlock>,
    longest_step: f64,
    holds_for_ever: bool,
    /// The longest step within a piece of a signal.
    longest_in_piece: f64,
    fastest_rate: f64,
    fastest_growth: f64,
    drive: D,
}

/// Propagator of a [`BlockFlow`].
pub(crate) struct BlockPropagator<D: Drive> {
    parts: Vec<([Pair; 2], D::Reply)>,
    turn: D::Turn,
}

impl<D: Drive> Default for BlockPropagator<D> {
    fn default() -> Self {
        Self {
            parts: Vec::new(),
            turn: D::Turn::default(),
        }
    }
}

impl<D: Drive> BlockFlow<D> {
    /// A flow of blocks under a drive.
    pub fn new(blocks: &[Block], drive: D) -> Self {
        let rates = blocks.iter().flat_map(|b| b.roots().map(Complex::norm));
        let rates = rates.chain(drive.frequencies());
        // A signal may change as a whole in the time of a piece.
        let pieces = drive.pieces();
        let of_pieces = pieces.map_or(0.0, |[shortest, _]| 1.0 / shortest);
        let fastest_rate = rates.clone().fold(of_pieces, f64::max);
        let softest = softest_rate(rates);
        let roots = blocks.iter().flat_map(|b| b.roots());
        let fastest_growth = roots.map(|l| l.re).fold(0.0, f64::max);
        let growth = |j: usize| {
            let mut forces = drive.forces(j).flat_map(|(_, f)| f);
            let is_free =
                forces.all(|f| f.norm() == 0.0) && drive.signals(j).all(|d| d == [0.0, 0.0]);
            third_derivative_growth(blocks[j], is_free, softest)
        };
        let norm_growth = (0..blocks.len()).map(growth).fold(0.0, f64::max);
        // Steps so long that no bound more than doubles by growth.
        let longest_step = fitted_step((1.0 / softest).min(0.7 / norm_growth), pieces);
        let holds_for_ever = norm_growth == 0.0;
        let most = if holds_for_ever {
            f64::INFINITY
        } else {
            longest_step
        };
        let part = |(j, &block): (usize, &Block)| {
            let norm = block.norm(softest);
            let rest = block.equilibrium(drive.load(j));
            let has_rest = rest.iter().all(|x| x.is_finite());
            FlowBlock {
                block,
                propagation: block.propagation(),
                matrix: block.matrix(),
                equilibrium: if has_rest { rest } else { [0.0, 0.0] },
                weight: norm.weight,
                scale: norm.weight.sqrt(),
                is_bounded: norm.growth == 0.0 && has_rest,
                growth: (growth(j) * longest_step).exp(),
            }
        };
        Self {
            parts: blocks.iter().enumerate().map(part).collect(),
            longest_step,
            holds_for_ever,
            longest_in_piece: pieces.map_or(most, |[_, longest]| longest.min(most)),
            fastest_rate,
            fastest_growth,
            drive,
        }
    }
}

/// How fast the third derivative of a block may grow. Without stiffness and force it lies in the range of the block's matrix,
/// `(1, -2 eta)`, where it decays as `e^{-2 eta t}` whatever the motion does: a rigid body never leaves its cubic.
fn third_derivative_growth(block: Block, is_free: bool, softest: f64) -> f64 {
    match block {
        Block::Oscillator { w2: 0.0, eta } if is_free && eta >= 0.0 => 0.0,
        _ => block.norm(softest).growth,
    }
}

impl<D: Drive> LinearFlow for BlockFlow<D> {
    type Propagator = BlockPropagator<D>;

    fn state_from_modal(&self, modal_state: &ModalState, at: Moment, state: &mut Vec<Pair>) {
        let (n, n_pairs) = (modal_state.len(), self.drive.n_pairs());
        state.clear();
        state.reserve(n + n_pairs);
        state.extend_from_slice(modal_state);
        state.resize(n + n_pairs, [0.0, 0.0]);
        self.drive.store(at, &mut state[n..]);
    }

    fn modal_from_state(&self, state: &[Pair], modal_state: &mut ModalState) {
        modal_state.clear();
        modal_state.extend_from_slice(&state[..self.parts.len()]);
    }

    fn set_moment(&self, state: &mut [Pair], at: Moment) {
        self.drive.store(at, &mut state[self.parts.len()..]);
    }

    fn prepare(&self, t: f64, propagator: &mut Self::Propagator) {
        propagator.turn = self.drive.turn(t);
        propagator.parts.clear();
        for (chunk, parts) in self.parts.chunks(BLOCKS_AT_ONCE).enumerate() {
            let [mut angles, mut exponents] = [[0.0; BLOCKS_AT_ONCE]; 2];
            for (k, part) in parts.iter().enumerate() {
                [angles[k], exponents[k]] = part.propagation.rates().map(|rate| rate * t);
            }
            let turned = turned(&angles, &exponents);
            let made = parts.iter().enumerate().map(|(k, part)| {
                let turn = (turned.sines[k], turned.cosines[k]);
                let alone = Alone {
                    block: part.block,
                    propagation: part.propagation,
                    t,
                    exponential: part.propagation.made_of(t, turn, turned.powers[k]),
                };
                let reply = self.drive.reply(BLOCKS_AT_ONCE * chunk + k, &alone);
                (alone.exponential, reply)
            });
            propagator.parts.extend(made);
        }
    }

    fn strides(&self, propagator: &Self::Propagator) -> Option<Vec<Stride>> {
        let constant = D::read(&[]);
        let strides = (propagator.parts.iter())
            .map(|(matrix, reply)| Stride::of(matrix, D::added(reply, constant)));
        (D::IS_CONSTANT && self.parts.len() <= MOST_SAMPLED_BLOCKS).then(|| strides.collect())
    }

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn sample(&self, strides: &[Stride], state: &[Pair], samples: &mut [SampleDerivatives]) {
        // Not by an iterator's own loop, which is compiled for other registers.
        let parts = self.parts.iter().zip(strides).zip(state);
        for (j, (sample, ((part, stride), &z))) in samples.iter_mut().zip(parts).enumerate() {
            let [input, ..] = self.drive.inputs(j, D::read(&[]));
            let block = (&part.matrix, input, part.scale);
            *sample = SampleDerivatives::of(block, stride, z);
        }
    }

    #[inline]
    fn advance(&self, propagator: &Self::Propagator, state: &mut [Pair]) {
        let (blocks, forcing) = state.split_at_mut(self.parts.len());
        let u = D::read(forcing);
        for (z, (matrix, reply)) in blocks.iter_mut().zip(&propagator.parts) {
            *z = plus(times(matrix, *z), D::added(reply, u));
        }
        self.drive.carry(&propagator.turn, forcing);
    }
}

impl<D: Drive> FlowRows for BlockFlow<D> {
    #[inline]
    fn derivatives(&self, state: &[Pair], derivatives: &mut Vec<Derivatives>) {
        let (blocks, forcing) = state.split_at(self.parts.len());
        let u = D::read(forcing);
        derivatives.clear();
        derivatives.extend(
            blocks
                .iter()
                .zip(&self.parts)
                .enumerate()
                .map(|(j, (&z, part))| {
                    let a = &part.matrix;
                    let [f0, f1, f2] = self.drive.inputs(j, u);
                    let d1 = plus(times(a, z), f0);
                    let d2 = plus(times(a, d1), f1);
                    let d3 = plus(times(a, d2), f2);
                    let norm = longer_than(part.scale * d3[0], d3[1]);
                    Derivatives {
                        z,
                        d1,
                        d2,
                        d3,
                        norm,
                    }
                }),
        );
        derivatives.extend(self.drive.turning(u));
    }

    fn gap_row(&self, quantity: &Quantity) -> GapRow {
        let Quantity {
            constant,
            size: known_size,
            row,
            ..
        } = quantity;
        let (mut cells, mut forced, mut forced_growth) = (Vec::with_capacity(row.len()), 0.0, 0.0);
        let (mut rest, mut rest_size) = (*constant, *known_size);
        let mut decaying = Vec::new();
        let mut signal_weights = vec![0.0; self.drive.n_signals()];
        for (j, (r, part)) in row.iter().zip(&self.parts).enumerate() {
            let a = &part.matrix;
            // row A, and its dual norm: |row A z| <= weight |z|
            let image = [
                r[0] * a[0][0] + r[1] * a[1][0],
                r[0] * a[0][1] + r[1] * a[1][1],
            ];
            let dual = |r: Pair| (r[0] * r[0] / part.weight + r[1] * r[1]).sqrt();
            // What decays without turning is bounded part by part: behind a stiff damper the faster one is gone soon.
            let shares = part.block.parts().map(|parts| parts.fourth_derivatives(*r));
            let weight = if let Some(shares) = shares {
                decaying.push((j, shares));
                0.0
            } else {
                dual(image) * part.growth
            };
            let mut is_bounded = part.is_bounded;
            for (w, f) in self.drive.forces(j) {
                let along = |r: Pair| (f[0] * r[0] + f[1] * r[1]).norm();
                let size = (f[1].norm_sqr() + part.weight * f[0].norm_sqr()).sqrt();
                let grown = match shares {
                    Some([slow, fast]) => along(slow) + along(fast),
                    None => weight * size,
                };
                forced += along(*r) * w.powi(3);
                forced_growth += grown * w.powi(3);
                is_bounded &= size == 0.0;
            }
            for (d, signal_weight) in self.drive.signals(j).zip(&mut signal_weights) {
                let along = |r: Pair| (d[0] * r[0] + d[1] * r[1]).abs();
                let size = (d[1] * d[1] + part.weight * d[0] * d[0]).sqrt();
                let grown = match shares {
                    Some([slow, fast]) => along(slow) + along(fast),
                    None => weight * size,
                };
                *signal_weight += along(*r) + grown * self.longest_in_piece;
                is_bounded &= size == 0.0;
            }
            let terms = [r[0] * part.equilibrium[0], r[1] * part.equilibrium[1]];
            rest -= terms[0] + terms[1];
            rest_size += terms[0].abs() + terms[1].abs();
            let reach = if is_bounded || *r == [0.0, 0.0] {
                dual(*r)
            } else {
                f64::INFINITY
            };
            cells.push((*r, weight, reach));
        }
        for stored in self.drive.rows(quantity, &signal_weights) {
            cells.push((stored.row, stored.weight, stored.reach));
            forced += stored.forced;
        }
        GapRow::new(
            cells.into_iter(),
            (*constant, *known_size + quantity.amplitude()),
            (rest, rest_size),
            (forced, forced_growth),
        )
        .with_decaying(decaying)
    }

    fn velocity_row(&self, row: &[Pair]) -> Vec<Pair> {
        row.to_vec()
    }

    fn norms(&self, state: &[Pair], norms: &mut Vec<f64>) {
        norms.clear();
        let norm = |(z, part): (&Pair, &FlowBlock)| {
            let [x, y] = [0, 1].map(|c| z[c] - part.equilibrium[c]);
            (y * y + part.weight * x * x).sqrt()
        };
        norms.extend(state.iter().zip(&self.parts).map(norm));
        // The phasor of a harmonic turns on the unit circle; nothing is known of a signal.
        norms.extend(state[self.parts.len()..].iter().map(|_| 1.0));
    }
}

impl<D: Drive> FlowRates for BlockFlow<D> {
    fn longest_step(&self) -> f64 {
        self.longest_step
    }

    fn holds_for_ever(&self) -> bool {
        self.holds_for_ever
    }

    fn fastest_rate(&self) -> f64 {
        self.fastest_rate
    }

    fn fastest_growth(&self) -> f64 {
        self.fastest_growth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::drive::{HarmonicDrive, Loaded, Undriven};
    use crate::flow::linear::contract;
    use crate::flow::many_drive::{ManyDrive, SignalInput};
    use crate::model::Signal;
    use nalgebra::DMatrix;

    #[test]
    fn block_flows_keep_the_contract() {
        let blocks = [
            Block::Oscillator { w2: 2.0, eta: 0.1 },
            Block::Oscillator { w2: 30.0, eta: 9.0 },
            Block::Oscillator { w2: 0.0, eta: 0.0 },
            Block::Oscillator { w2: 9.0, eta: 3.0 },
            Block::Oscillator { w2: -0.5, eta: 0.1 },
            Block::Oscillator { w2: 0.0, eta: 0.4 },
            Block::Oscillator { w2: 5.0, eta: 7.0 },
        ];
        let force =
            [0.7, -0.3, 0.1, 0.9, 0.2, -0.1, 0.6].map(|f| [0.0.into(), Complex::new(f, 0.4 * f)]);
        let load = vec![[0.0, 0.2]; 7];
        let drive = HarmonicDrive {
            frequency: 1.5,
            force: force.to_vec(),
        };
        contract::check(&BlockFlow::new(&blocks, Undriven), 7, 0.0);
        // Each by itself: others would hide a bound that is too low.
        for block in blocks {
            contract::check(&BlockFlow::new(&[block], Undriven), 1, 0.0);
        }
        contract::check(&BlockFlow::new(&blocks, drive.clone()), 7, 1.5);
        let loaded = Loaded {
            load: load.clone(),
            drive: Undriven,
        };
        contract::check(&BlockFlow::new(&blocks, loaded), 7, 0.0);
        contract::check(&BlockFlow::new(&blocks, Loaded { load, drive }), 7, 1.5);
        let pairs = [
            Block::Spiral {
                sigma: -0.1,
                omega: 2.0,
            },
            Block::Decays {
                roots: [-0.2, -3.0],
            },
        ];
        let drive = HarmonicDrive {
            frequency: 0.8,
            force: vec![[Complex::new(0.3, 0.1), Complex::new(-0.2, 0.4)]; 2],
        };
        let load = vec![[0.1, 0.2]; 2];
        contract::check(&BlockFlow::new(&pairs, Loaded { load, drive }), 2, 0.8);
    }

    /// Where nothing moves but by the signal, its rates bound what gaps and speeds do to the end of its piece.
    fn check_from_rest(flow: &BlockFlow<ManyDrive>, end: f64) {
        let longest = (if flow.holds_for_ever() {
            end
        } else {
            flow.longest_step()
        })
        .min(end);
        let (mut start, mut derivatives) = (Vec::new(), Vec::new());
        let at = Moment::new(-1.0, 0.0, 0.0);
        flow.state_from_modal(&vec![[0.0, 0.0]].into(), at, &mut start);
        for row in [[1.0, 0.0], [0.0, 1.0]] {
            let row = flow.gap_row(&Quantity::gap(0.0, &[row]));
            flow.derivatives(&start, &mut derivatives);
            let model = row.model(&derivatives);
            for s in (1..=50).map(|k| 0.02 * longest * f64::from(k)) {
                let (mut propagator, mut state) = (BlockPropagator::default(), start.clone());
                flow.prepare(s, &mut propagator);
                flow.advance(&propagator, &mut state);
                flow.derivatives(&state, &mut derivatives);
                let there = row.model(&derivatives);
                let miss = (there.c[0] - model.value(s)).abs();
                let bound = model.remainder(s) + 1e-13 * there.size;
                assert!(miss <= bound, "{s} of {longest}: {miss:e} {bound:e}");
            }
        }
    }

    #[test]
    fn bounds_hold_along_a_signal_to_the_end_of_its_piece() {
        let blocks = [
            Block::Oscillator { w2: 4.0, eta: 0.1 },
            Block::Oscillator { w2: 1.0, eta: 0.0 },
            Block::Oscillator { w2: 0.0, eta: 0.0 },
            Block::Oscillator { w2: 5.0, eta: 7.0 },
        ];
        // Powers of the time over the piece, as long as the longest step that is checked, or a tenth of the shortest.
        for (end, degree) in [(300.0, 3), (300.0, 5), (300.0, 8), (40.0, 4)] {
            let coefficient =
                |k: usize| (1.3 - 0.7 * k as f64) / f64::powf(end, (degree - k) as f64);
            let flow = |block: Block, coefficients: &DMatrix<f64>| {
                let signal = Signal::pieces(&[-1.0, end], coefficients).expect("valid");
                let directions = vec![[0.0, 0.8]];
                let drive = ManyDrive {
                    signals: vec![SignalInput { signal, directions }],
                    ..ManyDrive::default()
                };
                BlockFlow::new(&[block], drive)
            };
            let mixed = DMatrix::from_fn(degree + 1, 1, |k, _| coefficient(k));
            // Of which a body at rest notices nothing at first.
            let power = DMatrix::from_fn(
                degree + 1,
                1,
                |k, _| if k == 0 { coefficient(0) } else { 0.0 },
            );
            for block in blocks {
                let along = flow(block, &mixed);
                if end > 200.0 * along.longest_step() || !along.holds_for_ever() {
                    contract::check(&along, 1, 0.0);
                }
                check_from_rest(&flow(block, &power), end);
            }
        }
    }

    #[test]
    fn the_speed_of_a_body_pushed_by_a_signal_is_bounded_by_the_signal() {
        // `v' = 2 t^3`, whose fourth derivative of v is 12.
        let coefficients = DMatrix::from_column_slice(4, 1, &[2.0, 0.0, 0.0, 0.0]);
        let signal = Signal::pieces(&[0.0, 10.0], &coefficients).expect("valid");
        let drive = ManyDrive {
            signals: vec![SignalInput {
                signal,
                directions: vec![[0.0, 1.0]],
            }],
            ..ManyDrive::default()
        };
        let flow = BlockFlow::new(&[Block::Oscillator { w2: 0.0, eta: 0.0 }], drive);
        let speed = flow.gap_row(&Quantity::gap(0.0, &[[0.0, 1.0]]));
        let (mut state, mut derivatives) = (Vec::new(), Vec::new());
        flow.state_from_modal(
            &vec![[0.0, 0.0]].into(),
            Moment::new(0.0, 0.0, 0.0),
            &mut state,
        );
        flow.derivatives(&state, &mut derivatives);
        let bound = 24.0 * speed.model(&derivatives).quartic;
        assert!((12.0..12.1).contains(&bound), "{bound}");
    }

    #[test]
    fn what_decays_slowly_behind_a_stiff_damper_is_bounded_as_it_is() {
        // Roots -50 and -2e6; of the slow motion e^{-50 t} the fourth derivative is 50^4 = 6.25e6, of its speed 50 times that.
        let (slow, fast) = (-50.0, -2e6);
        let block = Block::Oscillator {
            w2: slow * fast,
            eta: -0.5 * (slow + fast),
        };
        let flow = BlockFlow::new(&[block], Undriven);
        let mut derivatives = Vec::new();
        flow.derivatives(&[[1.0, slow]], &mut derivatives);
        let quartic = |row: Pair| {
            let gap = flow.gap_row(&Quantity::gap(0.0, &[row]));
            24.0 * gap.model(&derivatives).quartic
        };
        let (place, speed) = (quartic([1.0, 0.0]), quartic([0.0, 1.0]));
        assert!((6.24e6..6.3e6).contains(&place), "{place:e}");
        // The fast part, which rounding leaves, moves speeds.
        assert!((3.12e8..1e12).contains(&speed), "{speed:e}");
    }
}

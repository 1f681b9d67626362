//! A forced linear flow as a free one (theory 4 and 8): where no block is near resonance, the motion is its steady response
//! plus a free motion, and the steady response is one more block for each harmonic, a rotation at its frequency. A search along
//! such a flow needs no response from rest, and the remainder of the forcing's part of a gap is its exact amplitude.

use crate::flow::block::{BlockFlow, BlockPropagator};
use crate::flow::drive::{Undriven, real_part};
use crate::flow::gap_row::{Derivatives, GapRow, Quantity};
use crate::flow::linear::{FlowRates, FlowRows, LinearFlow};
use crate::flow::samples::{SampleDerivatives, Stride};
use crate::linalg::elementary::sin_cos;
use crate::linalg::plane::plus;
use crate::modal::{Block, ModalState, Pair, Response};
use crate::model::{Moment, Rotations};
use crate::tolerance::{NEAR_RESONANCE, RIGID};
use nalgebra::Complex;

/// The flow without its forcing, enlarged by the rotations that stand for it.
#[derive(Debug, Clone)]
pub(crate) struct SplitFlow {
    flow: BlockFlow<Undriven>,
    rotations: Rotations,
    /// The response to the first rotation.
    steady: Vec<Response>,
    /// The responses to the others.
    higher: Vec<Vec<Response>>,
    /// Where the load holds each block.
    equilibrium: Vec<Pair>,
}

impl SplitFlow {
    /// The split flow of blocks under a load and forces that turn; `None` where a block is near resonance, or soft beside the forcing
    /// and loaded: its equilibrium may lie far beyond what the motion reaches.
    pub fn new(
        blocks: &[Block],
        load: &[Pair],
        rotations: &Rotations,
        forces: &[Vec<Response>],
    ) -> Option<Self> {
        let frequencies = || rotations.frequencies();
        let slowest = frequencies().fold(f64::INFINITY, f64::min);
        let moduli = |block: &Block| block.roots().map(Complex::norm);
        let fastest = (blocks.iter().flat_map(moduli)).fold(0.0, f64::max);
        let refuses = |(block, &load): (&Block, &Pair)| {
            let is_rigid = moduli(block).iter().any(|&rate| rate <= RIGID * fastest);
            let is_resonant = frequencies().any(|w| is_near_resonance(*block, w));
            is_rigid || is_resonant || (load != [0.0, 0.0] && is_soft(*block, slowest))
        };
        if blocks.iter().zip(load).any(refuses) {
            return None;
        }
        let mut responses = frequencies().zip(forces).map(|(w, force)| {
            let each = blocks.iter().zip(force);
            each.map(|(block, &force)| block.steady(w, force)).collect()
        });
        let equilibrium = blocks.iter().zip(load);
        let equilibrium = equilibrium.map(|(block, &load)| block.equilibrium(load));
        let rotation = |omega: f64| Block::Spiral { sigma: 0.0, omega };
        let turning = frequencies().map(rotation);
        let all: Vec<Block> = blocks.iter().copied().chain(turning).collect();
        Some(Self {
            flow: BlockFlow::new(&all, Undriven),
            rotations: rotations.clone(),
            steady: responses.next()?,
            higher: responses.collect(),
            equilibrium: equilibrium.collect(),
        })
    }

    /// Steady response and equilibrium of block j when the rotations are at `turned`.
    #[inline]
    fn rest(&self, j: usize, turned: &[Pair]) -> Pair {
        let rest = plus(self.equilibrium[j], real_part(self.steady[j], turned[0]));
        if self.higher.is_empty() {
            return rest;
        }
        let higher = self.higher.iter().zip(&turned[1..]);
        higher.fold(rest, |rest, (steady, &u)| {
            plus(rest, real_part(steady[j], u))
        })
    }

    /// Sets the rotations, which follow the blocks in a state, to their phasors at a moment.
    #[inline]
    fn turn(&self, state: &mut [Pair], at: Moment) {
        let turned = &mut state[self.equilibrium.len()..];
        if self.higher.is_empty() && self.rotations.tones.is_empty() {
            let (sin, cos) = sin_cos(at.angle);
            turned[0] = [cos, sin];
            return;
        }
        for (place, u) in turned.iter_mut().zip(self.rotations.phasors(at)) {
            *place = [u.re, u.im];
        }
    }

    /// The responses by harmonics.
    fn harmonics(&self) -> impl Iterator<Item = &Vec<Response>> {
        std::iter::once(&self.steady).chain(&self.higher)
    }

    /// A row of the whole motion as one of the enlarged state.
    fn enlarged(&self, row: &[Pair]) -> Vec<Pair> {
        let seen = |steady: &Vec<Response>| {
            let each = row
                .iter()
                .zip(steady)
                .map(|(r, y)| y[0] * r[0] + y[1] * r[1]);
            let seen: Complex<f64> = each.sum();
            [seen.re, -seen.im]
        };
        row.iter()
            .copied()
            .chain(self.harmonics().map(seen))
            .collect()
    }
}

impl LinearFlow for SplitFlow {
    type Propagator = BlockPropagator<Undriven>;

    fn state_from_modal(&self, modal_state: &ModalState, at: Moment, state: &mut Vec<Pair>) {
        let n = modal_state.len();
        state.clear();
        state.reserve(n + 1 + self.higher.len());
        state.extend_from_slice(modal_state);
        state.resize(n + 1 + self.higher.len(), [0.0, 0.0]);
        self.turn(state, at);
        let (free, turned) = state.split_at_mut(n);
        for (j, z) in free.iter_mut().enumerate() {
            let rest = self.rest(j, turned);
            *z = [z[0] - rest[0], z[1] - rest[1]];
        }
    }

    fn modal_from_state(&self, state: &[Pair], modal_state: &mut ModalState) {
        modal_state.clear();
        let (free, turned) = state.split_at(self.equilibrium.len());
        modal_state.extend(free.iter().enumerate().map(|(j, z)| {
            let rest = self.rest(j, turned);
            [z[0] + rest[0], z[1] + rest[1]]
        }));
    }

    fn set_moment(&self, state: &mut [Pair], at: Moment) {
        self.turn(state, at);
    }

    fn prepare(&self, t: f64, propagator: &mut Self::Propagator) {
        self.flow.prepare(t, propagator);
    }

    fn strides(&self, propagator: &Self::Propagator) -> Option<Vec<Stride>> {
        self.flow.strides(propagator)
    }

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn sample(&self, strides: &[Stride], state: &[Pair], samples: &mut [SampleDerivatives]) {
        self.flow.sample(strides, state, samples);
    }

    #[inline]
    fn advance(&self, propagator: &Self::Propagator, state: &mut [Pair]) {
        self.flow.advance(propagator, state);
    }
}

impl FlowRows for SplitFlow {
    #[inline]
    fn derivatives(&self, state: &[Pair], derivatives: &mut Vec<Derivatives>) {
        self.flow.derivatives(state, derivatives);
    }

    fn gap_row(&self, quantity: &Quantity) -> GapRow {
        let Quantity {
            constant,
            size,
            row,
            ..
        } = quantity;
        let rest: f64 = row
            .iter()
            .zip(&self.equilibrium)
            .map(|(r, e)| r[0] * e[0] + r[1] * e[1])
            .sum();
        let mut enlarged = self.enlarged(row);
        for (turning, f) in enlarged[row.len()..].iter_mut().zip(quantity.harmonics()) {
            *turning = [turning[0] + f.re, turning[1] - f.im];
        }
        // Under fast forcing the parts of the modes cancel: their sum has the rounding of its largest terms.
        let seen = |(steady, f): (&Vec<Response>, Complex<f64>)| {
            [|z: Complex<f64>| z.re, |z: Complex<f64>| z.im].map(|part| {
                let terms = |(r, y): (&Pair, &Response)| {
                    (r[0] * part(y[0])).abs() + (r[1] * part(y[1])).abs()
                };
                part(f).abs() + row.iter().zip(steady).map(terms).sum::<f64>()
            })
        };
        let turning = self.harmonics().zip(quantity.harmonics()).map(seen);
        let known = Quantity {
            constant: constant - rest,
            size: size + rest.abs(),
            row: enlarged,
            ..Quantity::default()
        };
        (self.flow.gap_row(&known)).with_turning(turning.collect())
    }

    /// At an equilibrium nothing moves, so that the load leaves no trace here.
    fn velocity_row(&self, row: &[Pair]) -> Vec<Pair> {
        self.enlarged(row)
    }

    fn norms(&self, state: &[Pair], norms: &mut Vec<f64>) {
        self.flow.norms(state, norms);
    }
}

impl FlowRates for SplitFlow {
    fn longest_step(&self) -> f64 {
        self.flow.longest_step()
    }

    fn holds_for_ever(&self) -> bool {
        self.flow.holds_for_ever()
    }

    fn fastest_rate(&self) -> f64 {
        self.flow.fastest_rate()
    }

    fn fastest_growth(&self) -> f64 {
        self.flow.fastest_growth()
    }
}

/// Trace and determinant of a block.
fn invariants(block: Block) -> (f64, f64) {
    let [[a, b], [c, d]] = block.matrix();
    (a + d, a * d - b * c)
}

fn is_soft(block: Block, w: f64) -> bool {
    invariants(block).1.abs() < NEAR_RESONANCE * w * w
}

fn is_near_resonance(block: Block, w: f64) -> bool {
    let (trace, product) = invariants(block);
    let at_forcing = Complex::new(product - w * w, -w * trace);
    let (distance, scale) = (at_forcing.norm(), w * w + product.abs());
    distance.is_nan() || distance <= NEAR_RESONANCE * scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::DenseFlow;
    use crate::flow::drive::{HarmonicDrive, Loaded};
    use crate::flow::linear::contract;
    use crate::flow::many_drive::ManyDrive;
    use crate::flow::propagate;
    use nalgebra::{DMatrix, dmatrix};

    const BLOCKS: [Block; 3] = [
        Block::Oscillator { w2: 2.0, eta: 0.1 },
        Block::Oscillator { w2: 30.0, eta: 9.0 },
        Block::Spiral {
            sigma: -0.1,
            omega: 2.5,
        },
    ];

    #[test]
    fn a_split_flow_keeps_the_contract_and_is_the_flow_it_splits() {
        let force = vec![
            [0.0.into(), Complex::new(0.7, 0.2)],
            [0.0.into(), Complex::new(-0.3, 0.1)],
            [Complex::new(0.2, 0.1), Complex::new(-0.2, 0.4)],
        ];
        let load = [[0.0, 0.3], [0.0, -1.0], [0.0, 0.0]];
        let forces = [force.clone()];
        let rotations = Rotations::harmonics(0.8, 1);
        let split = SplitFlow::new(&BLOCKS, &load, &rotations, &forces);
        let split = split.expect("away from resonance");
        contract::check(&split, 3, 0.8);
        let drive = HarmonicDrive {
            frequency: 0.8,
            force,
        };
        let load = load.to_vec();
        let unsplit = BlockFlow::new(&BLOCKS, Loaded { load, drive });
        let start = ModalState::from(vec![[0.3, -0.2], [0.1, 0.7], [0.0, 0.2]]);
        for t in [0.1, 1.0, 7.0] {
            let (mut a, mut b) = (start.clone(), start.clone());
            propagate(&split, Moment::of_angle(0.4), t, &mut a);
            propagate(&unsplit, Moment::of_angle(0.4), t, &mut b);
            for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                assert!((a - b).abs() < 1e-14, "{a} {b}");
            }
        }
    }

    #[test]
    fn several_harmonics_keep_the_contract_and_are_the_same_split_driven_and_dense() {
        let harmonic = |k: f64| -> Vec<Response> {
            vec![
                [0.0.into(), Complex::new(0.7 / k, 0.2)],
                [0.0.into(), Complex::new(-0.3, 0.1 * k)],
                [Complex::new(0.2, 0.1 / k), Complex::new(-0.2, 0.4)],
            ]
        };
        let forces: Vec<_> = [1.0, 2.0, 3.0].map(harmonic).to_vec();
        let load = vec![[0.0, 0.3], [0.0, -1.0], [0.0, 0.0]];
        let rotations = Rotations::harmonics(0.6, 3);
        let split = SplitFlow::new(&BLOCKS, &load, &rotations, &forces);
        let split = split.expect("away from resonance");
        let mut matrix = DMatrix::zeros(6, 6);
        for (j, block) in BLOCKS.iter().enumerate() {
            let [[a, b], [c, d]] = block.matrix();
            let view = &mut matrix.view_mut((2 * j, 2 * j), (2, 2));
            view.copy_from(&dmatrix![a, b; c, d]);
        }
        let drive = ManyDrive {
            rotations,
            forces,
            signals: Vec::new(),
        };
        let dense = DenseFlow::new(matrix, &load, drive.clone());
        let driven = BlockFlow::new(&BLOCKS, Loaded { load, drive });
        contract::check(&split, 3, 0.6);
        contract::check(&driven, 3, 0.6);
        contract::check(&dense, 3, 0.6);
        let start = ModalState::from(vec![[0.3, -0.2], [0.1, 0.7], [0.0, 0.2]]);
        for t in [0.1, 1.0, 7.0] {
            let [mut a, mut b, mut c] = [(); 3].map(|()| start.clone());
            let at = Moment::of_angle(0.4);
            propagate(&split, at, t, &mut a);
            propagate(&driven, at, t, &mut b);
            propagate(&dense, at, t, &mut c);
            for (a, (b, c)) in a
                .iter()
                .flatten()
                .zip(b.iter().flatten().zip(c.iter().flatten()))
            {
                assert!(
                    (a - b).abs() < 1e-14 && (a - c).abs() < 1e-13,
                    "{a} {b} {c}"
                );
            }
        }
    }

    #[test]
    fn a_stop_beyond_reach_of_the_motion_about_a_loaded_equilibrium_is_known_to_be() {
        let block = Block::Oscillator { w2: 4.0, eta: 0.1 };
        let force = [vec![[0.0.into(), Complex::new(0.3, 0.0)]]];
        // At rest under the load at -50; the motion about it reaches 0.4.
        let rotations = Rotations::harmonics(0.8, 1);
        let split = SplitFlow::new(&[block], &[[0.0, -200.0]], &rotations, &force);
        let split = split.expect("no resonance");
        let (mut state, mut norms) = (Vec::new(), Vec::new());
        let at = Moment::of_angle(0.0);
        split.state_from_modal(&vec![[-49.8, 0.1]].into(), at, &mut state);
        split.norms(&state, &mut norms);
        let least = |clearance: f64| {
            split
                .gap_row(&Quantity::gap(clearance, &[[1.0, 0.0]]))
                .least(&norms)
                .0
        };
        assert!(
            least(-49.0) > 0.0 && least(-49.9) < 0.0,
            "{} {}",
            least(-49.0),
            least(-49.9)
        );
    }

    #[test]
    fn resonance_is_not_split() {
        let spring = |eta: f64, w2: f64| Block::Oscillator { w2, eta };
        assert!(is_near_resonance(spring(0.001, 4.0), 2.0));
        assert!(!is_near_resonance(spring(0.1, 4.0), 2.0));
        let rigid = |eta: f64, w2: f64| {
            SplitFlow::new(
                &[spring(eta, w2)],
                &[[0.0; 2]],
                &Rotations::harmonics(2.0, 1),
                &[vec![[0.0.into(); 2]]],
            )
            .is_none()
        };
        assert!(rigid(0.0, 0.0) && rigid(0.5, 0.0) && rigid(0.5, 1e-12) && !rigid(0.1, 4.0));
        assert!(is_near_resonance(
            Block::Spiral {
                sigma: 0.0,
                omega: 2.0
            },
            2.001
        ));
    }
}

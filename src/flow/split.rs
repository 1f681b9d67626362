//! A forced linear flow as a free one (theory 4 and 8): where no block is near resonance, the motion is its steady response
//! plus a free motion, and the steady response is one more block, a rotation at the forcing frequency. What walks along
//! such a flow needs no response from rest, and the remainder of the forcing's part of a gap is its exact amplitude.

use crate::flow::ModalScene;
use crate::flow::{BlockFlow, GapRow, LinearFlow, Undriven};
use crate::modal::{Block, Form, Pair, Response};
use nalgebra::Complex;

/// A resonance is near where `|(i w - l_1)(i w - l_2)|` is below this times `w^2 + |l_1 l_2|`: the steady response and the
/// free motion would cancel in more than two digits.
const NEAR_RESONANCE: f64 = 1e-2;

/// The flow of a scene without its forcing, enlarged by the rotation that stands for it.
#[derive(Debug, Clone)]
pub(crate) struct SplitFlow {
    flow: BlockFlow<Undriven>,
    steady: Vec<Response>,
    equilibrium: Vec<Pair>,
}

impl SplitFlow {
    /// The split flow, `None` where a block is near resonance, has no equilibrium, or the form has no blocks.
    pub fn new(scene: &ModalScene) -> Option<Self> {
        let Form::Blocks(blocks) = &scene.form.form else {
            return None;
        };
        let w = scene.frequency;
        let mut steady = Vec::with_capacity(blocks.len());
        let mut equilibrium = Vec::with_capacity(blocks.len());
        for (j, &block) in blocks.iter().enumerate() {
            if is_near_resonance(block, w) {
                return None;
            }
            let rest = block.equilibrium(scene.load[j]);
            if !(rest[0].is_finite() && rest[1].is_finite()) {
                return None;
            }
            steady.push(block.steady(w, scene.force[j]));
            equilibrium.push(rest);
        }
        let rotation = Block::Spiral {
            sigma: 0.0,
            omega: w,
        };
        let all: Vec<Block> = blocks.iter().copied().chain([rotation]).collect();
        let load = vec![[0.0, 0.0]; all.len()];
        Some(Self {
            flow: BlockFlow::new(all, load, Undriven),
            steady,
            equilibrium,
        })
    }

    /// The free flow of the enlarged state.
    pub fn flow(&self) -> &BlockFlow<Undriven> {
        &self.flow
    }

    /// The gap `clearance - row.z` of the whole motion as one of the enlarged state.
    pub fn gap_row(&self, row: &[Pair], clearance: f64) -> GapRow {
        let (mut seen, mut rest) = (Complex::new(0.0, 0.0), 0.0);
        for ((r, y), e) in row.iter().zip(&self.steady).zip(&self.equilibrium) {
            seen += y[0] * r[0] + y[1] * r[1];
            rest += e[0] * r[0] + e[1] * r[1];
        }
        let mut enlarged = Vec::with_capacity(row.len() + 1);
        enlarged.extend_from_slice(row);
        enlarged.push([seen.re, -seen.im]);
        self.flow.gap_row(enlarged, clearance - rest)
    }

    /// The enlarged state of a whole one at a forcing angle.
    pub fn enlarge(&self, whole: &[Pair], angle: f64, enlarged: &mut Vec<Pair>) {
        let (sin, cos) = angle.sin_cos();
        enlarged.clear();
        enlarged.extend(
            whole
                .iter()
                .zip(&self.steady)
                .zip(&self.equilibrium)
                .map(|((z, y), e)| [0, 1].map(|c| z[c] - e[c] - (y[c].re * cos - y[c].im * sin))),
        );
        enlarged.push([cos, sin]);
    }
}

fn is_near_resonance(block: Block, w: f64) -> bool {
    let [[a, b], [c, d]] = block.matrix();
    let product = a * d - b * c;
    let at_forcing = Complex::new(product - w * w, -w * (a + d));
    let (distance, scale) = (at_forcing.norm(), w * w + product.abs());
    distance.is_nan() || distance <= NEAR_RESONANCE * scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::jet::Jet;
    use crate::model::{Kind, PaperOptions, paper_scene};

    #[test]
    fn a_split_flow_is_the_flow_it_splits() {
        let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
        let modal = ModalScene::new(&scene, "the test").expect("linear");
        let crate::flow::SceneFlow::Forced(whole) = modal.flow() else {
            panic!("blocks, forced")
        };
        let split = SplitFlow::new(&modal).expect("away from resonance");
        let mut state = vec![[0.3, -0.2], [0.1, 0.7]];
        let mut enlarged = Vec::new();
        split.enlarge(&state, 0.4, &mut enlarged);
        let mut u = whole.phasor(0.4);
        let (mut p, mut q) = Default::default();
        whole.prepare(0.9, &mut p);
        split.flow().prepare(0.9, &mut q);
        for _ in 0..5 {
            whole.advance(&p, &mut state, &mut u);
            split.flow().advance(&q, &mut enlarged, &mut ());
            for stop in 0..2 {
                let row = &modal.position_rows[stop];
                let (mut a, mut b) = ([Jet::default()], [Jet::default()]);
                whole.jets(&state, u, &[whole.gap_row(row.clone(), 0.2)], &mut a);
                split
                    .flow()
                    .jets(&enlarged, (), &[split.gap_row(row, 0.2)], &mut b);
                for k in 0..4 {
                    assert!(
                        (a[0].c[k] - b[0].c[k]).abs() < 1e-13,
                        "{k}: {} {}",
                        a[0].c[k],
                        b[0].c[k]
                    );
                }
            }
        }
    }

    #[test]
    fn resonance_is_not_split() {
        assert!(is_near_resonance(
            Block::Oscillator {
                w2: 4.0,
                eta: 0.001
            },
            2.0
        ));
        assert!(!is_near_resonance(
            Block::Oscillator { w2: 4.0, eta: 0.1 },
            2.0
        ));
        assert!(!is_near_resonance(
            Block::Oscillator { w2: 0.0, eta: 0.0 },
            2.0
        ));
        assert!(is_near_resonance(
            Block::Spiral {
                sigma: 0.0,
                omega: 2.0
            },
            2.001
        ));
    }
}

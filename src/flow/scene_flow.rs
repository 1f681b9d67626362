//! Chooses the flow of a linear scene, of the least machinery that is exact for it: free, loaded, forced by one harmonic, by several or
//! by signals, split, dense.

use crate::flow::block::BlockFlow;
use crate::flow::dense::DenseFlow;
use crate::flow::drive::{HarmonicDrive, Loaded, Undriven};
use crate::flow::many_drive::ManyDrive;
use crate::flow::split::SplitFlow;
use crate::modal::{Block, Form, Pair};

/// The flow of a linear scene, of the least machinery that is exact for it.
#[derive(Debug, Clone)]
pub(crate) enum SceneFlow {
    Free(BlockFlow<Undriven>),
    Loaded(BlockFlow<Loaded<Undriven>>),
    Split(SplitFlow),
    Forced(BlockFlow<Loaded<HarmonicDrive>>),
    ForcedByMany(BlockFlow<Loaded<ManyDrive>>),
    Dense(DenseFlow),
}

/// The flow of a modal form under a load and what drives it: forces that turn are split off where no block is near resonance and there
/// is no signal.
pub(crate) fn modal_flow(form: &Form, load: Vec<Pair>, drive: ManyDrive) -> SceneFlow {
    match form {
        Form::Blocks(blocks) => block_flow(blocks, load, drive),
        Form::Dense(matrix) => SceneFlow::Dense(DenseFlow::new(matrix.clone(), &load, drive)),
    }
}

/// The same of blocks.
fn block_flow(blocks: &[Block], load: Vec<Pair>, mut drive: ManyDrive) -> SceneFlow {
    let rotations = &drive.rotations;
    if !drive.signals.is_empty() {
        return SceneFlow::ForcedByMany(BlockFlow::new(blocks, Loaded { load, drive }));
    }
    if !rotations.is_empty() {
        if let Some(split) = SplitFlow::new(blocks, &load, rotations, &drive.forces) {
            return SceneFlow::Split(split);
        }
        if rotations.n_harmonics != 1 || rotations.len() > 1 {
            return SceneFlow::ForcedByMany(BlockFlow::new(blocks, Loaded { load, drive }));
        }
        let (frequency, force) = (rotations.fundamental, drive.forces.swap_remove(0));
        let drive = HarmonicDrive { frequency, force };
        return SceneFlow::Forced(BlockFlow::new(blocks, Loaded { load, drive }));
    }
    let drive = Undriven;
    if load.iter().all(|load| *load == [0.0, 0.0]) {
        return SceneFlow::Free(BlockFlow::new(blocks, drive));
    }
    SceneFlow::Loaded(BlockFlow::new(blocks, Loaded { load, drive }))
}

/// Runs a block of code with the flow of a scene, whatever its type: the one `match` at the edge.
macro_rules! with_flow {
    ($scene_flow:expr, $flow:ident => $body:expr) => {
        match $scene_flow {
            $crate::flow::SceneFlow::Free($flow) => $body,
            $crate::flow::SceneFlow::Loaded($flow) => $body,
            $crate::flow::SceneFlow::Split($flow) => $body,
            $crate::flow::SceneFlow::Forced($flow) => $body,
            $crate::flow::SceneFlow::ForcedByMany($flow) => $body,
            $crate::flow::SceneFlow::Dense($flow) => $body,
        }
    };
}
pub(crate) use with_flow;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::propagate;
    use crate::model::{Moment, Rotations};
    use nalgebra::Complex;

    /// `y'' + k y = 1 + cos(w t)` from rest: the equilibrium lies at 1/k, far beyond what the motion reaches.
    #[test]
    fn a_load_on_a_soft_spring_keeps_its_digits_beside_a_force() {
        let (w, t) = (0.8, 20.0);
        for k in [1e-2, 1e-4, 1e-8, 1e-12] {
            let block = Block::Oscillator { w2: k, eta: 0.0 };
            let force = [[0.0.into(), Complex::new(1.0, 0.0)]];
            let drive = ManyDrive {
                rotations: Rotations::harmonics(w, 1),
                forces: vec![force.to_vec()],
                signals: Vec::new(),
            };
            let flow = block_flow(&[block], vec![[0.0, 1.0]], drive);
            let mut z = vec![[0.0, 0.0]].into();
            with_flow!(&flow, flow => propagate(flow, Moment::of_angle(0.0), t, &mut z));
            // 1 - cos(x) = 2 sin^2(x/2), and cos(w t) - cos(r t) as a product of sines
            let r = f64::sqrt(k);
            let loaded = 2.0 * (0.5 * r * t).sin().powi(2) / k;
            let forced = 2.0 * (0.5 * (r + w) * t).sin() * (0.5 * (r - w) * t).sin() / (k - w * w);
            let error = (z[0][0] / (loaded + forced) - 1.0).abs();
            assert!(error < 1e-14, "{k:e}: {error:e}");
        }
    }
}

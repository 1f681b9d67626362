//! A linear scene in modal pairs: flow, forcing and stops as the periodic solve and the simulation use them.

use crate::error::Result;
use crate::flow::derivative::Equations;
use crate::flow::{BlockFlow, DenseFlow, HarmonicDrive, Loaded, SplitFlow, StuckMotion, Undriven};
use crate::modal::{Block, Form, ModalForm, Pair, Response};
use crate::model::{ContactGeometry, LinearSystem, Scene};
use nalgebra::{Complex, DVector};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Motions with stops held that are kept with a scene.
const MOST_KEPT: usize = 32;

/// The machinery of a linear scene.
#[derive(Debug, Clone)]
pub(crate) struct ModalScene {
    pub system: Arc<LinearSystem>,
    pub form: Arc<ModalForm>,
    pub geometry: Arc<ContactGeometry>,
    /// `n.q = position_rows[i].z`
    pub position_rows: Arc<Vec<Vec<Pair>>>,
    /// `n.v = velocity_rows[i].z`
    pub velocity_rows: Arc<Vec<Vec<Pair>>>,
    /// An impulse p on stop i moves the state by `-jumps[i] p`.
    pub jumps: Arc<Vec<Vec<Pair>>>,
    pub load: Vec<Pair>,
    /// The force amplitude, phase left out but in a timed scene.
    pub force: Vec<Response>,
    /// The same on the coordinates.
    pub amplitude: DVector<Complex<f64>>,
    /// Forcing frequency, zero without forcing.
    pub frequency: f64,
}

/// The flow of a linear scene, of the least machinery that is exact for it.
#[derive(Debug, Clone)]
pub(crate) enum SceneFlow {
    Free(BlockFlow<Undriven>),
    Loaded(BlockFlow<Loaded<Undriven>>),
    Split(SplitFlow),
    Forced(BlockFlow<Loaded<HarmonicDrive>>),
    Dense(DenseFlow),
}

/// A linear scene as it runs by the clock, and its flow: the forcing's phase is in its amplitude. A slow force that begins from zero has
/// all its digits there, and few in the sum of phase and angle.
#[derive(Debug)]
pub(crate) struct TimedScene {
    pub modal: Arc<ModalScene>,
    pub flow: Arc<SceneFlow>,
    /// Motions with stops held, as runs have needed them.
    held: Mutex<Vec<Arc<StuckMotion>>>,
    equations: OnceLock<Equations>,
}

impl TimedScene {
    /// Made of a scene once; `purpose` says in an error what needs it linear.
    pub fn of(scene: &Scene, purpose: &str) -> Result<Arc<Self>> {
        scene.derived().or_made(|| {
            let modal = ModalScene::turned(scene, purpose, scene.forcing().phase())?;
            Ok(Self {
                flow: Arc::new(modal.flow()),
                modal: Arc::new(modal),
                held: Mutex::default(),
                equations: OnceLock::new(),
            })
        })
    }

    /// The equations of its motion where nothing is held.
    pub fn equations(&self) -> &Equations {
        self.equations
            .get_or_init(|| Equations::new(&self.modal.system, None))
    }

    /// The motion while some stops are held.
    pub fn holding(&self, stops: &[usize]) -> Result<Arc<StuckMotion>> {
        let kept = || self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept().iter().find(|motion| motion.stops == stops) {
            return Ok(Arc::clone(known));
        }
        let made = Arc::new(StuckMotion::new(&self.modal, stops)?);
        let mut kept = kept();
        if kept.len() < MOST_KEPT {
            kept.push(Arc::clone(&made));
        }
        Ok(made)
    }
}

impl ModalScene {
    /// The modal form of a linear scene; `purpose` says in an error what needs it linear.
    pub fn new(scene: &Scene, purpose: &str) -> Result<Self> {
        Self::turned(scene, purpose, 0.0)
    }

    fn turned(scene: &Scene, purpose: &str, phase: f64) -> Result<Self> {
        let system = scene.linear_system(purpose)?;
        let form = ModalForm::new(system)?;
        let geometry = ContactGeometry::new(system, scene);
        let each = |of: &dyn Fn(usize) -> Vec<Pair>| {
            Arc::new((0..geometry.len()).map(of).collect::<Vec<_>>())
        };
        let position_rows = each(&|i| form.position_row(&geometry.normals.column(i).into_owned()));
        let velocity_rows = each(&|i| form.velocity_row(&geometry.normals.column(i).into_owned()));
        let jumps = each(&|i| form.velocity_jump(&geometry.reactions.column(i).into_owned()));
        let load = form.load(system, system.load());
        let turn = Complex::cis(phase);
        let amplitude = scene.forcing().force_on(system).map(|f| f * turn);
        let force = form.force(system, &amplitude);
        let frequency = scene.forcing().frequency().unwrap_or(0.0);
        Ok(Self {
            system: Arc::clone(system),
            form: Arc::new(form),
            geometry: Arc::new(geometry),
            position_rows,
            velocity_rows,
            jumps,
            load,
            force,
            amplitude,
            frequency,
        })
    }

    /// Number of stops.
    pub fn n_stops(&self) -> usize {
        self.jumps.len()
    }

    /// The rate of change of a state at the forcing angle whose phasor is u.
    pub fn rate(&self, state: &[Pair], u: Complex<f64>, rate: &mut [Pair]) {
        let input = |j: usize, c: usize| (self.force[j][c] * u).re + self.load[j][c];
        match &self.form.form {
            Form::Blocks(blocks) => {
                for (j, (block, z)) in blocks.iter().zip(state).enumerate() {
                    let a = block.matrix();
                    rate[j] = [0, 1].map(|c| a[c][0] * z[0] + a[c][1] * z[1] + input(j, c));
                }
            }
            Form::Dense(matrix) => {
                for (j, out) in rate.iter_mut().enumerate() {
                    *out = [0, 1].map(|c| {
                        let row = matrix.row(2 * j + c);
                        let free: f64 = state
                            .iter()
                            .flatten()
                            .zip(row.iter())
                            .map(|(z, a)| a * z)
                            .sum();
                        free + input(j, c)
                    });
                }
            }
        }
    }

    /// The flow: forcing split off where no block is near resonance.
    pub fn flow(&self) -> SceneFlow {
        modal_flow(
            &self.form,
            self.load.clone(),
            self.force.clone(),
            self.frequency,
        )
    }
}

/// The flow of a modal form under a load and a force, frequency zero without forcing: the force split off where no block is
/// near resonance.
pub(crate) fn modal_flow(
    form: &ModalForm,
    load: Vec<Pair>,
    force: Vec<Response>,
    frequency: f64,
) -> SceneFlow {
    match &form.form {
        Form::Blocks(blocks) => block_flow(blocks, load, force, frequency),
        Form::Dense(matrix) => {
            SceneFlow::Dense(DenseFlow::new(matrix.clone(), &load, &force, frequency))
        }
    }
}

/// The same of blocks.
fn block_flow(
    blocks: &[Block],
    load: Vec<Pair>,
    force: Vec<Response>,
    frequency: f64,
) -> SceneFlow {
    if frequency > 0.0 {
        if let Some(split) = SplitFlow::new(blocks, &load, frequency, &force) {
            return SceneFlow::Split(split);
        }
        let drive = HarmonicDrive { frequency, force };
        return SceneFlow::Forced(BlockFlow::new(blocks, Loaded { load, drive }));
    }
    let drive = Undriven;
    if load.iter().all(|load| *load == [0.0, 0.0]) {
        return SceneFlow::Free(BlockFlow::new(blocks, drive));
    }
    SceneFlow::Loaded(BlockFlow::new(blocks, Loaded { load, drive }))
}

/// `sum r.z` of a row and a state.
#[inline]
pub(crate) fn along(row: &[Pair], state: &[Pair]) -> f64 {
    row.iter()
        .zip(state)
        .map(|(r, z)| r[0] * z[0] + r[1] * z[1])
        .sum()
}

/// Runs a block of code with the flow of a scene, whatever its type: the one `match` at the edge.
macro_rules! with_flow {
    ($scene_flow:expr, $flow:ident => $body:expr) => {
        match $scene_flow {
            $crate::flow::SceneFlow::Free($flow) => $body,
            $crate::flow::SceneFlow::Loaded($flow) => $body,
            $crate::flow::SceneFlow::Split($flow) => $body,
            $crate::flow::SceneFlow::Forced($flow) => $body,
            $crate::flow::SceneFlow::Dense($flow) => $body,
        }
    };
}
pub(crate) use with_flow;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::carry;

    /// `y'' + k y = 1 + cos(w t)` from rest: the equilibrium lies at 1/k, far beyond what the motion reaches.
    #[test]
    fn a_load_on_a_soft_spring_keeps_its_digits_beside_a_force() {
        let (w, t) = (0.8, 20.0);
        for k in [1e-2, 1e-4, 1e-8, 1e-12] {
            let block = Block::Oscillator { w2: k, eta: 0.0 };
            let force = [[0.0.into(), Complex::new(1.0, 0.0)]];
            let flow = block_flow(&[block], vec![[0.0, 1.0]], force.to_vec(), w);
            let mut z = vec![[0.0, 0.0]];
            with_flow!(&flow, flow => carry(flow, 0.0, t, &mut z));
            // 1 - cos(x) = 2 sin^2(x/2), and cos(w t) - cos(r t) as a product of sines
            let r = f64::sqrt(k);
            let loaded = 2.0 * (0.5 * r * t).sin().powi(2) / k;
            let forced = 2.0 * (0.5 * (r + w) * t).sin() * (0.5 * (r - w) * t).sin() / (k - w * w);
            let error = (z[0][0] / (loaded + forced) - 1.0).abs();
            assert!(error < 1e-14, "{k:e}: {error:e}");
        }
    }
}

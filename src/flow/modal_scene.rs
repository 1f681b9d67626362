//! A linear scene in modal pairs: forcing and stops as the periodic solve and the simulation use them.

use crate::error::Result;
use crate::flow::scene_flow::{SceneFlow, modal_flow};
use crate::modal::{Form, ModalForm, Pair, Response};
use crate::model::{ContactGeometry, Excitation, LinearSystem, Scene, powers};
use nalgebra::Complex;
use std::sync::Arc;

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
    /// The force of the first harmonic, phase left out but in a timed scene.
    pub force: Vec<Response>,
    /// Those of the second, the third and so on.
    pub higher: Vec<Vec<Response>>,
    /// The same on the coordinates.
    pub excitation: Excitation,
    /// Forcing frequency, zero without forcing.
    pub frequency: f64,
}

impl ModalScene {
    /// The modal form of a linear scene; `purpose` says in an error what needs it linear.
    pub fn new(scene: &Scene, purpose: &str) -> Result<Self> {
        Self::turned(scene, purpose, 0.0)
    }

    pub(super) fn turned(scene: &Scene, purpose: &str, phase: f64) -> Result<Self> {
        let system = scene.linear_system(purpose)?;
        let form = ModalForm::of(system)?;
        let geometry = ContactGeometry::new(system, scene);
        let each = |of: &dyn Fn(usize) -> Vec<Pair>| {
            Arc::new((0..geometry.len()).map(of).collect::<Vec<_>>())
        };
        let position_rows = each(&|i| form.position_row(&geometry.normals.column(i).into_owned()));
        let velocity_rows = each(&|i| form.velocity_row(&geometry.normals.column(i).into_owned()));
        let jumps = each(&|i| form.velocity_jump(&geometry.reactions.column(i).into_owned()));
        let excitation = scene.excitation().turned(phase);
        let n = system.n_dof();
        let load = form.load(system, &excitation.constant(n));
        let mut forces = excitation
            .harmonics
            .iter()
            .map(|part| form.force(system, &part.force));
        let none = || vec![[Complex::default(); 2]; n];
        let force = forces.next().unwrap_or_else(none);
        let higher = forces.collect();
        Ok(Self {
            system: Arc::clone(system),
            form,
            geometry: Arc::new(geometry),
            position_rows,
            velocity_rows,
            jumps,
            load,
            force,
            higher,
            frequency: excitation.frequency,
            excitation,
        })
    }

    /// Number of stops.
    pub fn n_stops(&self) -> usize {
        self.jumps.len()
    }

    /// Number of harmonics of the force, at least one.
    pub fn n_harmonics(&self) -> usize {
        1 + self.higher.len()
    }

    /// The harmonics of the force with their frequencies, at least one.
    pub fn harmonics(&self) -> impl Iterator<Item = (f64, &[Response])> {
        let forces = std::iter::once(&self.force).chain(&self.higher);
        let frequencies = (1..).map(|k: u32| f64::from(k) * self.frequency);
        frequencies.zip(forces.map(Vec::as_slice))
    }

    /// The harmonics of the force, at least one.
    pub fn forces(&self) -> Vec<Vec<Response>> {
        self.harmonics().map(|(_, force)| force.to_vec()).collect()
    }

    /// The rate of change of a state at the forcing angle whose phasor is u.
    pub fn rate(&self, state: &[Pair], u: Complex<f64>, rate: &mut [Pair]) {
        let input = |j: usize, c: usize| {
            let higher = self.higher.iter().zip(powers(u).skip(1));
            let higher: f64 = higher.map(|(force, u)| (force[j][c] * u).re).sum();
            (self.force[j][c] * u).re + higher + self.load[j][c]
        };
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
        modal_flow(&self.form, self.load.clone(), self.forces(), self.frequency)
    }
}

/// `sum r.z` of a row and a state.
#[inline]
pub(crate) fn along(row: &[Pair], state: &[Pair]) -> f64 {
    row.iter()
        .zip(state)
        .map(|(r, z)| r[0] * z[0] + r[1] * z[1])
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Change, Constraint, Forcing, Harmonic, Stop, System};
    use nalgebra::dvector;

    #[test]
    fn scenes_of_one_system_share_its_modal_form() {
        let system = LinearSystem::from_modes(&dvector![1.0, 3.0], &dvector![0.01, 0.01]);
        let system = System::from(system.expect("valid"));
        let stop = Stop::new(0, 0.5, 0.8).expect("valid");
        let amplitude = dvector![1.0, 0.0].map(Complex::from);
        let force = Harmonic::new(amplitude, 2.0, 0.0).expect("valid");
        let scene = Scene::new(system.clone(), force, [stop]).expect("fits");
        let none: [Constraint; 0] = [];
        let other = Scene::new(system, Forcing::Unforced, none).expect("fits");
        let changed = scene.replace(Change::Frequency(3.0)).expect("valid");
        let form = |scene: &Scene| ModalScene::new(scene, "a test").expect("linear").form;
        assert!(Arc::ptr_eq(&form(&scene), &form(&other)));
        assert!(Arc::ptr_eq(&form(&scene), &form(&changed)));
        let damped = scene.replace(Change::DampingScale(2.0)).expect("valid");
        assert!(!Arc::ptr_eq(&form(&scene), &form(&damped)));
    }
}

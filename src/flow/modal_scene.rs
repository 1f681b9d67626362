//! A linear scene in modal pairs: forcing and stops as the periodic solve and the simulation use them.

use crate::error::Result;
use crate::flow::gap_row::Quantity;
use crate::flow::many_drive::{ManyDrive, SignalInput};
use crate::flow::scene_flow::{SceneFlow, modal_flow};
use crate::law::Regime;
use crate::modal::{Form, ModalForm, Pair, Response, check_range};
use crate::model::{ContactGeometry, Excitation, LinearSystem, Moment, Rotations, Scene};
use nalgebra::{Complex, DVector};
use std::sync::{Arc, OnceLock};

/// A linear scene in modal pairs: rows of its stops, forces on its blocks.
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
    /// The harmonics and tones of the excitation, by their frequencies.
    pub rotations: Rotations,
    /// The force of the first rotation, phase left out but in a timed scene; zero where nothing turns.
    pub force: Vec<Response>,
    /// The forces of the other rotations.
    pub higher: Vec<Vec<Response>>,
    /// The forces that follow signals.
    pub signals: Vec<SignalInput>,
    /// The whole excitation, on the physical coordinates.
    pub excitation: Excitation,
    /// The fundamental frequency, zero without forcing, and where there is no period.
    pub frequency: f64,
    pub flow_cache: FlowCache,
}

/// The flow of a scene, made when it is first asked for. A copy has none, as it may be changed.
#[derive(Debug, Default)]
pub(crate) struct FlowCache(OnceLock<Arc<SceneFlow>>);

impl Clone for FlowCache {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// The normals and reactions of the stops of a scene in its modes.
struct ModalContacts {
    geometry: Arc<ContactGeometry>,
    position_rows: Arc<Vec<Vec<Pair>>>,
    velocity_rows: Arc<Vec<Vec<Pair>>>,
    jumps: Arc<Vec<Vec<Pair>>>,
}

impl ModalContacts {
    fn new(system: &LinearSystem, form: &ModalForm, scene: &Scene) -> Result<Self> {
        let geometry = ContactGeometry::new(system, scene);
        if geometry.len() > 0 && system.diagonals().is_none() {
            check_range(system)?;
        }
        Ok(Self::of(Arc::new(geometry), form))
    }

    fn of(geometry: Arc<ContactGeometry>, form: &ModalForm) -> Self {
        let each = |of: &dyn Fn(usize) -> Vec<Pair>| {
            Arc::new((0..geometry.len()).map(of).collect::<Vec<_>>())
        };
        let normal = |i: usize| geometry.normals.column(i).into_owned();
        let reaction = |i: usize| geometry.reactions.column(i).into_owned();
        Self {
            position_rows: each(&|i| form.position_row(&normal(i))),
            velocity_rows: each(&|i| form.velocity_row(&normal(i))),
            jumps: each(&|i| form.velocity_jump(&reaction(i))),
            geometry,
        }
    }
}

impl ModalScene {
    /// The modal form of a linear scene; `purpose` says in an error what needs it linear.
    pub fn new(scene: &Scene, purpose: &str) -> Result<Self> {
        Self::turned(scene, purpose, 0.0)
    }

    /// The same, made once of each scene.
    pub fn of(scene: &Scene, purpose: &str) -> Result<Arc<Self>> {
        scene.modal().or_made(|| Self::new(scene, purpose))
    }

    pub(super) fn turned(scene: &Scene, purpose: &str, phase: f64) -> Result<Self> {
        let system = scene.linear_system(purpose)?;
        let form = ModalForm::of(system)?;
        let contacts = scene
            .contacts()
            .or_made(|| ModalContacts::new(system, &form, scene))?;
        let excitation = scene.excitation().turned(phase);
        Ok(Self::of_parts(system, form, &contacts, excitation))
    }

    /// The same with the stops that are pressed in a regime as springs and dashpots of its system: the motion while nothing is held.
    pub fn with_pressed(&self, regime: &Regime) -> Result<Self> {
        let (system, g) = (&self.system, &self.geometry);
        let (mass, n) = (system.mass(), system.n_dof());
        let [stiffness, damping] = g.pressed(regime).map(|m| mass.to_dense() * m);
        let stiffened = LinearSystem::new(
            mass.to_dense(),
            system.damping().to_dense() + damping,
            system.stiffness().to_dense() + stiffness,
        )?;
        let mut excitation = self.excitation.clone();
        excitation.load = excitation.constant(n);
        for (element, force) in g.forces(regime) {
            let direction = mass.times(&g.reactions.column(element).into_owned());
            let clearance = self.mean_clearances(&[element])[0];
            excitation
                .load
                .axpy(-force.at(clearance, 0.0), &direction, 1.0);
            let motion = self.excitation.motion_of(element);
            let amplitudes = motion.map_or(&[][..], |own| &own.amplitudes);
            let frequencies = self.rotations.frequencies();
            let turning = excitation.harmonics.iter_mut().zip(frequencies);
            for ((part, w), amplitude) in turning.zip(amplitudes) {
                if part.force.is_empty() {
                    part.force = DVector::zeros(n);
                }
                let push = force.turned(*amplitude, w);
                part.force.zip_apply(&direction, |own, b| *own += push * b);
            }
        }
        let form = ModalForm::of(&stiffened)?;
        let contacts = ModalContacts::of(Arc::clone(g), &form);
        Ok(Self::of_parts(
            &Arc::new(stiffened),
            form,
            &contacts,
            excitation,
        ))
    }

    /// The same with other clearances of some stops.
    pub fn with_clearances(&self, changed: &[(usize, f64)]) -> Self {
        let mut geometry = (*self.geometry).clone();
        for &(stop, clearance) in changed {
            geometry.clearances[stop] = clearance;
        }
        Self {
            geometry: Arc::new(geometry),
            ..self.clone()
        }
    }

    fn of_parts(
        system: &Arc<LinearSystem>,
        form: Arc<ModalForm>,
        contacts: &ModalContacts,
        excitation: Excitation,
    ) -> Self {
        let n = system.n_dof();
        let load = form.load(system, &excitation.constant(n));
        let none = || vec![[Complex::default(); 2]; n];
        let mut forces = excitation.harmonics.iter().map(|part| {
            if part.force.is_empty() {
                none()
            } else {
                form.force(system, &part.force)
            }
        });
        let force = forces.next().unwrap_or_else(none);
        let higher = forces.by_ref().collect();
        drop(forces);
        let signals = excitation.signals.iter().map(|part| SignalInput {
            signal: part.signal.clone(),
            directions: if part.force.is_empty() {
                vec![[0.0; 2]; n]
            } else {
                form.load(system, &part.force)
            },
        });
        let signals = signals.collect();
        Self {
            system: Arc::clone(system),
            form,
            geometry: Arc::clone(&contacts.geometry),
            position_rows: Arc::clone(&contacts.position_rows),
            velocity_rows: Arc::clone(&contacts.velocity_rows),
            jumps: Arc::clone(&contacts.jumps),
            load,
            force,
            higher,
            signals,
            frequency: excitation.rotations.fundamental,
            rotations: excitation.rotations.clone(),
            excitation,
            flow_cache: FlowCache::default(),
        }
    }

    /// The gap of a stop as a quantity of the motion.
    pub fn gap(&self, stop: usize) -> Quantity {
        let gap = Quantity::gap(self.geometry.clearances[stop], &self.position_rows[stop]);
        match self.excitation.motion_of(stop) {
            None => gap,
            Some(motion) => gap.widened_by(motion),
        }
    }

    /// The clearances of some stops, with the means of their motions.
    pub fn mean_clearances(&self, stops: &[usize]) -> DVector<f64> {
        let mut clearances = self.geometry.clearances.select_rows(stops);
        for (clearance, &stop) in clearances.iter_mut().zip(stops) {
            *clearance += self
                .excitation
                .motion_of(stop)
                .map_or(0.0, |motion| motion.mean);
        }
        clearances
    }

    /// What the own motion of a stop adds to its gap at a moment, with speed and acceleration: zeros of one that rests.
    #[inline]
    pub fn stop_motion(&self, stop: usize, at: Moment) -> [f64; 3] {
        if self.excitation.stops.is_empty() {
            return [0.0; 3];
        }
        let motion = self.excitation.motion_of(stop);
        motion.map_or([0.0; 3], |motion| motion.along(at))
    }

    /// Number of stops.
    pub fn n_stops(&self) -> usize {
        self.jumps.len()
    }

    /// Number of harmonic forces.
    pub fn n_harmonics(&self) -> usize {
        self.rotations.len()
    }

    /// The harmonic forces, with their frequencies \[rad/s\].
    pub fn harmonics(&self) -> impl Iterator<Item = (f64, &[Response])> {
        let forces = std::iter::once(&self.force).chain(&self.higher);
        let forces = forces.map(Vec::as_slice);
        self.rotations.frequencies().zip(forces)
    }

    /// Its drive.
    pub fn drive(&self) -> ManyDrive {
        let forces = std::iter::once(&self.force).chain(&self.higher);
        ManyDrive {
            forces: forces.take(self.rotations.len()).cloned().collect(),
            rotations: self.rotations.clone(),
            signals: self.signals.clone(),
        }
    }

    /// The rate of change of a state at a moment.
    pub fn rate(&self, state: &[Pair], at: Moment, rate: &mut [Pair]) {
        let phasors: Vec<Complex<f64>> = self.rotations.phasors(at).collect();
        let values: Vec<f64> = self
            .excitation
            .signals
            .iter()
            .map(|s| s.value(at))
            .collect();
        let input = |j: usize, c: usize| {
            let forces = std::iter::once(&self.force).chain(&self.higher);
            let turned = forces.zip(&phasors);
            let turned: f64 = turned.map(|(force, u)| (force[j][c] * u).re).sum();
            let signals = self.signals.iter().zip(&values);
            let signals: f64 = signals.map(|(own, x)| own.directions[j][c] * x).sum();
            turned + signals + self.load[j][c]
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
    pub fn flow(&self) -> Arc<SceneFlow> {
        let made = || Arc::new(modal_flow(&self.form.form, self.load.clone(), self.drive()));
        Arc::clone(self.flow_cache.0.get_or_init(made))
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
    use crate::model::{Constraint, Forcing, Harmonic, Parameter, Stop, System};
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
        let changed = scene
            .replace(Parameter::Frequency.change(3.0))
            .expect("valid");
        let form = |scene: &Scene| ModalScene::new(scene, "a test").expect("linear").form;
        assert!(Arc::ptr_eq(&form(&scene), &form(&other)));
        assert!(Arc::ptr_eq(&form(&scene), &form(&changed)));
        let damped = scene
            .replace(Parameter::DampingScale.change(2.0))
            .expect("valid");
        assert!(!Arc::ptr_eq(&form(&scene), &form(&damped)));
    }
}

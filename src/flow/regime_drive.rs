//! What drives the motion of a linear scene in a regime: the forces of the scene, as accelerations of the whole system, and what stops that
//! move add to them.

use crate::flow::gap_row::Quantity;
use crate::flow::many_drive::{ManyDrive, SignalInput};
use crate::flow::modal_scene::ModalScene;
use crate::flow::reduced_system::{Reduced, form_drive, form_load};
use crate::flow::scene_flow::{SceneFlow, modal_flow};
use crate::law::{LinearForce, Relaxation};
use crate::modal::{Block, Form, ModalForm};
use crate::model::{GapMotion, Signal};
use nalgebra::{Complex, DMatrix, DVector};

const ZERO: Complex<f64> = Complex::new(0.0, 0.0);

/// What drives the motion in a regime.
pub(super) struct RegimeDrive {
    /// The accelerations by each rotation, shape `(n,)` each, \[m/s^2\].
    pub turning: Vec<DVector<Complex<f64>>>,
    /// The accelerations by each signal, shape `(n,)` each, \[m/s^2\] per unit of the signal.
    pub following: Vec<DVector<f64>>,
    /// The rotations and the signals.
    given: ManyDrive,
    /// For a signal its derivative among the signals, where that was asked for.
    derivatives: Vec<(usize, usize)>,
}

impl RegimeDrive {
    /// That of a scene where nothing is in contact.
    pub fn new(scene: &ModalScene) -> Self {
        let (turning, following) = free_accelerations(scene);
        Self {
            turning,
            following,
            given: scene.drive(),
            derivatives: Vec::new(),
        }
    }

    /// Adds an acceleration that follows a signal of its own; returns the number of that.
    pub fn add(&mut self, signal: Signal, acceleration: DVector<f64>) -> usize {
        self.following.push(acceleration);
        self.given.signals.push(SignalInput {
            signal,
            directions: Vec::new(),
        });
        self.following.len() - 1
    }

    /// The number of the derivative of a signal.
    fn derivative(&mut self, signal: usize) -> usize {
        if let Some(known) = self.derivatives.iter().find(|own| own.0 == signal) {
            return known.1;
        }
        let derivative = self.given.signals[signal].signal.derivative();
        let nothing = DVector::zeros(self.following[signal].len());
        let made = self.add(derivative, nothing);
        self.derivatives.push((signal, made));
        made
    }

    /// Adds what the motion of a stop with a force does along its reaction; its mean is in the load.
    pub fn push(
        &mut self,
        motion: Option<&GapMotion>,
        force: LinearForce,
        reaction: &DVector<f64>,
    ) {
        let Some(motion) = motion else {
            return;
        };
        let frequencies = self.given.rotations.frequencies();
        let turning = self.turning.iter_mut().zip(&motion.amplitudes);
        for ((acceleration, amplitude), w) in turning.zip(frequencies) {
            let push = force.turned(*amplitude, w);
            acceleration.zip_apply(reaction, |a, b| *a += push * b);
        }
        if let Some((signal, _)) = motion.signal {
            self.following[signal].axpy(force.stiffness, reaction, 1.0);
            if force.damping > 0.0 {
                let rate = self.derivative(signal);
                self.following[rate].axpy(force.damping, reaction, 1.0);
            }
        }
    }

    /// Adds a factor times the rate of what moves a gap by itself to a quantity.
    pub fn add_rate(&mut self, gap: &Quantity, factor: f64, quantity: &mut Quantity) {
        let turning = gap.forcing.iter().zip(self.given.rotations.frequencies());
        for (own, (amplitude, w)) in quantity.forcing.iter_mut().zip(turning) {
            *own += amplitude * Complex::new(0.0, w * factor);
        }
        for (signal, amplitude) in gap.signals.iter().enumerate() {
            if *amplitude != 0.0 {
                let rate = self.derivative(signal);
                if quantity.signals.len() <= rate {
                    quantity.signals.resize(rate + 1, 0.0);
                }
                quantity.signals[rate] += amplitude * factor;
            }
        }
    }

    /// The flow of a smaller system under it and a constant acceleration, with a block for each stop that relaxes.
    pub fn flow(
        self,
        form: &ModalForm,
        reduced: &Reduced,
        load: &DVector<f64>,
        relaxing: &[(usize, Relaxation)],
    ) -> SceneFlow {
        let mut drive = form_drive(form, reduced, self.given, (&self.turning, &self.following));
        let mut load = form_load(form, &reduced.apply(load));
        if relaxing.is_empty() {
            return modal_flow(&form.form, load, drive);
        }
        let n = load.len() + relaxing.len();
        load.resize(n, [0.0; 2]);
        for force in &mut drive.forces {
            force.resize(n, [ZERO; 2]);
        }
        for signal in &mut drive.signals {
            signal.directions.resize(n, [0.0; 2]);
        }
        modal_flow(&with_relaxing(&form.form, relaxing), load, drive)
    }
}

/// A form with a block for each stop that relaxes: its place, beside nothing.
fn with_relaxing(form: &Form, relaxing: &[(usize, Relaxation)]) -> Form {
    let roots = relaxing.iter().map(|own| [-own.1.rate, -2.0 * own.1.rate]);
    match form {
        Form::Blocks(blocks) => {
            let own = roots.map(|roots| Block::Decays { roots });
            Form::Blocks(blocks.iter().copied().chain(own).collect())
        }
        Form::Dense(matrix) => {
            let n = matrix.nrows();
            let all = n + 2 * relaxing.len();
            let mut whole = DMatrix::zeros(all, all);
            whole.view_mut((0, 0), (n, n)).copy_from(matrix);
            for (place, root) in (n..).zip(roots.flatten()) {
                whole[(place, place)] = root;
            }
            Form::Dense(whole)
        }
    }
}

/// The harmonic accelerations of the whole system without contact forces, and those that follow signals.
fn free_accelerations(scene: &ModalScene) -> (Vec<DVector<Complex<f64>>>, Vec<DVector<f64>>) {
    let (system, n) = (&scene.system, scene.system.n_dof());
    let turning = scene.excitation.harmonics.iter().map(|part| {
        if part.force.is_empty() {
            DVector::from_element(n, ZERO)
        } else {
            system.solve_mass_complex(&part.force)
        }
    });
    let following = scene.excitation.signals.iter().map(|part| {
        if part.force.is_empty() {
            DVector::zeros(n)
        } else {
            system.solve_mass(&part.force)
        }
    });
    (turning.collect(), following.collect())
}

//! Scenes whose families are known.

use vibroimpact::nalgebra::{DMatrix, dmatrix, dvector};
use vibroimpact::{
    EquationsOfMotion, Error, Harmonic, LinearSystem, NonlinearSystem, Scene, Side, StateBox, Stop,
};

/// `x'' + 0.1 x' + x = F cos 2.4 t` before a stop at one, restitution 0.8.
pub fn oscillator(force: f64) -> Scene {
    oscillator_at(force, 2.4, 1.0)
}

/// The same at another frequency, before a stop elsewhere.
pub fn oscillator_at(force: f64, frequency: f64, clearance: f64) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![force.into()], frequency, 0.0).expect("valid");
    let stop = Stop::new(0, clearance, 0.8).expect("valid");
    Scene::new(system, force, [stop]).expect("valid")
}

/// A mass between two stops about zero: half a period later it is the mirror of itself.
pub fn between_stops() -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.05], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 1.03, 0.0).expect("valid");
    let stop = || Stop::new(0, 0.5, 0.7).expect("valid");
    let stops = [stop(), stop().on_side(Side::Lower)];
    Scene::new(system, force, stops).expect("valid")
}

/// `x'' = x - x^3 - c x'`
struct DoubleWell {
    damping: f64,
}

impl EquationsOfMotion for DoubleWell {
    fn n_dof(&self) -> usize {
        1
    }

    fn acceleration(&self, _: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Error> {
        a[0] = q[0] - q[0].powi(3) - self.damping * v[0];
        Ok(())
    }

    fn has_mass(&self) -> bool {
        true
    }

    fn mass(&self, _: &[f64]) -> Result<DMatrix<f64>, Error> {
        Ok(dmatrix![1.0])
    }
}

/// Two wells under `0.2 cos t`: an orbit in each.
pub fn double_well() -> Scene {
    well(0.15, 0.2)
}

/// Two wells under a force `F cos t`.
pub fn well(damping: f64, force: f64) -> Scene {
    let system = NonlinearSystem::new(DoubleWell { damping }).expect("valid");
    let none: [Stop; 0] = [];
    let force = Harmonic::new(dvector![force.into()], 1.0, 0.0).expect("valid");
    Scene::new(system, force, none).expect("valid")
}

/// A grid of states over a box of one degree of freedom.
pub fn grid([q0, q1]: [f64; 2], [v0, v1]: [f64; 2], side: usize) -> (StateBox, DMatrix<f64>) {
    let at = |low: f64, high: f64, k: usize| low + (high - low) * (k as f64 + 0.5) / side as f64;
    let states = DMatrix::from_fn(side * side, 2, |k, j| {
        if j == 0 {
            at(q0, q1, k % side)
        } else {
            at(v0, v1, k / side)
        }
    });
    let around = StateBox::new(dvector![q0, v0], dvector![q1, v1]).expect("a box");
    (around, states)
}

//! Parts of scenes that many tests are about, and runs: valid as they stand, so that a test says only what is its own.

#![allow(
    dead_code,
    reason = "each test crate that includes this file uses a part of it"
)]

use nalgebra::{DVector, dvector};
use vibroimpact::{
    Coefficient, Constraint, Forcing, Harmonic, LinearSystem, Method, Normal, OrbitOptions, Scene,
    Side, SimulateOptions, Solver, Stop, System, Trajectory, simulate,
};

pub fn scene(
    system: impl Into<System>,
    forcing: impl Into<Forcing>,
    stops: impl IntoIterator<Item = impl Into<Constraint>>,
) -> Scene {
    Scene::new(system, forcing, stops).expect("valid")
}

pub fn linear(
    mass: impl Into<Coefficient>,
    damping: impl Into<Coefficient>,
    stiffness: impl Into<Coefficient>,
) -> LinearSystem {
    LinearSystem::new(mass, damping, stiffness).expect("valid")
}

/// The same under a constant force.
pub fn loaded(system: LinearSystem, load: &[f64]) -> LinearSystem {
    let load = DVector::from_row_slice(load);
    system.with_load(load).expect("valid")
}

/// `q'' + damping q' + stiffness q`
pub fn unit_mass(damping: f64, stiffness: f64) -> LinearSystem {
    linear(dvector![1.0], dvector![damping], dvector![stiffness])
}

/// An oscillator of unit mass and stiffness.
pub fn oscillator(
    damping: f64,
    forcing: impl Into<Forcing>,
    stops: impl IntoIterator<Item = impl Into<Constraint>>,
) -> Scene {
    scene(unit_mass(damping, 1.0), forcing, stops)
}

/// A force on each coordinate, each times `cos(frequency t + phase)`.
pub fn harmonic(force: &[f64], frequency: f64, phase: f64) -> Forcing {
    let force = DVector::from_row_slice(force).map(Into::into);
    let harmonic = Harmonic::new(force, frequency, phase);
    harmonic.expect("valid").into()
}

/// What keeps the place along a normal below a clearance.
pub fn upper(normal: impl Into<Normal>, clearance: f64, restitution: f64) -> Stop {
    Stop::new(normal, clearance, restitution).expect("valid")
}

/// What keeps it above the clearance's negative.
pub fn lower(normal: impl Into<Normal>, clearance: f64, restitution: f64) -> Stop {
    upper(normal, clearance, restitution).on_side(Side::Lower)
}

/// A ball of unit mass and weight above a table at rest.
pub fn ball(restitution: f64) -> Scene {
    falling(restitution, Forcing::Unforced)
}

/// The same above a table that shakes, seen from there: `q'' = -1 + shake cos(t + phase)`.
pub fn shaken_ball(restitution: f64, shake: f64, phase: f64) -> Scene {
    falling(restitution, harmonic(&[shake], 1.0, phase))
}

fn falling(restitution: f64, forcing: Forcing) -> Scene {
    let ball = loaded(unit_mass(0.0, 0.0), &[-1.0]);
    scene(ball, forcing, [lower(0, 0.0, restitution)])
}

/// What takes flights as they are known, and what takes them in steps.
pub const BOTH: [Method; 2] = [Method::Exact, Method::Rk45];

/// A method and a tolerance, with the usual absolute one beside it.
pub fn with(method: Method, rtol: f64) -> SimulateOptions {
    SimulateOptions {
        solver: Solver {
            method,
            rtol,
            atol: Some(rtol / 1e3),
        },
        ..Default::default()
    }
}

/// A run from the time zero to an end.
pub fn run(
    scene: &Scene,
    q0: &[f64],
    v0: &[f64],
    end: f64,
    options: &SimulateOptions,
) -> Trajectory {
    let [q0, v0] = [q0, v0].map(DVector::from_row_slice);
    simulate(scene, &q0, &v0, (0.0, end), options).expect("runs")
}

/// Orbits that close after so many periods of the forcing.
pub fn periods(n_periods: usize) -> OrbitOptions {
    OrbitOptions {
        n_periods,
        ..Default::default()
    }
}

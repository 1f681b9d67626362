//! Equations of motion that depend on time by themselves, and the Jacobians that they give, as the search for orbits has them.

use crate::scenes::{linear, upper};
use nalgebra::{Complex, DMatrix, dmatrix, dvector};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};
use vibroimpact::{
    EquationsOfMotion, Forcing, Harmonic, ImpactSide, Motion, NonlinearSystem, OrbitOptions,
    Pattern, PeriodicOrbit, Result, Scene, SimulateOptions, Solver, find_orbit, periodic_orbits,
    simulate,
};

const W: f64 = 1.4;
const DAMPING: f64 = 0.2;

/// `q'' = -q - 0.2 q' + force cos(turn W t + shift)`, with a Jacobian that is its own times `factor`.
#[derive(Clone, Copy)]
struct Shaken {
    force: f64,
    turn: f64,
    shift: f64,
    jacobian: Option<(f64, usize)>,
}

/// How often a Jacobian that was given has been asked for.
static CALLS: AtomicUsize = AtomicUsize::new(0);

impl EquationsOfMotion for Shaken {
    fn n_dof(&self) -> usize {
        1
    }
    fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a[0] = -q[0] - DAMPING * v[0] + self.force * (self.turn * W * t + self.shift).cos();
        Ok(())
    }
    fn has_mass(&self) -> bool {
        true
    }
    fn mass(&self, _q: &[f64]) -> Result<DMatrix<f64>> {
        Ok(dmatrix![1.0])
    }
    fn jacobian(&self, _t: f64, _q: &[f64], _v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let given = |(factor, columns): (f64, usize)| {
            CALLS.fetch_add(1, Ordering::Relaxed);
            DMatrix::from_fn(
                1,
                columns,
                |_, j| if j == 0 { -1.0 } else { -DAMPING * factor },
            )
        };
        Ok(self.jacobian.map(given))
    }
}

const STILL: Shaken = Shaken {
    force: 0.0,
    turn: 1.0,
    shift: 0.0,
    jacobian: None,
};

fn scene(system: Shaken, force: Complex<f64>) -> Scene {
    let forcing = Harmonic::new(dvector![force], W, 0.0).expect("valid");
    Scene::new(
        NonlinearSystem::new(system).expect("valid"),
        forcing,
        [upper(0, 0.3, 0.7)],
    )
    .expect("valid")
}

/// The orbit of the same motion with all of its force given as a forcing, in closed form.
fn known(force: Complex<f64>) -> PeriodicOrbit {
    let system = linear(dmatrix![1.0], dmatrix![DAMPING], dmatrix![1.0]);
    let forcing = Harmonic::new(dvector![force], W, 0.0).expect("valid");
    let scene = Scene::new(system, forcing, [upper(0, 0.3, 0.7)]).expect("valid");
    let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
    let found = orbits
        .expect("solved")
        .into_iter()
        .find(|o| o.is_admissible() == Some(true));
    found.expect("an admissible orbit")
}

#[test]
fn the_time_of_the_equations_moves_with_the_phase() {
    // Half of the force in the equations, half as a forcing, a quarter of a turn apart.
    let (inside, outside) = (Complex::from_polar(0.8, 0.9), Complex::new(0.6, 0.0));
    let wanted = known(inside + outside);
    for shift in [0.0, 0.4] {
        let system = Shaken {
            force: 0.8,
            turn: 1.0,
            shift: 0.9,
            jacobian: None,
        };
        let scene = scene(system, outside);
        let scene = if shift == 0.0 {
            scene
        } else {
            // The same scene, its time counted from later.
            let system = NonlinearSystem::new(system).expect("valid");
            let later = system.with_time_offset(shift).expect("finite");
            let forcing = Harmonic::new(dvector![outside], W, W * shift).expect("valid");
            Scene::new(later, forcing, [upper(0, 0.3, 0.7)]).expect("valid")
        };
        let orbit = find_orbit(&scene, &wanted, None).expect("closed");
        assert!((orbit.q0()[0] - wanted.q0()[0]).abs() < 1e-10);
        assert!(
            (orbit.v0()[0] - wanted.v0()[0]).abs() < 1e-10,
            "{shift} {}",
            orbit.v0()
        );
        assert!((orbit.phase() - wanted.phase()).sin().abs() < 1e-9);
        assert_eq!(orbit.is_admissible(), Some(true));
        let mu = |o: &PeriodicOrbit| o.stability().expect("converges").orders[0].spectral_radius();
        assert!((mu(&orbit) - mu(&wanted)).abs() < 1e-7);
        // Its scene retraces it.
        let options = SimulateOptions {
            solver: Solver {
                rtol: 1e-11,
                atol: Some(1e-13),
                ..Solver::default()
            },
            ..Default::default()
        };
        let end = 5.0 * orbit.period();
        let run = simulate(
            orbit.scene(),
            &orbit.q0(),
            &orbit.v0(),
            (0.0, end),
            &options,
        );
        let run = run.expect("integrated");
        let t = 4.3 * orbit.period();
        let (q, _) = run
            .state(t, vibroimpact::ImpactSide::After)
            .expect("inside");
        assert!((q[0] - orbit.state(t, ImpactSide::After).expect("a time").0[0]).abs() < 1e-7);
    }
}

#[test]
fn equations_that_do_not_repeat_with_the_forcing_are_refused() {
    let wanted = known(Complex::new(1.2, 0.0));
    for turn in [0.5, 1.3] {
        let system = Shaken {
            force: 0.1,
            turn,
            ..STILL
        };
        let error = find_orbit(&scene(system, Complex::new(1.2, 0.0)), &wanted, None);
        let message = error.expect_err("another period").to_string();
        assert!(
            message.contains("must repeat after the period of the forcing"),
            "{message}"
        );
    }
    let system = NonlinearSystem::new(Shaken {
        force: 1.2,
        ..STILL
    })
    .expect("valid");
    let free = Scene::new(system, Forcing::Unforced, [upper(0, 0.3, 0.7)]).expect("valid");
    let message = find_orbit(&free, &wanted, None)
        .expect_err("no forcing")
        .to_string();
    assert!(
        message.contains("give the scene a harmonic force"),
        "{message}"
    );
    // Twice as fast fits; and with the amplitude zero the equations may do it all.
    let system = Shaken {
        force: 1.2,
        ..STILL
    };
    let orbit = find_orbit(&scene(system, Complex::new(0.0, 0.0)), &wanted, None).expect("closed");
    assert!((orbit.v0()[0] - wanted.v0()[0]).abs() < 1e-10);
}

#[test]
fn a_given_jacobian_is_used_and_checked() {
    let force = Complex::new(1.2, 0.0);
    let wanted = known(force);
    let with = |jacobian| scene(Shaken { jacobian, ..STILL }, force);
    let orbit = find_orbit(&with(Some((1.0, 2))), &wanted, None).expect("closed");
    assert!(CALLS.load(Ordering::Relaxed) > 100);
    let exact = wanted.stability().expect("converges");
    let found = orbit.stability().expect("converges");
    let miss = (&found.orders[0].monodromy - &exact.orders[0].monodromy).amax();
    // Differences would leave 1e-10.
    assert!(miss < 2e-11, "{miss:e}");
    let message = find_orbit(&with(Some((1.01, 2))), &wanted, None)
        .expect_err("wrong")
        .to_string();
    for part in ["jacobian[0, 1]", "-0.202", "-0.2", "q = ", "t = 0"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    let message = find_orbit(&with(Some((1.0, 3))), &wanted, None)
        .expect_err("shape")
        .to_string();
    assert!(
        message.contains("jacobian") && message.contains("(1, 3)"),
        "{message}"
    );
    assert!((TAU / W - orbit.period()).abs() < 1e-12);
}

//! Stops hit at one instant in a system of many modes: the solve mode by mode (theory 5, "k impulses, n modes") against
//! the dense one of eqs. (29) and (38), `(I - R e^{AT}) z = (R - I) s(0)`, written out here.

use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::{PI, TAU};
use vibroimpact::{
    Harmonic, ImpactSide, LinearSystem, Motion, OrbitOptions, Pattern, PeriodicOrbit, Reaction,
    Scene, Stop, periodic_orbits, recovery_matrix,
};

const N: usize = 200;
const FREQUENCY: f64 = 1.5;
const PHASE: f64 = 0.7;
const RESTITUTIONS: [f64; 3] = [0.8, 0.35, 0.0];

/// Masses, frequencies and damping ratios of the modes: most of them light, every seventh overdamped, one critical.
fn mode(j: usize) -> (f64, f64, f64) {
    let mass = 1.0 + 0.25 * (j % 5) as f64;
    let frequency = 0.9 * (1 + j) as f64;
    let ratio = match j {
        20 => 1.0,
        _ if j % 7 == 3 => 1.0 + 0.3 * (j % 4) as f64 + 0.1,
        _ => 0.02 + 0.001 * (j % 11) as f64,
    };
    (mass, frequency, ratio)
}

/// Displacement of a string at x in each mode.
fn shape(x: f64) -> DVector<f64> {
    DVector::from_fn(N, |j, _| (2.0f64).sqrt() * ((j + 1) as f64 * PI * x).sin())
}

fn force() -> DVector<f64> {
    shape(0.37) * 3.0
}

fn load() -> DVector<f64> {
    shape(0.61) * 0.4
}

fn scene(normals: &[DVector<f64>; 3], reaction: impl Fn(usize) -> Reaction) -> Scene {
    let each = |f: &dyn Fn((f64, f64, f64)) -> f64| DVector::from_fn(N, |j, _| f(mode(j)));
    let system = LinearSystem::new(
        each(&|(m, _, _)| m),
        each(&|(m, w, zeta)| 2.0 * zeta * w * m),
        each(&|(m, w, _)| m * w * w),
    )
    .and_then(|s| s.with_load(load()))
    .expect("valid");
    let stops = (0..3).map(|i| {
        Stop::new(normals[i].clone(), 0.1, RESTITUTIONS[i])
            .and_then(|s| s.with_reaction(reaction(i)))
            .expect("valid")
    });
    let forcing = Harmonic::new(force().map(Complex::from), FREQUENCY, 0.0).expect("valid");
    Scene::new(system, forcing, stops).expect("valid")
}

/// The propagator of one mode over t, by the sum of its two exponentials or their limit.
fn propagator((_, w, zeta): (f64, f64, f64), t: f64) -> [[f64; 2]; 2] {
    let eta = zeta * w;
    let (c, s) = if zeta < 1.0 {
        let wd = w * (1.0 - zeta * zeta).sqrt();
        (
            (-eta * t).exp() * (wd * t).cos(),
            (-eta * t).exp() * (wd * t).sin() / wd,
        )
    } else if zeta > 1.0 {
        let de = w * (zeta * zeta - 1.0).sqrt();
        let (slow, fast) = (((de - eta) * t).exp(), ((-de - eta) * t).exp());
        (0.5 * (slow + fast), (slow - fast) / (2.0 * de))
    } else {
        ((-eta * t).exp(), (-eta * t).exp() * t)
    };
    [[c + eta * s, s], [-w * w * s, c - eta * s]]
}

/// The contact state of the dense solve: position, velocity before and after the impacts.
struct Dense {
    q: DVector<f64>,
    before: DVector<f64>,
    after: DVector<f64>,
}

fn dense(scene: &Scene, n_periods: usize) -> Dense {
    let period = TAU * n_periods as f64 / FREQUENCY;
    let recovery = recovery_matrix(scene, &[0, 1, 2]).expect("valid");
    let (mut flow, mut steady) = (DMatrix::zeros(2 * N, 2 * N), DVector::zeros(2 * N));
    let (f, f0) = (force(), load());
    for j in 0..N {
        let (m, w, zeta) = mode(j);
        let p = propagator(mode(j), period);
        for (a, row) in p.iter().enumerate() {
            for (b, x) in row.iter().enumerate() {
                flow[(j + a * N, j + b * N)] = *x;
            }
        }
        let response = Complex::from_polar(f[j] / m, PHASE)
            / Complex::new(w * w - FREQUENCY * FREQUENCY, 2.0 * zeta * w * FREQUENCY);
        steady[j] = response.re + f0[j] / (m * w * w);
        steady[j + N] = -FREQUENCY * response.im;
    }
    let identity = DMatrix::<f64>::identity(2 * N, 2 * N);
    // Positions in units of velocity, mode by mode, so that the elimination keeps its digits.
    let unit = DVector::from_fn(2 * N, |i, _| if i < N { mode(i).1 } else { 1.0 });
    let matrix = (&identity - &recovery * &flow).map_with_location(|i, j, x| x * unit[i] / unit[j]);
    let rhs = ((&recovery - &identity) * &steady).component_mul(&unit);
    let z = matrix
        .lu()
        .solve(&rhs)
        .expect("regular")
        .component_div(&unit);
    let (before, after) = (&flow * &z + &steady, &z + &steady);
    Dense {
        q: after.rows(0, N).into_owned(),
        before: before.rows(N, N).into_owned(),
        after: after.rows(N, N).into_owned(),
    }
}

fn close(got: &DVector<f64>, exact: &DVector<f64>, what: &str) {
    let error = (got - exact).amax() / exact.amax();
    assert!(error < 1e-12, "{what}: {error:e}");
}

fn solved(scene: &Scene, n_periods: usize) -> PeriodicOrbit {
    let options = OrbitOptions {
        n_periods,
        phase: Some(PHASE),
        ..Default::default()
    };
    let pattern = Pattern::together(&[0, 1, 2]).expect("valid");
    let orbits = periodic_orbits(scene, &pattern, &options).expect("solved");
    assert_eq!(orbits.len(), 1, "{}", orbits.reason());
    orbits[0].clone()
}

#[test]
fn three_stops_at_one_instant_are_solved_as_the_dense_system_says() {
    let on_a_string = || [0.2, 0.5, 0.7].map(shape);
    let on_modes = || [3, 90, 41].map(|i| DVector::from_fn(N, |j, _| f64::from(u8::from(i == j))));
    let askew = |i: usize| Reaction::Direction(shape([0.2, 0.5, 0.7][i]) + shape(0.4) * 0.3);
    let inertia = |_: usize| Reaction::Inertia;
    let coordinate = |_: usize| Reaction::Coordinate;
    let scenes = [
        (
            "coupled by inertia",
            on_a_string(),
            scene(&on_a_string(), inertia),
        ),
        (
            "the paper's law",
            on_a_string(),
            scene(&on_a_string(), coordinate),
        ),
        (
            "other directions",
            on_a_string(),
            scene(&on_a_string(), askew),
        ),
        ("uncoupled", on_modes(), scene(&on_modes(), inertia)),
    ];
    for (label, normals, scene) in scenes {
        for n_periods in [1, 3] {
            let (orbit, exact) = (solved(&scene, n_periods), dense(&scene, n_periods));
            close(&orbit.q0(), &exact.q, label);
            close(&orbit.v0(), &exact.after, label);
            close(
                &orbit.state(0.0, ImpactSide::Before).expect("a time").1,
                &exact.before,
                label,
            );
            let speeds = |v: &DVector<f64>| DVector::from_fn(3, |i, _| normals[i].dot(v));
            let impacts = orbit.impacts();
            let listed = |f: &dyn Fn(usize) -> f64| DVector::from_fn(3, |i, _| f(i));
            close(
                &listed(&|i| impacts[i].approach),
                &speeds(&exact.before),
                label,
            );
            close(
                &listed(&|i| -impacts[i].departure),
                &speeds(&exact.after),
                label,
            );
            // The clearances that come out are where the contacts are.
            let clearances = listed(&|i| normals[i].dot(&exact.q));
            close(
                &orbit.scene().gaps(&DVector::zeros(N)).expect("plane stops"),
                &clearances,
                label,
            );
        }
    }
}

//! Lyapunov exponents against multipliers of orbits, the law of their sum, and numbers of the literature.

use crate::scenes::oscillator;
use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Attraction, Forcing, Harmonic, ImpactSide, Kind, LinearSystem, LyapunovExponents,
    LyapunovOptions, Method, Motion, OrbitOptions, PaperOptions, Parameter, Pattern, PeriodicOrbit,
    Scene, Side, SimulateOptions, Status, Stop, StopMotion, find_orbit, lyapunov_exponents,
    nalgebra, paper_scene, periodic_orbits, simulate,
};

fn exponents(
    scene: &Scene,
    (q, v): (&DVector<f64>, &DVector<f64>),
    end: f64,
    options: &LyapunovOptions,
) -> LyapunovExponents {
    lyapunov_exponents(scene, q, v, (0.0, end), options).expect("exponents")
}

/// `ln |mu| / T`, largest first.
fn of_multipliers(orbit: &PeriodicOrbit) -> Vec<f64> {
    let stability = orbit.stability().expect("decided");
    let multipliers = &stability.orders[0].multipliers;
    let rates = multipliers.iter().map(|mu| mu.norm().ln() / orbit.period());
    rates.collect()
}

/// The exponents of the motion on an orbit are those of its multipliers.
fn check_orbit(orbit: &PeriodicOrbit, options: &LyapunovOptions) -> LyapunovExponents {
    let start = (&orbit.q0(), &orbit.v0());
    // Whole periods, from between two impacts to between two.
    let (skip, end) = (40.5 * orbit.period(), 8040.5 * orbit.period());
    let options = LyapunovOptions {
        skip,
        ..options.clone()
    };
    let found = exponents(orbit.scene(), start, end, &options);
    assert_eq!(found.status, Status::Finished);
    let all = of_multipliers(orbit);
    for (k, (la, expected)) in found.exponents.iter().zip(&all).enumerate() {
        // Of two that turn each is off by what a turn may make, over the time; both together are not.
        let is_turning = all
            .iter()
            .enumerate()
            .any(|(j, other)| j != k && (other - expected).abs() < 1e-12);
        let allowed = if is_turning { 1e-6 + 10.0 / end } else { 1e-6 };
        assert!((la - expected).abs() < allowed, "{la} {expected}");
    }
    let sums: [f64; 2] = [found.exponents.iter().sum(), all.iter().sum()];
    assert!((sums[0] - sums[1]).abs() < 1e-8, "{sums:?}");
    found
}

/// The first orbit of a pattern that is stable.
fn stable(scene: &Scene, pattern: &Pattern, n_periods: usize) -> PeriodicOrbit {
    let options = OrbitOptions {
        n_periods,
        ..OrbitOptions::default()
    };
    let orbits = periodic_orbits(scene, pattern, &options).expect("solved");
    let is_stable = |o: &&PeriodicOrbit| o.stability().expect("decided").is_stable == Some(true);
    orbits.iter().find(is_stable).expect("a stable one").clone()
}

#[test]
fn a_stable_orbit_has_the_exponents_of_its_multipliers() {
    let damped = PaperOptions {
        damping: Some(0.06),
        ..PaperOptions::default()
    };
    let pendulums = paper_scene(Kind::Three, &damped).expect("valid");
    let orbits = [
        stable(&oscillator(9.0), &Pattern::single(0), 1),
        stable(&oscillator(7.75), &Pattern::single(0), 1),
        stable(&pendulums, &Pattern::single(1), 2),
    ];
    for orbit in &orbits {
        let found = check_orbit(orbit, &LyapunovOptions::default());
        assert_eq!(found.verdict, Attraction::Periodic);
        assert!((found.sum - found.expected_sum).abs() < 1e-8, "{found:?}");
        assert_eq!(found.n_landings, 0);
        assert_eq!(found.history.shape(), (20, 2 * orbit.scene().n_dof()));
    }
}

#[test]
fn chaos_has_the_exponents_of_the_table() {
    // Theory 16: 0.1179(5), -0.3355(7), 0.2639 impacts per unit time.
    let (scene, rest) = (oscillator(5.0), dvector![0.0]);
    let options = LyapunovOptions {
        skip: 1000.0,
        ..LyapunovOptions::default()
    };
    let found = exponents(&scene, (&rest, &rest), 21_000.0, &options);
    assert_eq!(found.verdict, Attraction::Chaotic);
    for (k, (expected, error)) in [(0.1179, 0.0005), (-0.3355, 0.0007)]
        .into_iter()
        .enumerate()
    {
        let apart = (found.exponents[k] - expected).abs();
        assert!(apart < 3.0 * found.errors[k].hypot(error), "{found:?}");
    }
    assert!((found.n_impacts as f64 / 20_000.0 - 0.2639).abs() < 0.01);
    assert!((found.sum - found.expected_sum).abs() < 1e-9, "{found:?}");
    assert_eq!(found.history.nrows(), 20);
}

/// A linear scene of two coupled masses, the first pressed onto its stop by a force that swings.
fn pressed(restitution: f64) -> Scene {
    let system = LinearSystem::new(
        dmatrix![1.0, 0.3; 0.3, 0.8],
        dmatrix![0.2, -0.1; -0.1, 0.3],
        dmatrix![2.0, -1.0; -1.0, 1.5],
    );
    let force = Harmonic::new(dvector![9.0.into(), 1.0.into()], 0.8, 0.4).expect("valid");
    let stop = Stop::new(0, -0.5, restitution).expect("valid");
    Scene::new(system.expect("valid"), force, [stop]).expect("valid")
}

/// What a scene settles on from rest, as an orbit.
fn settled(scene: &Scene, periods: f64, n_periods: usize) -> PeriodicOrbit {
    let rest = DVector::zeros(scene.n_dof());
    let q = DVector::from_element(scene.n_dof(), -2.0);
    let span = (0.0, periods * scene.period().expect("forced"));
    let run = simulate(scene, &q, &rest, span, &SimulateOptions::default()).expect("a run");
    find_orbit(scene, &run, Some(n_periods)).expect("an orbit")
}

#[test]
fn each_stop_that_holds_takes_two_directions() {
    for restitution in [0.0, 0.3, 0.5] {
        let orbit = settled(&pressed(restitution), 200.0, 1);
        let found = check_orbit_that_sticks(&orbit);
        assert_eq!(found.exponents[2..], [f64::NEG_INFINITY; 2], "{found:?}");
        assert!(
            found.n_landings >= 399 && found.n_landings <= 401,
            "{found:?}"
        );
        assert_eq!(found.verdict, Attraction::Periodic);
        assert!(found.expected_sum.is_nan());
        assert_eq!(found.errors[2..], [0.0; 2]);
    }
}

/// As `check_orbit` of one whose multipliers are zero in part.
fn check_orbit_that_sticks(orbit: &PeriodicOrbit) -> LyapunovExponents {
    let period = orbit.period();
    // Begun and ended in the middle of what is free, by the phase of the first release.
    let options = LyapunovOptions {
        skip: 40.0 * period,
        ..LyapunovOptions::default()
    };
    let (q, v) = orbit
        .state(0.7 * period, ImpactSide::After)
        .expect("a time");
    let scene = orbit
        .scene()
        .replace(Parameter::Phase.change(orbit.phase() + 0.7 * TAU));
    let found = exponents(&scene.expect("valid"), (&q, &v), 440.0 * period, &options);
    let all = of_multipliers(orbit);
    let sums: [f64; 2] = [
        found.exponents.iter().filter(|la| la.is_finite()).sum(),
        all.iter().filter(|la| **la > -20.0 / period).sum(),
    ];
    assert!((sums[0] - sums[1]).abs() < 1e-6, "{found:?} {all:?}");
    found
}

#[test]
fn one_degree_forgets_everything_at_a_landing() {
    // Theory 16: sticks once in some thousand periods.
    let (scene, rest) = (oscillator(6.0), dvector![0.0]);
    let found = exponents(
        &scene,
        (&rest, &rest),
        20_000.0,
        &LyapunovOptions::default(),
    );
    assert!(found.n_landings > 0, "{found:?}");
    assert_eq!(found.exponents, [f64::NEG_INFINITY; 2]);
    assert_eq!(found.verdict, Attraction::Periodic);
}

#[test]
fn steps_have_the_exponents_of_exact_flights() {
    let (scene, rest) = (oscillator(9.0), dvector![0.0]);
    let of = |method: Method| {
        let options = LyapunovOptions {
            solver: method.into(),
            skip: 300.3,
            ..LyapunovOptions::default()
        };
        exponents(&scene, (&rest, &rest), 600.3, &options)
    };
    let exact = of(Method::Exact);
    for method in [Method::Dop853, Method::Rk45, Method::Radau] {
        let found = of(method);
        assert_eq!(found.n_impacts, exact.n_impacts);
        for (a, b) in found.exponents.iter().zip(&exact.exponents) {
            assert!((a - b).abs() < 1e-6, "{found:?} {exact:?}");
        }
        assert!((found.sum - found.expected_sum).abs() < 1e-7, "{found:?}");
    }
}

#[test]
fn a_pendulum_between_walls_has_the_exponents_of_its_multipliers() {
    let options = PaperOptions {
        damping: Some(0.06),
        linear: false,
        ..PaperOptions::default()
    };
    let scene = paper_scene(Kind::Three, &options).expect("valid");
    let linear = PaperOptions {
        linear: true,
        ..options
    };
    let linear = paper_scene(Kind::Three, &linear).expect("valid");
    let guess = stable(&linear, &Pattern::single(1), 2);
    let orbit = find_orbit(&scene, &guess, None).expect("an orbit");
    let (skip, end) = (60.5 * orbit.period(), 260.5 * orbit.period());
    let options = LyapunovOptions {
        skip,
        ..LyapunovOptions::default()
    };
    let found = exponents(orbit.scene(), (&orbit.q0(), &orbit.v0()), end, &options);
    let all = of_multipliers(&orbit);
    let sums: [f64; 2] = [found.exponents.iter().sum(), all.iter().sum()];
    assert!((sums[0] - sums[1]).abs() < 1e-6, "{sums:?}");
    assert!(
        (found.exponents[0] - all[0]).abs() < 1e-6,
        "{found:?} {all:?}"
    );
    // Fewer are the first of all.
    let options = LyapunovOptions {
        n_exponents: Some(1),
        ..options
    };
    let one = exponents(orbit.scene(), (&orbit.q0(), &orbit.v0()), end, &options);
    assert!((one.exponents[0] - found.exponents[0]).abs() < 1e-9);
    assert!(one.sum.is_nan() && one.exponents.len() == 1);
}

#[test]
fn a_stop_that_moves_has_the_exponents_of_its_multipliers() {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let shaken = Harmonic::new(dvector![1.0.into()], 2.4, 0.3).expect("valid");
    let stop = Stop::new(0, 1.0, 0.8).expect("valid");
    let stop = stop.with_motion(Some(StopMotion::harmonic(shaken).expect("valid")));
    let force = Harmonic::new(dvector![9.0.into()], 2.4, 0.0).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let orbit = settled(&scene, 400.0, 1);
    let found = check_orbit(&orbit, &LyapunovOptions::default());
    assert!((found.sum - found.expected_sum).abs() < 1e-8, "{found:?}");
}

#[test]
fn stops_hit_together_have_exponents_where_their_order_is_none() {
    // Two oscillators that do not know of each other, in step.
    let apart = |mass: nalgebra::DMatrix<f64>, coupling: f64| {
        let stiffness = dmatrix![1.0 + coupling, -coupling; -coupling, 1.0 + coupling];
        let system = LinearSystem::new(mass, 0.1 * &stiffness, stiffness).expect("valid");
        let force = Harmonic::new(dvector![9.0.into(), 9.0.into()], 2.4, 0.0).expect("valid");
        let stop = |dof| Stop::new(dof, 1.0, 0.8).expect("valid");
        Scene::new(system, force, [stop(0), stop(1)]).expect("valid")
    };
    let rest = dvector![0.0, 0.0];
    let options = LyapunovOptions {
        skip: 300.3,
        ..LyapunovOptions::default()
    };
    let found = exponents(
        &apart(dmatrix![1.0, 0.0; 0.0, 1.0], 0.0),
        (&rest, &rest),
        2300.3,
        &options,
    );
    let (one, rest_of_one) = (oscillator(9.0), dvector![0.0]);
    let single = exponents(&one, (&rest_of_one, &rest_of_one), 2300.3, &options);
    assert_eq!(found.n_clashes, 0);
    assert_eq!(found.n_impacts, 2 * single.n_impacts);
    for k in 0..4 {
        assert!(
            (found.exponents[k] - single.exponents[k / 2]).abs() < 1e-3,
            "{found:?} {single:?}"
        );
    }
    assert!((found.sum - 2.0 * single.sum).abs() < 1e-9);
    assert_eq!(found.verdict, Attraction::Periodic);
    // Springs between them: the order matters by what one does to the other's acceleration; inertia: by its speed.
    for scene in [
        apart(dmatrix![1.0, 0.0; 0.0, 1.0], 0.2),
        apart(dmatrix![1.0, 0.2; 0.2, 1.0], 0.0),
    ] {
        let found = exponents(&scene, (&rest, &rest), 600.3, &options);
        assert!(found.n_impacts > 0 && found.n_clashes > 0);
        assert_eq!(found.verdict, Attraction::Undecided);
    }
}

#[test]
fn smooth_motions_have_exponents_too() {
    // A free flight of 5000 periods: those of its roots.
    let system = LinearSystem::from_modes(&dvector![1.0, 30.0], &dvector![0.02, 2.0]);
    let none: [Stop; 0] = [];
    let force = Harmonic::new(dvector![1.0.into(), 1.0.into()], 2.4, 0.0).expect("valid");
    let scene = Scene::new(system.expect("valid"), force, none).expect("valid");
    let start = (&dvector![1.0, 0.0], &dvector![0.0, 0.0]);
    let options = LyapunovOptions {
        skip: 100.0,
        ..LyapunovOptions::default()
    };
    let found = exponents(&scene, start, 3000.0, &options);
    // Roots: -0.02 twice, and -30 (2 -+ sqrt 3).
    let root = 3f64.sqrt();
    let expected = [-0.02, -0.02, -30.0 * (2.0 - root), -30.0 * (2.0 + root)];
    for (la, expected) in found.exponents.iter().zip(expected) {
        assert!((la - expected).abs() < 1e-3, "{found:?}");
    }
    assert!((found.sum - found.expected_sum).abs() < 1e-8, "{found:?}");
    assert_eq!(found.verdict, Attraction::Periodic);
}

/// `x'' + c x' + k x = F cos w t + p` before a stop at d.
fn mass(
    (damping, stiffness): (f64, f64),
    (force, frequency, load): (f64, f64, f64),
    (clearance, restitution): (f64, f64),
) -> Scene {
    let system =
        LinearSystem::new(dvector![1.0], dmatrix![damping], dmatrix![stiffness]).expect("valid");
    let system = system.with_load(dvector![load]).expect("valid");
    let force = Harmonic::new(dvector![force.into()], frequency, 0.0).expect("valid");
    let stop = Stop::new(0, clearance, restitution).expect("valid");
    Scene::new(system, force, [stop]).expect("valid")
}

#[test]
fn a_start_in_contact_has_no_direction_left() {
    let none = f64::NEG_INFINITY;
    let pressed = mass((0.5, 4.0), (1.0, 2.4, 5.0), (1.0, 0.5));
    let still = mass((0.5, 4.0), (1.0, 2.4, 1.1), (0.0, 0.5));
    for (scene, q) in [(&pressed, 1.0), (&still, 0.0)] {
        let found = exponents(
            scene,
            (&dvector![q], &dvector![0.0]),
            60.0,
            &LyapunovOptions::default(),
        );
        assert_eq!(found.exponents, [none, none]);
        assert_eq!(found.verdict, Attraction::Periodic);
    }
    // Of two masses the other one keeps its own, whether counting begins before the contact or in it.
    let system = LinearSystem::new(
        dvector![1.0, 1.0],
        dmatrix![0.1, 0.0; 0.0, 0.1],
        dmatrix![2.0, -1.0; -1.0, 2.0],
    );
    let system = system
        .and_then(|system| system.with_load(dvector![4.0, 0.0]))
        .expect("valid");
    let force = Harmonic::new(dvector![0.1.into(), 0.0.into()], 1.0, 0.0).expect("valid");
    let scene = Scene::new(system, force, [Stop::new(0, 0.5, 0.3).expect("valid")]).expect("valid");
    for (method, skip) in [
        (Method::Exact, 0.0),
        (Method::Exact, 50.0),
        (Method::Dop853, 50.0),
    ] {
        let options = LyapunovOptions {
            solver: method.into(),
            skip,
            ..LyapunovOptions::default()
        };
        let found = exponents(
            &scene,
            (&dvector![0.0, 0.0], &dvector![0.0, 0.0]),
            400.0,
            &options,
        );
        assert_eq!(found.exponents[2..], [none, none]);
        // The other mass on its springs: deviations die out as `e^{-0.05 t}`.
        for rate in &found.exponents[..2] {
            assert!((rate + 0.05).abs() < 0.01, "{rate}");
        }
    }
}

#[test]
fn a_start_with_an_impact_goes_on_behind_it() {
    for (scene, q, v) in [
        (mass((0.1, 1.0), (9.0, 2.4, 0.0), (1.0, 0.8)), 1.0, 1.0),
        (mass((0.5, 4.0), (1.0, 0.7, 0.0), (0.0, 0.5)), 0.0, 0.5),
    ] {
        for method in [Method::Exact, Method::Dop853] {
            let options = LyapunovOptions {
                solver: method.into(),
                ..LyapunovOptions::default()
            };
            let found = exponents(&scene, (&dvector![q], &dvector![v]), 300.0, &options);
            assert!(
                found.exponents.iter().all(|rate| !rate.is_nan()),
                "{found:?}"
            );
            if found.n_landings == 0 {
                assert!((found.sum - found.expected_sum).abs() < 1e-8, "{found:?}");
            }
        }
    }
}

#[test]
fn hardly_any_restitution_leaves_the_sum_of_its_law() {
    for restitution in [1e-3, 1e-6, 1e-8, 1e-12, 1e-100, 1e-200] {
        let scene = mass((0.5, 4.0), (3.0, 2.4, 0.0), (1.0, restitution));
        let end = 60.0 * scene.period().expect("forced");
        let found = exponents(
            &scene,
            (&dvector![0.0], &dvector![0.157]),
            end,
            &LyapunovOptions::default(),
        );
        assert!(found.n_landings == 0 && found.n_impacts > 20);
        let off = (found.sum - found.expected_sum).abs();
        assert!(
            off <= 1e-9 * found.expected_sum.abs(),
            "e = {restitution}: {} {}",
            found.sum,
            found.expected_sum
        );
    }
}

#[test]
fn tones_without_a_common_period_and_without_impacts_make_a_torus() {
    let tone = |w: f64| Forcing::from(Harmonic::new(dvector![0.1.into()], w, 0.0).expect("valid"));
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.2], dmatrix![1.0]).expect("valid");
    let none: [Stop; 0] = [];
    let scene = Scene::new(
        system,
        Forcing::Several(vec![tone(0.8), tone(0.8 * PI)]),
        none,
    )
    .expect("valid");
    let options = LyapunovOptions::default();
    let found = lyapunov_exponents(
        &scene,
        &dvector![0.0],
        &dvector![0.0],
        (0.0, 3000.0),
        &options,
    )
    .expect("exponents");
    assert!(found.exponents.iter().all(|rate| (rate + 0.1).abs() < 1e-3));
    assert!(found.history.nrows() >= 2 && found.errors.iter().all(|error| *error < 0.01));
    assert_eq!(found.verdict, Attraction::Torus);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let (scene, rest) = (oscillator(9.0), dvector![0.0]);
    let refused = |options: LyapunovOptions| {
        let found = lyapunov_exponents(&scene, &rest, &rest, (0.0, 10.0), &options);
        found.expect_err("refused").to_string()
    };
    let usual = LyapunovOptions::default;
    for skip in [-1.0, 10.0, f64::NAN] {
        let message = refused(LyapunovOptions { skip, ..usual() });
        assert!(message.contains("skip"), "{message}");
    }
    for n_exponents in [Some(0), Some(3)] {
        let message = refused(LyapunovOptions {
            n_exponents,
            ..usual()
        });
        assert!(message.contains("at most 2"), "{message}");
    }
}

#[test]
fn a_run_that_ends_before_time_counts_has_no_exponents() {
    // Two stops that move into each other: the mass is jammed between them.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![0.3.into()], 1.0, 0.0).expect("valid");
    let shaken = Harmonic::new(dvector![0.9.into()], 1.0, 0.0).expect("valid");
    let moving = StopMotion::harmonic(shaken).expect("valid");
    let lower = Stop::new(0, 0.2, 0.8).expect("valid").on_side(Side::Lower);
    let stops = [
        Stop::new(0, 0.5, 0.8).expect("valid"),
        lower.with_motion(Some(moving)),
    ];
    let scene = Scene::new(system, force, stops).expect("valid");
    let (q, v) = (dvector![0.0], dvector![0.1]);
    let run = simulate(&scene, &q, &v, (0.0, 400.0), &SimulateOptions::default()).expect("a run");
    assert!(run.status() != Status::Finished && run.t_end() < 100.0);
    for part in [0.0, 0.5, 1.0, 2.0, 10.0] {
        let options = LyapunovOptions {
            skip: part * run.t_end(),
            ..LyapunovOptions::default()
        };
        let found = exponents(&scene, (&q, &v), 400.0, &options);
        assert_eq!(
            (found.verdict, found.status),
            (Attraction::Undecided, run.status())
        );
        assert!(found.message.contains("ends"), "{}", found.message);
        let are_none = found.exponents.iter().all(|la| la.is_nan());
        assert_eq!(are_none, part >= 1.0, "{found:?}");
        assert!(!are_none || (found.sum.is_nan() && found.n_impacts == 0));
    }
}

//! `find_orbit` through chatter and lasting contact: against closed forms and against the simulated return map.

use crate::scenes::{harmonic, linear, loaded, lower, scene, shaken_ball};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    BaseMotion, DoublePendulum, Error, Harmonic, ImpactSide, Keep, Motion, Parameter,
    PeriodicOrbit, Reaction, Scene, SegmentKind, SimulateOptions, Solver, Trajectory, Wall,
    WallSide, find_orbit, nalgebra, simulate,
};

/// Two masses, the first above a floor and shaken, coupled by inertia and by a spring.
fn pair(restitution: f64, reaction: Reaction, frequency: f64, damping: f64) -> Scene {
    let c = damping;
    let system = loaded(
        linear(
            dmatrix![1.0, 0.3; 0.3, 1.0],
            dmatrix![c, -c; -c, 2.0 * c],
            dmatrix![1.0, -1.0; -1.0, 3.0],
        ),
        &[-1.5, 0.0],
    );
    let floor = lower(0, 0.0, restitution)
        .with_reaction(reaction)
        .expect("valid");
    scene(system, harmonic(&[2.75, 0.0], frequency, 0.0), [floor])
}

/// A double pendulum that slow motion of its base presses against a wall.
fn pendulum(restitution: f64) -> Scene {
    let system = DoublePendulum::new(1.0, 1.0, (0.2, 0.1)).expect("valid");
    let wall = Wall::new(1, -0.1, restitution, WallSide::Right).expect("valid");
    let base = BaseMotion::new(0.4, 0.4, 0.0).expect("valid");
    scene(system, base, [wall])
}

/// A run long enough to settle.
fn settled(scene: &Scene, q0: DVector<f64>, periods: f64) -> Trajectory {
    let v0 = DVector::zeros(q0.len());
    let span = (0.0, periods * scene.period().expect("forced"));
    let run = simulate(scene, &q0, &v0, span, &SimulateOptions::default()).expect("runs");
    assert!(
        run.segments()
            .expect("kept")
            .iter()
            .any(|s| s.kind == SegmentKind::Stick)
    );
    run
}

/// The only stretch of lasting contact.
fn stick(orbit: &PeriodicOrbit) -> (f64, f64) {
    let segments = orbit.segments().expect("linear");
    let mut held = segments.iter().filter(|s| s.kind == SegmentKind::Stick);
    let held = (held.next().expect("held"), held.next());
    assert!(held.1.is_none());
    (held.0.start, held.0.end)
}

/// The zero of a function that falls through it.
fn falling_root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    assert!(f(low) > 0.0 && f(high) < 0.0);
    for _ in 0..200 {
        let mid = 0.5 * (low + high);
        if f(mid) > 0.0 { low = mid } else { high = mid }
    }
    0.5 * (low + high)
}

#[test]
fn the_ball_on_a_table_has_its_closed_form() {
    for (e, a) in [(0.0, 1.3), (0.5, 1.3), (0.5, 1.1), (0.8, 1.1)] {
        let scene = shaken_ball(e, a, 0.0);
        let orbit = find_orbit(&scene, &settled(&scene, dvector![0.3], 12.0), None).expect("found");
        // Free motion from an angle with a speed: height and speed at another angle.
        let height = |from: f64, speed: f64, to: f64| {
            let s = to - from;
            (speed - a * from.sin()) * s - a * (to.cos() - from.cos()) - 0.5 * s * s
        };
        let speed_at =
            |from: f64, speed: f64, to: f64| speed + a * (to.sin() - from.sin()) - (to - from);
        // The table's acceleration is -g: let go where a cos = 1 on its way up.
        let release = -(1.0 / a).acos();
        let landing = falling_root(|to| height(release, 0.0, to), release + 1e-3, release + TAU);
        let approach = -speed_at(release, 0.0, landing);
        assert!(
            (orbit.phase() - landing.rem_euclid(TAU)).abs() < 1e-11,
            "{e} {a}"
        );
        assert!((orbit.impacts()[0].approach - approach).abs() < 1e-11);
        assert!(orbit.q0().amax() < 1e-14);
        assert!((orbit.v0()[0] - e * approach).abs() < 1e-11);
        // Bounce by bounce to where they end; what is left below 1e-7 ends by the geometric series.
        let (mut from, mut up) = (landing, e * approach);
        while up > 1e-7 {
            let pull = 1.0 - a * from.cos();
            let guess = 2.0 * up / pull;
            let next = falling_root(
                |to| height(from, up, to),
                from + 0.5 * guess,
                from + 2.0 * guess,
            );
            (from, up) = (next, -e * speed_at(from, up, next));
        }
        let end = from + 2.0 * up / (1.0 - e) / (1.0 - a * from.cos());
        let (start, let_go) = stick(&orbit);
        assert!(
            (start - (end - landing)).abs() < 1e-8,
            "{e} {a} {start} {}",
            end - landing
        );
        assert!((let_go - (release + TAU - landing)).abs() < 1e-11);
        assert!(
            orbit.is_admissible() == Some(true),
            "{e} {a} {:?}",
            orbit.violation()
        );
        assert!(orbit.touches().is_empty(), "{e} {a} {:?}", orbit.touches());
        let stability = orbit.stability().expect("computed");
        assert_eq!(stability.is_stable, Some(true));
        assert!(
            stability.orders[0]
                .multipliers
                .iter()
                .all(|z| z.norm() < 1e-12)
        );
    }
}

/// The state after one period, from a time.
fn returned(orbit: &PeriodicOrbit, start: f64, x: &DVector<f64>) -> DVector<f64> {
    let n = x.len() / 2;
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-15),
            ..Solver::default()
        },
        keep: Keep::Final,
        ..Default::default()
    };
    let (q, v) = (x.rows(0, n).into_owned(), x.rows(n, n).into_owned());
    let span = (start, start + orbit.period());
    let run = simulate(orbit.scene(), &q, &v, span, &options).expect("runs");
    let (q, v) = run.last();
    DVector::from_iterator(2 * n, q.iter().chain(v.iter()).copied())
}

/// How far the simulator is from closing in the middle of the longest flight, relative to the motion; and the moduli of the
/// multipliers of its return map there, by central differences.
fn return_map(orbit: &PeriodicOrbit) -> (f64, Vec<f64>) {
    let segments = orbit.segments().expect("linear");
    let flights = segments.iter().filter(|s| s.kind == SegmentKind::Flight);
    let longest = flights
        .max_by(|a, b| (a.end - a.start).total_cmp(&(b.end - b.start)))
        .expect("a flight");
    let middle = 0.5 * (longest.start + longest.end);
    let (q, v) = orbit.state(middle, ImpactSide::After).expect("a time");
    let n = q.len();
    let x = DVector::from_iterator(2 * n, q.iter().chain(v.iter()).copied());
    let open = (returned(orbit, middle, &x) - &x).amax() / x.amax();
    let step = 1e-4;
    let mut jacobian = DMatrix::zeros(2 * n, 2 * n);
    for j in 0..2 * n {
        let moved = |by: f64| {
            let mut y = x.clone();
            y[j] += by;
            returned(orbit, middle, &y)
        };
        jacobian.set_column(j, &((moved(step) - moved(-step)) / (2.0 * step)));
    }
    let mut moduli: Vec<f64> = jacobian
        .complex_eigenvalues()
        .iter()
        .map(|z| z.norm())
        .collect();
    moduli.sort_by(|a, b| b.total_cmp(a));
    (open, moduli)
}

/// Closure, retracing, admissibility and multipliers of an orbit in whose period one stop is held once.
fn keeps_the_laws(orbit: &PeriodicOrbit, label: &str) {
    assert!(
        orbit.is_admissible() == Some(true),
        "{label}: {:?}",
        orbit.violation()
    );
    let (open, moduli) = return_map(orbit);
    assert!(open < 1e-11, "{label}: {open:e}");
    let multipliers = &orbit.stability().expect("computed").orders[0].multipliers;
    for (ours, theirs) in multipliers.iter().zip(&moduli) {
        assert!(
            (ours.norm() - theirs).abs() < 1e-6,
            "{label}: {multipliers} {moduli:?}"
        );
    }
    let n_zero = multipliers.iter().filter(|z| z.norm() < 1e-9).count();
    assert_eq!(n_zero, 2, "{label}: {multipliers}");
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-15),
            ..Solver::default()
        },
        ..Default::default()
    };
    let span = (0.0, 2.0 * orbit.period());
    let run = simulate(orbit.scene(), &orbit.q0(), &orbit.v0(), span, &options).expect("runs");
    for k in 0..300 {
        let t = f64::from(k) / 300.0 * span.1;
        let q = run
            .state(t, vibroimpact::ImpactSide::After)
            .expect("kept")
            .0;
        assert!(
            (q - orbit.state(t, ImpactSide::After).expect("a time").0).amax() < 2e-11,
            "{label} at {t}"
        );
    }
}

#[test]
fn linear_orbits_agree_with_the_simulated_return_map() {
    let aside = || Reaction::Direction(dvector![1.0, 0.4]);
    for (e, reaction, frequency, damping) in [
        (0.5, Reaction::Inertia, 0.5, 0.1),
        (0.5, aside(), 0.5, 0.1),
        (0.7, Reaction::Coordinate, 0.5, 0.1),
        (0.0, Reaction::Inertia, 0.5, 0.02),
        (0.0, aside(), 0.5, 0.1),
    ] {
        let scene = pair(e, reaction.clone(), frequency, damping);
        let run = settled(&scene, dvector![0.3, 0.1], 80.0);
        let orbit = find_orbit(&scene, &run, None).expect("found");
        assert_eq!(orbit.n_periods(), 1);
        keeps_the_laws(&orbit, &format!("e = {e}, {reaction:?}"));
    }
}

#[test]
fn nonlinear_orbits_agree_with_the_simulated_return_map() {
    for e in [0.5, 0.0] {
        let scene = pendulum(e);
        let run = settled(&scene, dvector![-0.2, -0.2], 12.0);
        let orbit = find_orbit(&scene, &run, None).expect("found");
        keeps_the_laws(&orbit, &format!("pendulum, e = {e}"));
    }
}

#[test]
fn an_orbit_is_followed_and_restored() {
    for e in [0.5, 0.0] {
        let scene = pair(e, Reaction::Inertia, 0.5, 0.1);
        let run = settled(&scene, dvector![0.3, 0.1], 80.0);
        let orbit = find_orbit(&scene, &run, None).expect("found");
        let near = scene
            .replace(Parameter::ForcingScale.change(1.02))
            .expect("valid");
        let followed = find_orbit(&near, &orbit, None).expect("followed");
        let run = settled(&near, dvector![0.3, 0.1], 80.0);
        let anew = find_orbit(&near, &run, None).expect("found");
        assert!((followed.q0() - anew.q0()).amax() < 1e-10);
        assert!((followed.v0() - anew.v0()).amax() < 1e-10);
        let twice = find_orbit(&near, &followed, Some(2)).expect("closed");
        assert_eq!(twice.impacts().len(), 2 * followed.impacts().len());
        let again = PeriodicOrbit::restore(
            followed.scene(),
            followed.pattern().clone(),
            followed.save(),
        )
        .expect("its own");
        assert_eq!(again.segments(), followed.segments());
        for k in 0..100 {
            let t = f64::from(k) * 0.01 * followed.period();
            assert_eq!(
                again.state(t, ImpactSide::After).expect("a time"),
                followed.state(t, ImpactSide::After).expect("a time")
            );
        }
    }
}

#[test]
fn a_stop_held_for_good_leaves_the_motion_of_the_rest() {
    // Shaken too weakly to lift off: the second mass answers the spring's pull of its own, at rest here.
    let scene = pair(0.5, Reaction::Inertia, 1.0, 0.1)
        .replace(Parameter::ForcingScale.change(0.2))
        .expect("valid");
    let run = settled(&scene, dvector![0.3, 0.1], 100.0);
    let orbit = find_orbit(&scene, &run, None).expect("found");
    assert!(orbit.is_admissible() == Some(true) && orbit.impacts().is_empty());
    assert!(
        orbit
            .state(1.0, ImpactSide::After)
            .expect("a time")
            .0
            .amax()
            < 1e-12
    );
    // y'' + 0.2 y' + 3 y = 0 over one period: |multiplier| = exp(-0.1 T).
    let multipliers = &orbit.stability().expect("computed").orders[0].multipliers;
    let wanted = (-0.1 * TAU).exp();
    assert!(
        (multipliers[0].norm() - wanted).abs() < 1e-12,
        "{multipliers}"
    );
    assert!(multipliers[2].norm() < 1e-12);

    let rest = find_orbit(
        &shaken_ball(0.5, 0.9, 0.0),
        &settled(&shaken_ball(0.5, 0.9, 0.0), dvector![0.3], 12.0),
        None,
    );
    let rest = rest.expect("at rest");
    assert!(rest.is_admissible() == Some(true));
    // Shaken harder it would have to be pulled down, by the most where the table falls fastest.
    let pulled = find_orbit(&shaken_ball(0.5, 1.3, 0.0), &rest, None).expect("closed");
    let violation = pulled.violation().expect("pulled");
    assert!(
        violation.reason.contains("pulling force"),
        "{}",
        violation.reason
    );
    let phase = (violation.time + pulled.phase()).rem_euclid(TAU);
    assert!(phase.min(TAU - phase) < 1e-6, "{phase}");
}

#[test]
fn rest_that_is_not_chatter_alone_is_refused() {
    // Two balls on one table: one bounces to rest while the other is held already.
    let system = loaded(
        linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![0.0, 0.0]),
        &[-1.0, -1.0],
    );
    let floor = |i: usize, e: f64| lower(i, 0.0, e);
    let force = dvector![1.3.into(), 1.3.into()];
    let forcing = Harmonic::new(force, 1.0, 0.0).expect("valid");
    let scene = scene(system, forcing, [floor(0, 0.3), floor(1, 0.6)]);
    let run = settled(&scene, dvector![0.3, 0.3], 12.0);
    let Err(Error::BadValue {
        argument, value, ..
    }) = find_orbit(&scene, &run, None)
    else {
        panic!("there is no Jacobian");
    };
    assert_eq!(argument, "guess");
    assert!(
        value.contains("comes to rest on stop 1") || value.contains("let go"),
        "{value}"
    );
}

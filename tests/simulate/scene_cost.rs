//! What a scene does not need is left out, and that is a number that is zero: `plan` says in words what will run,
//! `Trajectory::stats` counts what did run, and what is not asked for is not kept. The instructions that each part of a scene
//! costs are printed by `cargo bench --bench scene_cost`.

use crate::scenes::{BOTH, harmonic, linear, oscillator, scene, upper};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, Coefficient, DoublePendulum, Forcing, Harmonic, Keep, Method, Scene, Side,
    SimulateOptions, Stats, Stop, Trajectory, Wall, WallSide, plan, simulate,
};

fn pair(damping: DMatrix<f64>, forcing: Forcing, stops: Vec<Stop>) -> Scene {
    let (mass, stiffness) = (dmatrix![2.0, 0.5; 0.5, 1.0], dmatrix![5.0, -2.0; -2.0, 3.0]);
    let system = linear(mass, damping, stiffness);
    scene(system, forcing, stops)
}

/// Proportional damping.
fn modal(forcing: Forcing, stops: Vec<Stop>) -> Scene {
    pair(dmatrix![0.5, -0.2; -0.2, 0.3] * 0.1, forcing, stops)
}

fn force() -> Forcing {
    harmonic(&[1.0, 0.3], 0.9, 0.0)
}

fn stop() -> Stop {
    upper(0, 0.1, 0.7)
}

fn pendulum(stops: Vec<Wall>) -> Scene {
    let system = DoublePendulum::new(1.0, 2.0, (0.05, 0.02)).expect("valid");
    let base = BaseMotion::new(0.3, 1.2, 0.0).expect("valid");
    scene(system, base, stops)
}

fn run_with(scene: &Scene, options: &SimulateOptions) -> Trajectory {
    let n = scene.n_dof();
    let (q0, v0) = (DVector::zeros(n), DVector::from_element(n, 0.4));
    simulate(scene, &q0, &v0, (0.0, 30.0), options).expect("runs")
}

fn run(scene: &Scene) -> Stats {
    run_with(scene, &SimulateOptions::default()).stats()
}

/// The plan has all of some words and none of others.
fn assert_plan(scene: &Scene, named: &[&str], left_out: &[&str]) {
    let plan = plan(scene).expect("a plan");
    for word in named {
        assert!(plan.contains(word), "{word} is not in: {plan}");
    }
    for word in left_out {
        assert!(!plan.contains(word), "{word} is in: {plan}");
    }
}

#[test]
fn a_linear_system_takes_no_steps() {
    for scene in [
        modal(Forcing::Unforced, vec![stop()]),
        modal(force(), vec![stop()]),
        pair(dmatrix![0.3, 0.0; 0.0, 0.0], force(), vec![stop()]),
    ] {
        let stats = run(&scene);
        assert_eq!((stats.n_rhs, stats.n_steps), (0, 0));
        assert!(stats.n_impacts > 0 && stats.n_gap_evaluations > 0 && stats.n_flights > 1);
        assert_plan(&scene, &["closed-form flights"], &["Runge-Kutta"]);
    }
}

#[test]
fn proportional_damping_needs_real_modes_alone() {
    assert_plan(
        &modal(force(), vec![stop()]),
        &["real modes"],
        &["complex", "exponential"],
    );
    let coupled = pair(dmatrix![0.3, 0.0; 0.0, 0.0], force(), vec![stop()]);
    assert_plan(&coupled, &["complex modes"], &["real modes", "exponential"]);
    // Four equal oscillators, each driven by the one before: a defective state matrix.
    let ones = || Coefficient::Diagonal(DVector::from_element(4, 1.0));
    let chain = DMatrix::from_fn(4, 4, |i, j| match i.wrapping_sub(j) {
        0 => 1.0,
        1 => -1.0,
        _ => 0.0,
    });
    let defective = linear(ones(), ones().scaled(0.1), chain);
    let force = Harmonic::new(DVector::from_element(4, 1.0.into()), 0.9, 0.0).expect("valid");
    let scene = scene(defective, force, [stop()]);
    assert_plan(
        &scene,
        &["matrix exponential", "enlarged"],
        &["real modes", "complex modes"],
    );
    assert!(run(&scene).n_impacts > 0);
}

#[test]
fn without_forcing_the_response_is_free() {
    let free = modal(Forcing::Unforced, vec![stop()]);
    assert_plan(
        &free,
        &["no forcing: free response"],
        &["harmonic", "steady", "resonance"],
    );
    assert_plan(
        &modal(force(), vec![stop()]),
        &["harmonic forcing", "steady response split off"],
        &["no forcing", "resonance"],
    );
    // An oscillator driven at its own frequency has no steady response to split off.
    let resonant = oscillator(0.0, harmonic(&[0.1], 1.0, 0.0), [stop()]);
    assert_plan(
        &resonant,
        &["harmonic forcing", "near resonance"],
        &["steady response"],
    );
}

#[test]
fn without_stops_there_is_one_flight_and_no_search() {
    let scene = modal(force(), vec![]);
    let none = Stats {
        n_flights: 1,
        ..Stats::default()
    };
    assert_eq!(run(&scene), none);
    assert_plan(
        &scene,
        &["no stops: one flight to the end, no event search"],
        &["impact"],
    );
    let scene = pendulum(vec![]);
    let stats = run(&scene);
    assert_eq!(
        (stats.n_gap_evaluations, stats.n_flights, stats.n_impacts),
        (0, 1, 0)
    );
    assert!(stats.n_rhs > 0 && stats.n_steps > 0);
    assert_plan(&scene, &["no stops: no event search"], &["contact"]);
}

#[test]
fn a_nonlinear_system_takes_steps_and_no_modes() {
    let wall = Wall::new(1, 0.1, 0.7, WallSide::Right).expect("valid");
    let scene = pendulum(vec![wall]);
    for method in [Method::Auto, Method::Rk45] {
        let options = SimulateOptions {
            solver: method.into(),
            ..Default::default()
        };
        let stats = run_with(&scene, &options).stats();
        assert!(stats.n_rhs >= stats.n_steps && stats.n_steps > stats.n_impacts);
        assert!(stats.n_impacts > 0 && stats.n_gap_evaluations > 0);
    }
    assert_plan(
        &scene,
        &["no modes", "1 stop", "on the series"],
        &["closed-form", "real modes"],
    );
}

#[test]
fn stops_that_are_coupled_are_said_to_be() {
    let two = modal(force(), vec![stop(), stop().on_side(Side::Lower)]);
    assert_plan(&two, &["2 stops", "complementarity"], &["each by itself"]);
    let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![1.0, 2.0]);
    let stops = [stop(), upper(1, 0.1, 0.7)];
    let apart = scene(system, force(), stops);
    assert_plan(&apart, &["2 stops", "each by itself"], &["complementarity"]);
}

#[test]
fn what_is_not_asked_for_is_not_kept() {
    let wall = Wall::new(1, 0.1, 0.7, WallSide::Right).expect("valid");
    for scene in [modal(force(), vec![stop()]), pendulum(vec![wall])] {
        let whole = run_with(&scene, &SimulateOptions::default());
        assert!(whole.save().motion.is_some());
        for keep in [Keep::Impacts, Keep::Final] {
            for t_eval in [None, Some(vec![]), Some(vec![1.0, 30.0])] {
                let asked = t_eval.as_ref().map(Vec::len);
                let options = SimulateOptions {
                    keep,
                    t_eval,
                    ..Default::default()
                };
                let saved = run_with(&scene, &options).save();
                assert!(saved.motion.is_none());
                assert_eq!(saved.samples.map(|(t, ..)| t.len()), asked);
                assert_eq!(saved.stats, whole.save().stats);
                let count = if keep == Keep::Final {
                    0
                } else {
                    whole.impacts().len()
                };
                assert_eq!(saved.impacts.len(), count);
            }
        }
    }
}

/// Without damping none of it is read; damping too small to change a number leaves the same bits.
#[test]
fn no_damping_is_damping_of_no_size() {
    const LEAST: f64 = 1e-300;
    let end = |scene: &Scene, method: Method| {
        let options = SimulateOptions {
            solver: method.into(),
            ..Default::default()
        };
        let run = run_with(scene, &options);
        (run.last().0.clone(), run.last().1.clone(), run.stats())
    };
    // Proportional: complex modes would round in another way.
    let full = |size: f64| pair(dmatrix![5.0, -2.0; -2.0, 3.0] * size, force(), vec![stop()]);
    let diagonal = |size: f64| {
        let (mass, stiffness) = (dvector![2.0, 0.3], dvector![5.0, 1.1]);
        let system = linear(mass, dvector![size, size], stiffness);
        scene(system, force(), [stop()])
    };
    let pendulum = |size: f64| {
        let system = DoublePendulum::new(1.0, 2.0, (size, size)).expect("valid");
        let wall = Wall::new(1, 0.1, 0.7, WallSide::Right).expect("valid");
        scene(system, force(), [wall])
    };
    let linear_scenes: [&dyn Fn(f64) -> Scene; 2] = [&full, &diagonal];
    for scene in linear_scenes {
        for method in BOTH {
            let (without, with) = (end(&scene(0.0), method), end(&scene(LEAST), method));
            assert!(without.2.n_impacts > 0);
            assert_eq!(without, with);
        }
    }
    for method in [Method::Taylor, Method::Rk45] {
        let (without, with) = (end(&pendulum(0.0), method), end(&pendulum(LEAST), method));
        assert!(without.2.n_impacts > 0);
        assert_eq!(without, with);
    }
}

#[test]
fn ten_thousand_diagonal_modes_are_stepped_one_by_one() {
    const N: usize = 10_000;
    let frequency = |i: usize| 1.0 + i as f64 / N as f64;
    let ones = DVector::from_element(N, 1.0);
    let damping = DVector::from_fn(N, |i, _| 0.02 * frequency(i));
    let stiffness = DVector::from_fn(N, |i, _| frequency(i).powi(2));
    let system = linear(ones, damping, stiffness);
    let normal = DVector::from_element(N, 1.0 / (N as f64).sqrt());
    let force = harmonic((&normal * 0.2).as_slice(), 0.7, 0.0);
    let scene = scene(system, force, [upper(normal, 0.3, 0.6)]);
    let (q0, v0) = (DVector::zeros(N), DVector::from_element(N, 0.005));
    let run = |method: Method| {
        let options = SimulateOptions {
            solver: method.into(),
            keep: Keep::Impacts,
            ..Default::default()
        };
        simulate(&scene, &q0, &v0, (0.0, 4.0), &options).expect("runs")
    };
    // Full matrices would take 1600 MB, and 1e8 products in each of six stages of a step.
    let start = std::time::Instant::now();
    let (steps, exact) = (run(Method::Rk45), run(Method::Exact));
    assert!(
        start.elapsed().as_secs_f64() < 20.0,
        "{:?}",
        start.elapsed()
    );
    assert!(steps.stats().n_steps > 10 && !exact.impacts().is_empty());
    assert_eq!(steps.impacts().len(), exact.impacts().len());
    assert!((steps.last().0 - exact.last().0).norm() < 1e-7);
    assert!((steps.last().1 - exact.last().1).norm() < 1e-7);
}

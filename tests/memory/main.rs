//! What a run keeps is what it was asked to keep: with `Keep::Final` the peak of live bytes does not depend on the number of
//! impacts, with `Keep::Impacts` it grows by the impacts alone, and an ensemble needs a row for each trajectory.
//!
//! A soak run of ten million impacts, which prints its peaks:
//! `SOAK_IMPACTS=10000000 cargo test --release --test memory -- --nocapture`.

mod counting;

use counting::peak_of;
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, DoublePendulum, Harmonic, Impact, Keep, Kind, LinearSystem, Method, Motion,
    PaperOptions, Scene, SimulateOptions, Solver, Stop, SweepOptions, Trajectory, Wall, WallSide,
    paper_scene, simulate, simulate_many,
};

/// A run goes on until its impacts are there.
const LONG: f64 = 1e9;
/// The texts of two runs, which have their counts in them, differ by no more.
const TEXT: usize = 64;
/// The arcs of a contact that lasts, of one coordinate: one by exact flights, some steps otherwise.
const CONTACT: usize = 512;

/// A scene in which impacts go on for ever, its start and the method that moves it.
struct Case {
    name: &'static str,
    scene: Scene,
    start: (DVector<f64>, DVector<f64>),
    method: Method,
    n_impacts: usize,
}

/// A forced oscillator, soft enough at its stop to chatter and to stay on it in every period.
fn resting() -> Scene {
    let system = LinearSystem::new(dmatrix![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.3, 0.0).expect("valid");
    Scene::new(system, force, [Stop::new(0, 0.1, 0.6).expect("valid")]).expect("valid")
}

fn walled() -> Scene {
    let pendulum = DoublePendulum::new(1.0, 2.0, (0.05, 0.02)).expect("valid");
    let base = BaseMotion::new(0.3, 1.2, 0.0).expect("valid");
    let wall = Wall::new(1, 0.1, 0.7, WallSide::Right).expect("valid");
    Scene::new(pendulum, base, [wall]).expect("valid")
}

fn cases() -> Vec<Case> {
    let linear = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let case = |name, scene: &Scene, q: &[f64], v: &[f64], method, n_impacts| Case {
        name,
        scene: scene.clone(),
        start: (DVector::from_column_slice(q), DVector::from_column_slice(v)),
        method,
        n_impacts,
    };
    let (q, v) = ([0.02, -0.1], [0.0, 0.3]);
    vec![
        case("exact", &linear, &q, &v, Method::Exact, 10_000),
        case("rk45, linear", &linear, &q, &v, Method::Rk45, 10_000),
        case(
            "rk45, walled pendulum",
            &walled(),
            &q,
            &v,
            Method::Rk45,
            1_000,
        ),
        case(
            "taylor, walled pendulum",
            &walled(),
            &q,
            &v,
            Method::Taylor,
            1_000,
        ),
        case(
            "exact, resting",
            &resting(),
            &[0.0],
            &[0.0],
            Method::Exact,
            1_000,
        ),
        case(
            "rk45, resting",
            &resting(),
            &[0.0],
            &[0.0],
            Method::Rk45,
            1_000,
        ),
    ]
}

fn run(case: &Case, keep: Keep, n_impacts: usize) -> (Trajectory, usize) {
    let options = SimulateOptions {
        solver: Solver {
            method: case.method,
            rtol: 1e-5,
            atol: Some(1e-8),
        },
        keep,
        max_impacts: Some(n_impacts),
        ..Default::default()
    };
    let (q0, v0) = &case.start;
    let (run, peak) = peak_of(|| simulate(&case.scene, q0, v0, (0.0, LONG), &options));
    let run = run.expect("runs");
    assert_eq!(
        run.stats().n_impacts,
        n_impacts,
        "{}: {}",
        case.name,
        run.message()
    );
    (run, peak)
}

#[test]
fn a_final_state_takes_constant_memory() {
    for case in cases() {
        let (_, few) = run(&case, Keep::Final, case.n_impacts);
        let (end, many) = run(&case, Keep::Final, 10 * case.n_impacts);
        assert!(many <= few + TEXT, "{}: {few} and {many} bytes", case.name);
        assert!(few < 64_000, "{}: {few} bytes", case.name);
        assert!(end.impacts().is_empty() && end.grazes().is_empty());
        assert!(end.save().motion.is_none() && end.save().samples.is_none());
    }
}

#[test]
fn impacts_kept_take_what_they_are_and_nothing_else_grows() {
    for case in cases() {
        let (_, none) = run(&case, Keep::Final, case.n_impacts);
        for factor in [1, 10] {
            let (kept, peak) = run(&case, Keep::Impacts, factor * case.n_impacts);
            // A list that grows doubles its room, and while it moves has the old beside the new: three times what it holds.
            let list = 3 * (size_of_val(kept.impacts()) + size_of_val(kept.grazes()));
            // A contact that lasts is read off the arcs along it and the one behind.
            let contacts = kept.contacts().expect("kept");
            let lasting = contacts.iter().filter(|own| own.end > own.start).count();
            let list = list + 3 * lasting * CONTACT;
            assert!(
                peak <= none + list + TEXT,
                "{}: {peak} of {list}",
                case.name
            );
            assert!(kept.save().motion.is_none());
        }
    }
    assert_eq!(size_of::<Impact>(), 48);
}

#[test]
fn a_motion_kept_grows_by_its_flights() {
    // The same counter sees it: a test that could not tell would prove nothing.
    let case = &cases()[0];
    let (_, few) = run(case, Keep::Motion, 1_000);
    let (_, many) = run(case, Keep::Motion, 10_000);
    assert!(many > 5 * few, "{few} and {many} bytes");
}

#[test]
fn an_ensemble_takes_a_row_for_each_trajectory() {
    let sweep = SweepOptions { threads: Some(1) };
    let peak_for = |case: &Case, rows: usize, span: f64| {
        let n = case.scene.n_dof();
        let (q, v) = &case.start;
        let rows_of = |x: &DVector<f64>| {
            DMatrix::from_fn(rows, n, |i, j| x[j] * (1.0 - 1e-3 * i as f64 / rows as f64))
        };
        let (q0, v0) = (rows_of(q), rows_of(v));
        let options = SimulateOptions {
            solver: Solver {
                method: case.method,
                rtol: 1e-5,
                atol: Some(1e-8),
            },
            keep: Keep::Final,
            ..Default::default()
        };
        let (ends, peak) =
            peak_of(|| simulate_many(&case.scene, (&q0, &v0), (0.0, span), &options, sweep));
        assert!(ends.expect("runs").n_impacts.iter().all(|&n| n > 0));
        peak
    };
    for case in cases() {
        let (short, long) = (peak_for(&case, 16, 100.0), peak_for(&case, 16, 1000.0));
        assert!(
            long <= short + TEXT,
            "{}: {short} and {long} bytes",
            case.name
        );
        let many = peak_for(&case, 160, 100.0);
        let row = (many - short.min(many)) / 144;
        assert!(row <= 512, "{}: {row} bytes a trajectory", case.name);
    }
}

#[test]
fn ten_million_impacts_in_a_soak_run() {
    let Some(asked) = std::env::var_os("SOAK_IMPACTS") else {
        return;
    };
    let n_impacts = asked
        .to_str()
        .and_then(|n| n.parse().ok())
        .expect("a number of impacts");
    for case in cases() {
        let (_, few) = run(&case, Keep::Final, case.n_impacts);
        let (end, peak) = run(&case, Keep::Final, n_impacts);
        println!(
            "{}: {n_impacts} impacts, {} flights, t = {:.6e}: peak {peak} bytes, {few} for {}",
            case.name,
            end.stats().n_flights,
            end.span().1,
            case.n_impacts
        );
        assert!(peak <= few + TEXT, "{}: {few} and {peak} bytes", case.name);
    }
}

//! Several contacts at once, in motion: struck together, held together, let go by one another (theory 9).

use crate::scenes::{BOTH, harmonic, linear, loaded, lower, oscillator, run, scene, upper, with};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    Forcing, Keep, Kind, Method, Motion, PaperOptions, Scene, SegmentKind, Side, SimulateOptions,
    Solver, Status, Stop, SweepOptions, paper_scene, simulate, simulate_many,
};

/// A column of beads in contact above a floor, heights q, under unit gravity.
fn column(beads: usize, restitution: f64) -> Scene {
    let system = loaded(
        linear(
            DVector::from_element(beads, 1.0),
            DVector::zeros(beads),
            DVector::zeros(beads),
        ),
        DVector::from_element(beads, -1.0).as_slice(),
    );
    let floor = lower(0, 0.0, restitution);
    // Bead i may not pass bead i + 1 from below: q_i - q_{i+1} <= 0.
    let between = (0..beads - 1).map(|i| {
        let normal = DVector::from_fn(beads, |j, _| match j {
            j if j == i => 1.0,
            j if j == i + 1 => -1.0,
            _ => 0.0,
        });
        upper(normal, 0.0, restitution)
    });
    let stops: Vec<Stop> = std::iter::once(floor).chain(between).collect();
    scene(system, Forcing::Unforced, stops)
}

#[test]
fn an_elastic_column_of_ten_beads_rebounds_as_one_body() {
    let scene = column(10, 1.0);
    let high = DVector::from_element(10, 0.5);
    for method in BOTH {
        // Falls for 1, rises for 1: back at its height at t = 2, at rest, and again at t = 4.
        let run = simulate(
            &scene,
            &high,
            &DVector::zeros(10),
            (0.0, 4.0),
            &with(method, 1e-9),
        )
        .expect("runs");
        assert_eq!(run.status(), Status::Finished, "{}", run.message());
        assert!(
            (run.last().0 - &high).amax() < 1e-9,
            "{method:?} {}",
            run.last().0
        );
        assert!(run.last().1.amax() < 1e-8);
        // At the floor each contact carries the beads above it: p_i = 2 v (10 - i).
        for impact in run.impacts().iter().take(10) {
            let carried = 2.0 * (10 - impact.stop) as f64;
            assert!((impact.time - 1.0).abs() < 1e-9 && (impact.impulse - carried).abs() < 1e-8);
        }
    }
}

#[test]
fn a_plastic_column_comes_to_rest_and_stays_in_every_contact() {
    let scene = column(3, 0.0);
    for method in BOTH {
        let run = simulate(
            &scene,
            &dvector![0.5, 0.6, 0.9],
            &DVector::zeros(3),
            (0.0, 10.0),
            &with(method, 1e-9),
        )
        .expect("runs");
        assert_eq!(run.status(), Status::Finished, "{}", run.message());
        assert!(
            run.last().0.amax() < 1e-9 && run.last().1.amax() < 1e-9,
            "{method:?}"
        );
        let held = run.segments().expect("kept");
        let at_end = held
            .iter()
            .filter(|s| s.end == 10.0 && s.kind == SegmentKind::Stick);
        assert_eq!(at_end.count(), 3);
    }
}

#[test]
fn three_stops_on_two_coordinates_hold_together() {
    // A corner with a third plane through its edge: dependent normals. Pushed into it, the motion rests.
    let system = loaded(
        linear(
            dmatrix![1.0, 0.2; 0.2, 1.0],
            DMatrix::zeros(2, 2),
            dmatrix![1.0, 0.0; 0.0, 1.0],
        ),
        &[1.0, 1.0],
    );
    let stops = [
        upper(0, 0.2, 0.3),
        upper(1, 0.2, 0.3),
        upper(dvector![1.0, 1.0], 0.4, 0.3),
    ];
    let scene = scene(system, Forcing::Unforced, stops);
    for method in BOTH {
        let run = run(&scene, &[0.0, 0.05], &[0.3, 0.1], 20.0, &with(method, 1e-9));
        assert_eq!(
            run.status(),
            Status::Finished,
            "{method:?} {}",
            run.message()
        );
        assert!(
            (run.last().0 - dvector![0.2, 0.2]).amax() < 1e-9,
            "{method:?} {}",
            run.last().0
        );
    }
}

#[test]
fn two_stops_without_room_end_or_rest_but_never_loop() {
    // Both sides of one coordinate at the same place: nothing can move there.
    let stops = [upper(0, 0.0, 0.5), lower(0, 0.0, 0.5)];
    let scene = oscillator(0.1, harmonic(&[1.0], 1.0, 0.0), stops);
    for method in BOTH {
        for speed in [0.0, 0.5] {
            let run = run(&scene, &[0.0], &[speed], 10.0, &with(method, 1e-9));
            assert!(matches!(
                run.status(),
                Status::Finished | Status::UnresolvedContact
            ));
            assert!(run.last().0[0].abs() < 1e-9, "{method:?} {}", run.message());
        }
    }
}

#[test]
fn stops_at_one_place_are_struck_together_while_another_is_held() {
    // The second body is pressed onto its stop; a spring draws the first one to it, where two stops wait: the livelier one rules.
    let system = loaded(
        linear(
            dvector![1.0, 1.0],
            dvector![0.0, 0.0],
            dmatrix![1.0, -1.0; -1.0, 1.0],
        ),
        &[0.0, 5.0],
    );
    let between = |e| {
        let stop = upper(dvector![1.0, -1.0], 0.0, e);
        stop.on_side(Side::Lower)
    };
    for k in 0..40 {
        let clearance = 0.5 + 0.01 * f64::from(k);
        let held = upper(1, clearance, 0.0);
        let stops = [held, between(0.5), between(1.0)];
        let scene = scene(system.clone(), Forcing::Unforced, stops);
        let (q, v) = (dvector![clearance + 0.05, clearance], dvector![0.0, 0.0]);
        let run = simulate(&scene, &q, &v, (0.0, 2.0), &with(Method::Exact, 1e-9)).expect("runs");
        let impact = run
            .impacts()
            .iter()
            .find(|i| i.stop > 0)
            .expect("it is struck");
        assert!((impact.time - 0.5 * std::f64::consts::PI).abs() < 1e-12);
        assert!(
            (impact.departure - 0.05).abs() < 1e-12,
            "{clearance}: {impact:?}"
        );
    }
}

#[test]
fn an_impact_of_one_stop_lets_another_go() {
    // The first coordinate is pressed on its stop; the second strikes a stop that is coupled to it by inertia.
    let system = loaded(
        linear(
            dmatrix![1.0, 0.6; 0.6, 1.0],
            DMatrix::zeros(2, 2),
            dmatrix![0.1, 0.0; 0.0, 1.0],
        ),
        &[0.05, 0.0],
    );
    let stops = [upper(0, 0.0, 0.0), lower(1, 0.3, 0.9)];
    let scene = scene(system, Forcing::Unforced, stops);
    let runs = BOTH.map(|method| run(&scene, &[0.0; 2], &[0.0, -1.0], 6.0, &with(method, 1e-9)));
    for run in &runs {
        assert_eq!(run.status(), Status::Finished, "{}", run.message());
    }
    assert_eq!(runs[0].impacts().len(), runs[1].impacts().len());
    assert!((runs[0].last().0 - runs[1].last().0).amax() < 1e-7);
    let segments = runs[0].segments().expect("kept");
    assert!(segments.iter().any(|s| s.kind == SegmentKind::Stick));
    assert!(segments.iter().any(|s| s.kind == SegmentKind::Flight));
}

#[test]
fn an_ensemble_of_pendulums_has_the_bits_of_one_by_one() {
    let scene = paper_scene(
        Kind::Three,
        &PaperOptions {
            linear: false,
            ..Default::default()
        },
    )
    .expect("valid");
    let q0 = DMatrix::from_fn(9, 2, |i, j| {
        0.01 * (i as f64 - 4.0) * (1.0 - 2.0 * j as f64)
    });
    let v0 = DMatrix::from_fn(9, 2, |i, j| 0.1 * (i + j) as f64);
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-7,
            ..Solver::default()
        },
        keep: Keep::Final,
        ..Default::default()
    };
    let ends = simulate_many(
        &scene,
        (&q0, &v0),
        (0.0, 30.0),
        &options,
        SweepOptions::default(),
    )
    .expect("runs");
    for i in 0..9 {
        let (q, v) = (q0.row(i).transpose(), v0.row(i).transpose());
        let one = simulate(&scene, &q, &v, (0.0, 30.0), &options).expect("runs");
        assert_eq!(
            (ends.q.row(i).transpose(), ends.v.row(i).transpose()),
            (one.last().0.clone(), one.last().1.clone())
        );
        assert_eq!(ends.n_impacts[i], one.stats().n_impacts);
    }
}

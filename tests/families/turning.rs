//! Attractors and basins of a pendulum that may turn over: an angle is the same a turn on.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{DMatrix, DVector, dvector};
use vibroimpact::{
    AttractorKind, AttractorOptions, Attractors, BasinOptions, Harmonic, Label, PendulumChain,
    Scene, SimulateOptions, StateBox, Stop, basin_cells, find_attractors, simulate,
};

const NONE: [Stop; 0] = [];

/// `th'' + 0.3 th' + sin th = 2 cos t`: two motions turn over once in each period, one either way; others swing.
fn pendulum() -> Scene {
    let one = dvector![1.0];
    let chain = PendulumChain::new(one.clone(), one, &dvector![0.3], 1.0).expect("valid");
    let force = Harmonic::new(dvector![2.0.into()], 1.0, 0.0).expect("valid");
    Scene::new(chain, force, NONE).expect("valid")
}

fn around(low: f64) -> StateBox {
    let sides = (dvector![low, -3.0], dvector![low + TAU, 3.0]);
    StateBox::new(sides.0, sides.1)
        .and_then(|own| own.with_turn(0, TAU))
        .expect("valid")
}

fn seeds(low: f64) -> DMatrix<f64> {
    let rows = (0..5).flat_map(|i| (0..5).map(move |j| (i, j)));
    let states: Vec<f64> = rows
        .flat_map(|(i, j)| {
            [
                low + TAU * (f64::from(i) + 0.5) / 5.0,
                -3.0 + 6.0 * (f64::from(j) + 0.5) / 5.0,
            ]
        })
        .collect();
    DMatrix::from_row_slice(25, 2, &states)
}

fn found(low: f64, phase: f64) -> Attractors {
    let options = AttractorOptions {
        phase,
        transient: 100,
        ..AttractorOptions::default()
    };
    find_attractors(&pendulum(), &around(low), &seeds(low), &options).expect("found")
}

fn shorter(x: f64) -> f64 {
    x - TAU * (x / TAU).round()
}

#[test]
fn motions_that_turn_over_repeat_themselves() {
    let all = found(-PI, 0.0).all;
    let turning: Vec<_> = all.iter().filter(|one| one.orbit.is_none()).collect();
    assert_eq!(turning.len(), 2);
    for one in &turning {
        assert_eq!((one.kind, one.n_periods), (AttractorKind::Periodic, 1));
        assert!(one.reason.contains("goes round"), "{}", one.reason);
        // It is there again after a period, a turn on.
        let start = one.points.row(0);
        let run = simulate(
            &pendulum(),
            &dvector![start[0]],
            &dvector![start[1]],
            (0.0, TAU),
            &SimulateOptions::default(),
        );
        let run = run.expect("a run");
        let (q, v) = run.last();
        assert!(((q[0] - start[0]).abs() - TAU).abs() < 1e-5);
        assert!((v[0] - start[1]).abs() < 1e-5);
        assert!((-PI..PI).contains(&start[0]));
    }
    // One is the mirror of the other, half a period later.
    let later = found(-PI, PI).all;
    for one in &turning {
        let mirror = later.iter().find(|other| {
            let off = one.points.row(0) + other.points.row(0);
            other.orbit.is_none() && shorter(off[0]).abs() < 1e-4 && off[1].abs() < 1e-4
        });
        assert!(mirror.is_some());
    }
    assert!(all.iter().any(|one| one.orbit.is_some()), "some swing");
}

#[test]
fn basins_are_the_same_a_turn_on() {
    let all = found(-PI, 0.0);
    let states = seeds(-PI);
    let turned = DMatrix::from_fn(25, 2, |i, j| {
        states[(i, j)] + if j == 0 { TAU } else { 0.0 }
    });
    let phases = vec![0.0; 25];
    let options = BasinOptions::default();
    let cells = |around: &StateBox, states: &DMatrix<f64>| {
        basin_cells(&pendulum(), &all.all, around, (states, &phases), &options).expect("cells")
    };
    let here = cells(&around(-PI), &states);
    assert_eq!(cells(&around(-PI), &turned).labels, here.labels);
    assert_eq!(cells(&around(PI), &turned).labels, here.labels);
    // Each is where its motion ends.
    for (i, label) in here.labels.iter().enumerate() {
        let Label::Attractor(k) = *label else {
            panic!("{label:?}");
        };
        let (q, v): (DVector<f64>, DVector<f64>) =
            (dvector![states[(i, 0)]], dvector![states[(i, 1)]]);
        let run = simulate(
            &pendulum(),
            &q,
            &v,
            (0.0, 300.0 * TAU),
            &SimulateOptions::default(),
        )
        .expect("a run");
        let (q, v) = run.last();
        let points = &all.all[k].points;
        let near = |j: usize| {
            shorter(points[(j, 0)] - q[0]).abs() < 1e-4 && (points[(j, 1)] - v[0]).abs() < 1e-4
        };
        assert!((0..points.nrows()).any(near), "state {i}");
    }
}

#[test]
fn a_wrong_turn_is_refused() {
    let plain = || StateBox::new(dvector![-1.0, -1.0], dvector![1.0, 1.0]).expect("valid");
    for (position, turn, message) in [
        (1, TAU, "wrap is 1"),
        (0, 0.0, "wrap[0] is 0"),
        (0, f64::NAN, "wrap[0] is NaN"),
    ] {
        let error = plain().with_turn(position, turn).expect_err("refused");
        assert!(error.to_string().contains(message), "{error}");
    }
}

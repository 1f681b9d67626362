//! Diagrams of scenes whose forcing has no period: impacts are counted.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Axis, BifurcationDiagram, DiagramOptions, Error, Forcing, Harmonic, LinearSystem, Parameter,
    Pattern, Scene, Section, Side, SimulateOptions, Status, Stop, bifurcation_diagram, simulate,
};

fn over(scene: &Scene, restitutions: &[f64], options: DiagramOptions) -> BifurcationDiagram {
    let axis = Axis::new(Parameter::RESTITUTION, restitutions.iter().copied());
    let options = DiagramOptions {
        section: Section::Impacts(vec![]),
        ..options
    };
    bifurcation_diagram(scene, &axis, &options).expect("a diagram")
}

fn unforced(damping: f64, load: f64, stop: Stop) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![damping], dmatrix![1.0]).expect("valid");
    let system = system.with_load(dvector![load]).expect("valid");
    Scene::new(system, Forcing::Unforced, [stop]).expect("valid")
}

fn from(q: f64, v: f64) -> DiagramOptions {
    DiagramOptions {
        start: Some((dvector![q], dvector![v])),
        ..DiagramOptions::default()
    }
}

#[test]
fn a_motion_that_feeds_itself_settles_on_one_impact() {
    // x'' - 0.1 x' + x = 0: it grows until it hits, and the stop takes what it has gained. From the stop at d = 1 with speed e u back
    // to it with speed u: two equations for u and the time.
    let found = over(
        &unforced(-0.1, 0.0, Stop::new(0, 1.0, 0.5).expect("valid")),
        &[0.3, 0.5],
        from(0.1, 0.0),
    );
    assert_eq!(found.n_periods, [1, 1]);
    assert_eq!(found.n_impacts, [50, 50]);
    assert_eq!(found.status, [Status::Finished; 2]);
    assert_eq!(found.pattern, [Pattern::single(0), Pattern::single(0)]);
    for (k, restitution) in [0.3, 0.5].into_iter().enumerate() {
        let rows: Vec<usize> = (0..found.index.len())
            .filter(|&i| found.index[i] == k)
            .collect();
        assert_eq!(rows.len(), 50);
        let last = rows[49];
        let (speed, period) = (
            found.points.speed_before[last],
            found.points.t[last] - found.points.t[last - 1],
        );
        let turn = (1.0f64 - 0.05 * 0.05).sqrt();
        let (cos, sin) = ((turn * period).cos(), (turn * period).sin() / turn);
        let grown = (0.05 * period).exp();
        let v = -restitution * speed;
        let q = grown * (cos - 0.05 * sin + v * sin);
        let after = grown * (v * (cos + 0.05 * sin) - sin);
        assert!((q - 1.0).abs() < 1e-9, "{q}");
        assert!((after - speed).abs() < 1e-9, "{after} {speed}");
    }
}

#[test]
fn a_motion_that_keeps_its_energy_repeats_itself() {
    let stop = Stop::new(0, 0.5, 1.0).expect("valid");
    let found = over(&unforced(0.0, 0.0, stop), &[1.0], from(-1.0, 0.0));
    assert_eq!(found.n_periods, [1]);
    let speed = (1.0f64 - 0.25).sqrt();
    assert!(
        found
            .points
            .speed_before
            .iter()
            .all(|u| (u - speed).abs() < 1e-10)
    );
    // A free oscillation but for the arc that is left out.
    let period = TAU - 2.0 * 0.5f64.acos();
    assert!((found.points.t[1] - found.points.t[0] - period).abs() < 1e-9);
}

#[test]
fn what_comes_to_rest_is_not_waited_for() {
    // A ball on a table: its impacts accumulate and are one; then nothing comes.
    let ball = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![0.0]).expect("valid");
    let ball = ball.with_load(dvector![-1.0]).expect("valid");
    let table = Stop::new(0, 0.0, 0.5).expect("valid").on_side(Side::Lower);
    let scene = Scene::new(ball, Forcing::Unforced, [table]).expect("valid");
    let found = over(&scene, &[0.5, 0.8], from(1.0, 0.0));
    assert_eq!(found.n_periods, [0, 0]);
    assert!(found.n_impacts.iter().all(|&n| n <= 1));
    // One that never hits, and one that stands still.
    for start in [(0.1, 0.0), (0.0, 0.0)] {
        let scene = unforced(0.1, 0.0, Stop::new(0, 1.0, 0.5).expect("valid"));
        let found = over(&scene, &[0.5], from(start.0, start.1));
        assert_eq!((found.n_impacts[0], found.points.t.len()), (0, 0));
        assert_eq!(found.status, [Status::Finished]);
    }
}

#[test]
fn tones_without_a_common_period_are_looked_at_after_impacts() {
    let tone = |w: f64| Forcing::from(Harmonic::new(dvector![1.2.into()], w, 0.0).expect("valid"));
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.2], dmatrix![1.0]).expect("valid");
    let forcing = Forcing::Several(vec![tone(0.8), tone(0.8 * PI)]);
    let stop = Stop::new(0, 1.0, 0.6).expect("valid");
    let scene = Scene::new(system, forcing, [stop]).expect("valid");
    assert_eq!(scene.period(), None);
    let options = DiagramOptions {
        transient: 30,
        periods: 20,
        ..DiagramOptions::default()
    };
    let found = over(&scene, &[0.6], options);
    assert_eq!((found.points.t.len(), found.n_periods[0]), (20, 0));
    // The impacts of a run, after the transient.
    let span = (0.0, found.points.t[19] + 1e-6);
    let run = simulate(
        &scene,
        &dvector![0.0],
        &dvector![0.0],
        span,
        &SimulateOptions::default(),
    )
    .expect("a run");
    let times: Vec<f64> = run.impacts().iter().map(|impact| impact.time).collect();
    assert_eq!(times.len(), 50);
    for (own, time) in found.points.t.iter().zip(&times[30..]) {
        assert!((own - time).abs() < 1e-9);
    }
}

#[test]
fn a_phase_needs_a_period() {
    let scene = unforced(0.1, 0.0, Stop::new(0, 1.0, 0.5).expect("valid"));
    let axis = Axis::new(Parameter::RESTITUTION, [0.5]);
    let error =
        bifurcation_diagram(&scene, &axis, &DiagramOptions::default()).expect_err("refused");
    assert!(matches!(error, Error::BadValue { .. }));
    assert!(
        error.to_string().contains("section must be \"impact\""),
        "{error}"
    );
}

#[test]
fn stops_hit_at_one_instant_are_one_return() {
    // Two masses alike, side by side: each feeds itself, and both hit at once.
    let both = dvector![1.0, 1.0];
    let system = LinearSystem::new(both.clone(), &both * -0.1, both.clone()).expect("valid");
    let stops = [0, 1].map(|mass| Stop::new(mass, 1.0, 0.5).expect("valid"));
    let scene = Scene::new(system, Forcing::Unforced, stops).expect("valid");
    let options = DiagramOptions {
        start: Some((&both * 0.1, &both * 0.0)),
        ..DiagramOptions::default()
    };
    let found = over(&scene, &[0.5], options);
    assert_eq!(found.n_periods, [1]);
    assert_eq!(
        found.pattern,
        [Pattern::new(vec![vec![0, 1]]).expect("valid")]
    );
}

//! Branches of motions of every kind: each of their orbits is retraced by a simulation.

use crate::scenes::{USUAL, followed};
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Branch, ContinuationOptions, EndReason, Harmonic, Heading, ImpactSide, Kind, LinearSystem,
    Motion, OrbitOptions, PaperOptions, Parameter, Pattern, Scene, Side, SimulateOptions, Stop,
    StopNumber, continuation_of, find_orbit, paper_scene, periodic_orbits, simulate,
};

/// Orbits on which small deviations do not grow by more than this in a period are retraced.
const TAME: f64 = 10.0;

/// Admissible orbits of a branch are what a simulation from their states does for a period.
pub fn check_retraced(branch: &Branch, tolerance: f64) {
    let mut count = 0;
    for (k, orbit) in branch.orbits.iter().enumerate().step_by(3) {
        let orders = &orbit.stability().expect("multipliers").orders;
        let is_tame = orders
            .first()
            .is_some_and(|order| order.spectral_radius() < TAME);
        if orbit.is_admissible() != Some(true) || !is_tame {
            continue;
        }
        let run = simulate(
            orbit.scene(),
            &orbit.q0(),
            &orbit.v0(),
            (0.0, 1.4 * orbit.period()),
            &SimulateOptions::default(),
        );
        let run = run.expect("a run");
        let (q, v) = run.last();
        let (p, u) = orbit
            .state(1.4 * orbit.period(), ImpactSide::After)
            .expect("a time");
        let size = u.amax().max(p.amax()).max(1e-6);
        let off = (q - p).amax().max((v - u).amax()) / size;
        assert!(off < tolerance, "{k} at {}: {off:e}", branch.parameter[k]);
        count += 1;
    }
    assert!(count > 3, "{count}");
}

fn options(heading: Heading) -> ContinuationOptions {
    ContinuationOptions {
        heading,
        ..ContinuationOptions::default()
    }
}

#[test]
fn a_motion_that_hits_nothing_ends_where_it_touches() {
    let own = crate::scenes::Oscillator {
        force: 1.0,
        ..USUAL
    };
    let found = periodic_orbits(&own.scene(), &Pattern::none(), &OrbitOptions::default());
    let orbits = found.expect("one");
    let branch = followed(
        &orbits[0],
        Parameter::ForcingScale,
        (0.0, 9.0),
        &options(Heading::Both),
    );
    assert_eq!(branch.ends[0].reason, EndReason::Range);
    assert_eq!(branch.ends[1].reason, EndReason::Boundary);
    let z = (1.0f64 - 2.4 * 2.4).hypot(0.1 * 2.4);
    let last = branch.parameter.last().expect("one");
    assert!((last / z - 1.0).abs() < 1e-9, "{last} {z}");
    check_retraced(&branch, 1e-9);
}

#[test]
fn two_masses_between_stops() {
    let system = LinearSystem::new(
        dmatrix![1.0, 0.2; 0.2, 2.0],
        dmatrix![0.1, 0.0; 0.0, 0.3],
        dmatrix![2.0, -1.0; -1.0, 3.0],
    );
    let force = Harmonic::new(dvector![2.0.into(), 0.5.into()], 1.9, 0.3).expect("valid");
    let stops = [
        Stop::new(0, 0.4, 0.7).expect("valid"),
        Stop::new(1, 0.5, 0.6).expect("valid").on_side(Side::Lower),
    ];
    let scene = Scene::new(system.expect("valid"), force, stops).expect("valid");
    let rest = dvector![0.0, 0.0];
    let span = (0.0, 400.0 * TAU / 1.9);
    let run = simulate(&scene, &rest, &rest, span, &SimulateOptions::default()).expect("a run");
    let orbit = find_orbit(&scene, &run, None).expect("an orbit");
    for parameter in [
        Parameter::Frequency,
        Parameter::CLEARANCE.of(1),
        Parameter::RESTITUTION.of(0),
        Parameter::DampingScale,
    ] {
        let range = match parameter {
            Parameter::Frequency => (1.2, 2.6),
            Parameter::OneStop(StopNumber::Restitution, _) => (0.3, 0.95),
            Parameter::DampingScale => (0.3, 3.0),
            _ => (0.1, 1.5),
        };
        let branch = followed(&orbit, parameter, range, &options(Heading::Both));
        assert!(branch.orbits.len() > 10);
        check_retraced(&branch, 1e-8);
    }
}

#[test]
fn a_ball_that_comes_to_rest_on_a_shaken_table() {
    let ball = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![0.0]);
    let ball = ball
        .and_then(|ball| ball.with_load(dvector![-1.0]))
        .expect("valid");
    let force = Harmonic::new(dvector![1.3.into()], 1.0, 0.0).expect("valid");
    let table = Stop::new(0, 0.0, 0.5).expect("valid").on_side(Side::Lower);
    let scene = Scene::new(ball, force, [table]).expect("valid");
    let run = simulate(
        &scene,
        &dvector![0.3],
        &dvector![0.0],
        (0.0, 12.0 * TAU),
        &SimulateOptions::default(),
    );
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    for (parameter, range) in [
        (Parameter::ForcingScale, (0.8, 1.6)),
        (Parameter::RESTITUTION, (0.1, 0.9)),
    ] {
        let branch = followed(&orbit, parameter, range, &options(Heading::Both));
        for orbit in &branch.orbits {
            let order = &orbit.stability().expect("multipliers").orders[0];
            assert!(order.spectral_radius() < 1e-9);
        }
        check_retraced(&branch, 1e-8);
    }
}

#[test]
fn a_pendulum_with_large_motions() {
    let options_of = PaperOptions::default();
    let linear = paper_scene(Kind::Three, &options_of).expect("valid");
    let known = periodic_orbits(
        &linear,
        &Pattern::single(1),
        &OrbitOptions {
            n_periods: 2,
            ..OrbitOptions::default()
        },
    );
    let scene = paper_scene(
        Kind::Three,
        &PaperOptions {
            linear: false,
            ..PaperOptions::default()
        },
    );
    let orbit = find_orbit(&scene.expect("valid"), &known.expect("some")[0], None).expect("one");
    let start = TAU / orbit.scene().period().expect("forced");
    let branch = followed(
        &orbit,
        Parameter::Frequency,
        (0.97 * start, 1.03 * start),
        &options(Heading::Both),
    );
    check_retraced(&branch, 1e-7);
}

#[test]
fn a_motion_that_feeds_itself() {
    // Damping below zero brings in what the impacts take.
    let system = LinearSystem::new(dvector![1.0], dmatrix![-0.1], dmatrix![1.0]).expect("valid");
    let stop = Stop::new(0, 0.3, 0.6).expect("valid");
    let scene = Scene::new(system, vibroimpact::Forcing::Unforced, [stop]).expect("valid");
    let run = simulate(
        &scene,
        &dvector![0.0],
        &dvector![0.5],
        (0.0, 200.0),
        &SimulateOptions::default(),
    );
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    for (parameter, range) in [
        (Parameter::CLEARANCE, (0.05, 1.0)),
        (Parameter::RESTITUTION, (0.3, 0.85)),
        (Parameter::DampingScale, (0.5, 1.5)),
    ] {
        let branch = followed(&orbit, parameter, range, &options(Heading::Both));
        check_retraced(&branch, 1e-8);
        if parameter == Parameter::CLEARANCE {
            // Twice the room, twice the motion, in the same time.
            for (orbit, d) in branch.orbits.iter().zip(&branch.parameter) {
                let scaled = orbit.impacts()[0].approach / d;
                let first = branch.orbits[0].impacts()[0].approach / branch.parameter[0];
                assert!((scaled / first - 1.0).abs() < 1e-9);
                assert!((orbit.period() / branch.orbits[0].period() - 1.0).abs() < 1e-10);
            }
        }
    }
}

#[test]
fn units_grow_with_the_motion() {
    // Force and clearance in one proportion: the motion is the same but for its size, which grows a millionfold.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let make = |part: f64| {
        let force = Harmonic::new(dvector![(8.5 * part).into()], 2.4, 0.0)?;
        Scene::new(system.clone(), force, [Stop::new(0, part, 0.8)?])
    };
    let least = 1e-6;
    let found = periodic_orbits(
        &make(least).expect("a scene"),
        &Pattern::single(0),
        &OrbitOptions::default(),
    );
    let orbit = &found.expect("a search")[0];
    let options = options(Heading::Up);
    let branch = continuation_of(orbit, &make, least, (least, 1.0), &options);
    let branch = branch.expect("a branch");
    assert_eq!(
        branch.ends[1].reason,
        EndReason::Range,
        "{}",
        branch.ends[1].detail
    );
    let speed = orbit.impacts()[0].approach / least;
    for (own, &part) in branch.orbits.iter().zip(&branch.parameter) {
        let off = own.impacts()[0].approach / (part * speed) - 1.0;
        assert!(off.abs() < 1e-9, "{part:e}: {off:e}");
    }
}

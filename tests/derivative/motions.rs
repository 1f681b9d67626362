//! Derivatives of motions of every kind: nonlinear, in lasting contact, through impacts that accumulate, without forcing.

use crate::differences::compare;
use crate::scenes::{harmonic, linear, loaded, lower, scene, shaken_ball, unit_mass, upper};
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{Complex, DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, Change, DoublePendulum, Forcing, Kind, OrbitOptions, PaperOptions, Parameter,
    Pattern, PendulumChain, PeriodicOrbit, Scene, SimulateOptions, StopNumber, Wall, WallSide,
    derivatives, derivatives_of, find_orbit, paper_scene, periodic_orbits, simulate,
};

fn settled(scene: &Scene, q0: DVector<f64>, v0: DVector<f64>, end: f64) -> PeriodicOrbit {
    let run = simulate(scene, &q0, &v0, (0.0, end), &SimulateOptions::default());
    find_orbit(scene, &run.expect("a run"), None).expect("an orbit")
}

/// All derivatives by some numbers, at their values; how many were compared.
fn check(
    orbit: &PeriodicOrbit,
    numbers: &[(Parameter, f64)],
    steps: (f64, f64, f64),
    name: &str,
) -> usize {
    let names: Vec<Parameter> = numbers.iter().map(|own| own.0).collect();
    let found = derivatives(orbit, &names).expect("derivatives");
    assert_eq!(found.reason, "", "{name}");
    let mut count = 0;
    for (i, &(number, value)) in numbers.iter().enumerate() {
        let make = |offset: f64| orbit.scene().replace(number.change(value + offset));
        let case = format!("{name}, {number}");
        count += compare(orbit, (&found, i), &make, steps, &case);
    }
    count
}

#[test]
fn a_ball_that_comes_to_rest_on_a_shaken_table() {
    for (e, shake) in [(0.0, 1.3), (0.5, 1.3), (0.8, 1.1)] {
        let scene = shaken_ball(e, shake, 0.0);
        let orbit = settled(&scene, dvector![0.3], dvector![0.0], 12.0 * TAU);
        let mut numbers = vec![(Parameter::ForcingScale, 1.0), (Parameter::Frequency, 1.0)];
        if e > 0.0 {
            numbers.push((Parameter::RESTITUTION, e));
        }
        let count = check(&orbit, &numbers, (2e-4, 1e-6, 0.0), &format!("a ball, {e}"));
        assert!(count > 10, "{e}: {count}");
    }
}

#[test]
fn two_masses_of_which_one_stays_on_a_floor() {
    let system = loaded(
        linear(
            dmatrix![1.0, 0.3; 0.3, 1.0],
            dmatrix![0.2, -0.2; -0.2, 0.4],
            dmatrix![1.0, -1.0; -1.0, 3.0],
        ),
        &[-1.5, 0.0],
    );
    let floor = scene(
        system,
        harmonic(&[2.75, 0.0], 1.0, 0.0),
        [lower(0, 0.0, 0.5)],
    );
    let orbit = settled(&floor, dvector![0.5, 0.0], dvector![0.0, 0.0], 400.0);
    let numbers = [
        (Parameter::ForcingScale, 1.0),
        (Parameter::RESTITUTION, 0.5),
        (Parameter::DampingScale, 1.0),
        (Parameter::CLEARANCE, 0.0),
    ];
    let count = check(&orbit, &numbers, (1e-3, 1e-6, 0.1), "two masses");
    assert!(count > 40, "{count}");
}

#[test]
fn a_pendulum_with_large_motions() {
    let options = OrbitOptions {
        n_periods: 2,
        ..OrbitOptions::default()
    };
    let linear = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let known = periodic_orbits(&linear, &Pattern::single(1), &options).expect("some");
    let large = PaperOptions {
        linear: false,
        ..PaperOptions::default()
    };
    let large = paper_scene(Kind::Three, &large).expect("valid");
    let orbit = find_orbit(&large, &known[0], None).expect("one");
    let frequency = orbit.scene().forcing().frequency().expect("forced");
    let numbers = [
        (Parameter::Frequency, frequency),
        (Parameter::ForcingScale, 1.0),
    ];
    let count = check(&orbit, &numbers, (1e-3, 1e-6, 0.0), "a pendulum");
    assert!(count > 10, "{count}");
}

#[test]
fn a_pendulum_that_is_pressed_against_a_wall() {
    let system = DoublePendulum::new(1.0, 1.0, (0.2, 0.1)).expect("valid");
    let wall = Wall::new(1, -0.1, 0.5, WallSide::Right).expect("valid");
    let base = BaseMotion::new(0.4, 0.4, 0.0).expect("valid");
    let pressed = scene(system, base, [wall]);
    let span = 12.0 * pressed.period().expect("forced");
    let orbit = settled(&pressed, dvector![-0.2, -0.2], dvector![0.0, 0.0], span);
    let numbers = [(Parameter::ForcingScale, 1.0)];
    let count = check(&orbit, &numbers, (1e-3, 1e-5, 0.1), "pressed");
    assert!(count > 5, "{count}");
}

#[test]
fn a_motion_that_feeds_itself() {
    let scene = scene(
        unit_mass(-0.1, 1.0),
        Forcing::Unforced,
        [upper(0, 0.3, 0.6)],
    );
    let orbit = settled(&scene, dvector![0.0], dvector![0.5], 200.0);
    let numbers = [
        (Parameter::CLEARANCE, 0.3),
        (Parameter::RESTITUTION, 0.6),
        (Parameter::DampingScale, 1.0),
    ];
    let count = check(&orbit, &numbers, (5e-4, 1e-6, 0.0), "without forcing");
    assert!(count > 20, "{count}");
    // Twice the room, twice the motion, in the same time.
    let found = derivatives(&orbit, &[Parameter::CLEARANCE]).expect("derivatives");
    let speed = orbit.impacts()[0].approach;
    assert!((found.speeds_before[(0, 0)] * 0.3 / speed - 1.0).abs() < 1e-9);
    assert!(found.period[0].abs() < 1e-9 * orbit.period());
}

/// Numbers in other units, at zero, and beside a large one.
#[test]
fn the_size_of_a_number_does_not_matter() {
    let scene = scene(
        unit_mass(0.1, 1.0),
        harmonic(&[8.5], 2.4, 0.0),
        [upper(0, 1.0, 0.8)],
    );
    let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
    let orbit = &found.expect("a search")[0];
    let plain = derivatives(orbit, &[Parameter::CLEARANCE]).expect("derivatives");
    let cases: [(f64, f64, f64); 5] = [
        (0.0, 1.0, 1.0),
        (1e-9, 1.0, 1.0 - 1e-9),
        (0.0, 1e6, 1.0),
        (1e-6, 1e6, 0.0),
        (1e6, 1e-6, 0.0),
    ];
    for (start, unit, zero) in cases {
        let make = |p: &[f64]| {
            scene.replace(Change::EachStop(
                StopNumber::Clearance,
                vec![zero + unit * p[0]],
            ))
        };
        let found = derivatives_of(orbit, &make, &[start]).expect("derivatives");
        let (own, wanted) = (
            found.speeds_before[(0, 0)],
            unit * plain.speeds_before[(0, 0)],
        );
        assert!(
            (own / wanted - 1.0).abs() < 1e-7,
            "{start} {unit}: {own} {wanted}"
        );
    }
}

/// At a sharp resonance a step that is small for the number is a large one for the motion.
#[test]
fn a_sharp_resonance() {
    let sharp = scene(
        unit_mass(2e-4, 1.0),
        harmonic(&[1e-3], 1.0002, 0.0),
        [upper(0, 50.0, 0.8)],
    );
    let found = periodic_orbits(&sharp, &Pattern::none(), &OrbitOptions::default());
    let orbit = &found.expect("a search")[0];
    let own = derivatives(orbit, &[Parameter::Frequency]).expect("derivatives");
    // Amplitude F/|1 - w^2 + i c w|.
    let (w, c) = (1.0002f64, 2e-4f64);
    let square = (1.0 - w * w).powi(2) + (c * w).powi(2);
    let rate = -1e-3 * 0.5 * square.powf(-1.5) * (-4.0 * w * (1.0 - w * w) + 2.0 * c * c * w);
    let found = own.max_displacement[(0, 0)];
    assert!((found / rate - 1.0).abs() < 1e-6, "{found} {rate}");
}

/// In another unit of time all times and speeds are others, by a known factor.
#[test]
fn a_pendulum_in_another_unit_of_time() {
    // Central differences over 6e-5: their square, a few times.
    const KNOWN: f64 = 2e-8;
    let make = |p: &[f64]| {
        let (two, faster) = (dvector![1.0, 0.7], 1.0 + p[0]);
        let dampers = dvector![0.3, 0.2] * faster;
        let chain = PendulumChain::new(two.clone(), two, &dampers, faster.powi(2))?;
        let wall = Wall::new(1, 0.3, 0.6, WallSide::Right)?;
        Scene::new(chain, BaseMotion::new(0.4, 1.3 * faster, 0.2)?, [wall])
    };
    let shaken = make(&[0.0]).expect("valid");
    let span = 60.0 * shaken.period().expect("forced");
    let orbit = settled(&shaken, dvector![0.1, 0.0], dvector![0.0, 0.0], span);
    assert!(!orbit.impacts().is_empty());
    let own = derivatives_of(&orbit, &make, &[0.0]).expect("derivatives");
    let (q, v) = (orbit.q0(), orbit.v0());
    assert!((own.period[0] / orbit.period() + 1.0).abs() < KNOWN);
    assert!(own.q0.amax() < KNOWN * q.amax(), "{:e}", own.q0.amax());
    let off = (own.v0.column(0) - &v).amax();
    assert!(off < KNOWN * v.amax(), "{off:e}");
    for (k, impact) in orbit.impacts().iter().enumerate() {
        let off = own.speeds_before[(k, 0)] / impact.approach - 1.0;
        assert!(off.abs() < KNOWN, "{off:e}");
    }
    let multipliers = own.multipliers.map(Complex::norm).amax();
    assert!(multipliers < 1e-6, "{multipliers:e}");
}

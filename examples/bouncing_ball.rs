//! A ball that bounces on a shaken table, once in each period of the table.
//!
//! The ball is a rigid body under gravity: a linear system without stiffness, with its height above the table as coordinate.
//! The table is a stop, its motion the base motion. You will see both orbits beside the closed form `v = e g T / (1 + e)`,
//! `sin(phase) = (v - g T / 2) / (a w)`; a ball that is dropped and settles on the stable one; and a map of existence and
//! stability, every cell of which agrees with the closed form. `bouncing_ball.py` draws it.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::dvector;
use vibroimpact::{
    Axis, BaseMotion, LinearSystem, OrbitOptions, Parameter, Pattern, PeriodicOrbit, Result, Scene,
    Side, SimulateOptions, Stop, SweepOptions, existence_map, periodic_orbits, simulate,
};

/// \[m/s^2\]
const GRAVITY: f64 = 9.81;
/// Of the table \[rad/s\].
const FREQUENCY: f64 = 20.0 * TAU;
/// \[s\]
const PERIOD: f64 = TAU / FREQUENCY;
const RESTITUTION: f64 = 0.8;
/// Amplitude of the table's acceleration \[g\].
const ACCELERATION: f64 = 0.6;

/// Ball and table; `acceleration` is the amplitude of the table's, in g.
fn ball(acceleration: f64) -> Result<Scene> {
    let system = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![0.0])?
        .with_load(dvector![-GRAVITY])?
        .with_influence(dvector![1.0])?;
    let table = BaseMotion::new(acceleration * GRAVITY / FREQUENCY.powi(2), FREQUENCY, 0.0)?;
    let surface = Stop::new(0, 0.0, RESTITUTION)?.on_side(Side::Lower);
    Scene::new(system, table, [surface])
}

/// Accelerations of the table, in g, at which the stable orbit is born in a fold and doubles its period.
fn stability_range(e: f64) -> (f64, f64) {
    let fold = PI * (1.0 - e) / (1.0 + e);
    (fold, fold.hypot(2.0 * (1.0 + e * e) / (1.0 + e).powi(2)))
}

/// Both orbits beside the closed form; the stable one is returned.
fn check_orbits() -> Result<PeriodicOrbit> {
    let orbits = periodic_orbits(
        &ball(ACCELERATION)?,
        &Pattern::single(0),
        &OrbitOptions::default(),
    )?;
    assert_eq!(orbits.len(), 2);
    let speed = RESTITUTION * GRAVITY * PERIOD / (1.0 + RESTITUTION);
    let sine = (speed - 0.5 * GRAVITY * PERIOD) / (ACCELERATION * GRAVITY / FREQUENCY);
    println!("speed [m/s]  closed form   phase [rad]  closed form   stable");
    for (i, phase) in [sine.asin().rem_euclid(TAU), PI - sine.asin()]
        .into_iter()
        .enumerate()
    {
        let orbit = &orbits[i];
        let is_stable = orbit.stability()?.is_stable;
        println!(
            "{:<11.9}  {speed:.9}   {:.9}  {phase:.9}   {is_stable:?}",
            orbit.v0()[0],
            orbit.phase()
        );
        assert!((orbit.v0()[0] - speed).abs() < 1e-12 * speed);
        assert!((orbit.phase() - phase).abs() < 1e-12);
        assert!(orbit.is_admissible() == Some(true) && is_stable == Some(i == 0));
    }
    Ok(orbits[0].clone())
}

/// A ball dropped from 5 mm leaves the table after 200 periods with the orbit's speed and at its phase.
fn check_drop(orbit: &PeriodicOrbit) -> Result<()> {
    let scene = orbit.scene().replace(Parameter::Phase.change(0.0))?;
    let span = (0.0, 200.0 * PERIOD);
    let run = simulate(
        &scene,
        &dvector![5e-3],
        &dvector![0.0],
        span,
        &SimulateOptions::default(),
    )?;
    let last = run.impacts()[run.impacts().len() - 1];
    println!(
        "dropped: after {} impacts the speed is {:.9}, the phase {:.9}",
        run.impacts().len(),
        last.departure,
        last.phase
    );
    assert!((last.departure - orbit.v0()[0]).abs() < 1e-9);
    assert!((last.phase - orbit.phase()).abs() < 1e-9);
    Ok(())
}

/// The map over acceleration and restitution, every cell beside the closed form.
fn check_map() -> Result<()> {
    let accelerations = Axis::new(
        "forcing_scale".parse()?,
        (1..=200).map(|i| 0.01 * f64::from(i)),
    );
    let restitutions = Axis::new(
        "restitution".parse()?,
        (40..200).map(|j| 0.005 * f64::from(j)),
    );
    let map = existence_map(
        &ball(1.0)?,
        &Pattern::single(0),
        (&accelerations, &restitutions),
        1,
        SweepOptions::default(),
    )?;
    for (j, &restitution) in map.y.iter().enumerate() {
        let (fold, flip) = stability_range(restitution);
        for (i, &acceleration) in map.x.iter().enumerate() {
            let cell = map.point(i, j);
            assert_eq!(cell.n_orbits > 0, acceleration > fold);
            assert_eq!(cell.is_stable, acceleration > fold && acceleration < flip);
        }
    }
    println!(
        "map: {} cells, each as in the closed form",
        map.x.len() * map.y.len()
    );
    Ok(())
}

fn main() -> Result<()> {
    check_drop(&check_orbits()?)?;
    check_map()
}

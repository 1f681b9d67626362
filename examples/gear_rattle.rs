//! Gear rattle: a loose wheel between the flanks of a driving one that turns unevenly.
//!
//! The driving wheel oscillates by `A cos(w t)`; the driven one is free but for a drag, and has a backlash of 2 b between two
//! flanks, which move as the driving wheel does: two stops with a motion of their own. You will see both motions that hit one
//! flank once in each period beside the closed form `U = g T / (1 + e)`, `sin(phase) = -(g T / 2) (1 - e) / (1 + e) / (A w)`; the map over
//! frequency and backlash, every cell of which agrees with it; and two simulations, one of which meets both flanks.
//! `gear_rattle.py` draws them.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{Complex, dvector};
use vibroimpact::{
    Axis, Forcing, Harmonic, LinearSystem, OrbitOptions, Pattern, Result, Scene, Side,
    SimulateOptions, Stop, StopMotion, SweepOptions, existence_map, periodic_orbits, simulate,
};

/// A, of the driving wheel \[rad\].
const AMPLITUDE: f64 = 1e-3;
/// g, on the driven wheel, over its inertia \[rad/s^2\].
const DRAG: f64 = 20.0;
const RESTITUTION: f64 = 0.7;
/// w, of the motions shown \[rad/s\].
const FREQUENCY: f64 = 145.0;
/// b, of the motions shown \[rad\].
const BACKLASH: f64 = 4e-3;
/// The flank that the drag presses against.
const FIRST: usize = 1;

/// The driven wheel between its flanks; a motion is added to the room on a stop's side.
fn gears() -> Result<Scene> {
    let driven = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![0.0])?
        .with_load(dvector![-DRAG])?;
    let turning = |amplitude: f64| {
        let amplitude = dvector![Complex::new(amplitude, 0.0)];
        StopMotion::harmonic(Harmonic::new(amplitude, FREQUENCY, 0.0)?).map(Some)
    };
    let flank = Stop::new(0, BACKLASH, RESTITUTION)?;
    let above = flank.clone().with_motion(turning(AMPLITUDE)?);
    let below = flank.on_side(Side::Lower).with_motion(turning(-AMPLITUDE)?);
    Scene::new(driven, Forcing::Unforced, [above, below])
}

/// Phases of the driving wheel at impact, that of the stable motion first; none below the frequency of the fold.
fn launch_phases(w: f64) -> Vec<f64> {
    let sine = -PI * DRAG / w * (1.0 - RESTITUTION) / (1.0 + RESTITUTION) / (AMPLITUDE * w);
    if sine < -1.0 {
        return Vec::new();
    }
    vec![sine.asin().rem_euclid(TAU), PI - sine.asin()]
}

/// The return map has determinant e^2 and, with `c = (1 + e)^2 A w^2 cos(phase) / g`, trace `1 + e^2 - c`.
fn is_stable(w: f64, phase: f64) -> bool {
    let c = (1.0 + RESTITUTION).powi(2) * AMPLITUDE * w * w * phase.cos() / DRAG;
    c > 0.0 && c < 2.0 * (1.0 + RESTITUTION.powi(2))
}

/// The least and the most that the wheel is away from its flank during a flight.
fn excursion(w: f64, phase: f64) -> (f64, f64) {
    let period = TAU / w;
    let away = |t: f64| {
        let flank = AMPLITUDE * ((w * t + phase).cos() - phase.cos());
        0.5 * DRAG * t * (period - t) - flank
    };
    let inside = (1..4000).map(|k| away(period * f64::from(k) / 4000.0));
    inside.fold((0.0, 0.0), |(low, high), y| (y.min(low), y.max(high)))
}

/// Both motions beside the closed form.
fn check_orbits(scene: &Scene) -> Result<()> {
    let orbits = periodic_orbits(scene, &Pattern::single(FIRST), &OrbitOptions::default())?;
    let speed = DRAG * TAU / FREQUENCY / (1.0 + RESTITUTION);
    println!("impact speed  closed form   phase [rad]  closed form   stable");
    assert_eq!(orbits.len(), 2);
    for (orbit, phase) in orbits.iter().zip(launch_phases(FREQUENCY)) {
        let (found, stable) = (orbit.impacts()[0].approach, orbit.stability()?.is_stable);
        println!(
            "{found:<12.9}  {speed:.9}   {:.9}  {phase:.9}   {stable:?}",
            orbit.phase()
        );
        assert!((found - speed).abs() < 1e-10 && (orbit.phase() - phase).abs() < 1e-9);
        assert_eq!(orbit.is_admissible(), Some(true));
        assert_eq!(stable, Some(is_stable(FREQUENCY, phase)));
    }
    Ok(())
}

/// The map over frequency and backlash, every cell beside the closed form.
fn check_map(scene: &Scene) -> Result<()> {
    let frequencies = (0..=100).map(|i| 90.0 + f64::from(i));
    let backlashes = (0..=80).map(|j| 1e-3 + 5e-5 * f64::from(j));
    let map = existence_map(
        scene,
        &Pattern::single(FIRST),
        (
            &Axis::new("frequency".parse()?, frequencies),
            &Axis::new("clearance".parse()?, backlashes),
        ),
        1,
        SweepOptions::default(),
    )?;
    for (i, &w) in map.x.iter().enumerate() {
        let motions: Vec<_> = launch_phases(w)
            .into_iter()
            .map(|phase| (is_stable(w, phase), excursion(w, phase)))
            .collect();
        for (j, &backlash) in map.y.iter().enumerate() {
            let cell = map.point(i, j);
            let fits = |(low, high): (f64, f64)| low > -1e-12 && high < 2.0 * backlash;
            assert_eq!(cell.n_orbits as usize, motions.len());
            assert_eq!(cell.is_admissible, motions.iter().any(|m| fits(m.1)));
            assert_eq!(cell.is_stable, motions.iter().any(|m| m.0 && fits(m.1)));
        }
    }
    println!(
        "map: {} cells, each as in the closed form",
        map.x.len() * map.y.len()
    );
    Ok(())
}

/// Two simulations from the middle of the backlash: one settles on the stable motion, the other meets both flanks.
fn check_simulations(scene: &Scene) -> Result<()> {
    let span = (0.0, 200.0 * TAU / FREQUENCY);
    for (speed, meets_both) in [(0.3, false), (0.1, true)] {
        let (q, v) = (dvector![0.0], dvector![speed]);
        let run = simulate(scene, &q, &v, span, &SimulateOptions::default())?;
        let on_the_other = run.impacts().iter().filter(|i| i.stop != FIRST).count();
        println!(
            "from {speed} rad/s: {} impacts on the first flank, {on_the_other} on the other",
            run.impacts().len() - on_the_other
        );
        assert_eq!(on_the_other > 0, meets_both);
        if let (false, Some(last)) = (meets_both, run.impacts().last()) {
            assert!((last.phase - launch_phases(FREQUENCY)[0]).abs() < 1e-9);
        }
    }
    Ok(())
}

fn main() -> Result<()> {
    let scene = gears()?;
    check_orbits(&scene)?;
    check_map(&scene)?;
    check_simulations(&scene)
}

//! An impact damper: a ball in a box that takes energy from whatever shakes the box.
//!
//! The ball of mass m is free between two walls a room g apart. Where the box moves by `a cos(w t)`, a motion with one impact on each wall
//! in a period has a closed form: the ball flies at the speed `V = rho a w sin(theta)`, `rho = (1 + e)/(1 - e)`, theta the phase of the
//! box at an impact with the wall ahead, and `g/a = pi rho sin(theta) - 2 cos(theta)`. A period takes `4 m V^2/rho`. You will see the
//! energies of orbits that were found beside it, and a structure at its resonance that swings less with a ball of 3 % of its mass.
//! `impact_damper.py` draws both.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Forcing, Harmonic, ImpactSide, LinearSystem, Motion, Result, Scene, Side, SimulateOptions,
    Stop, StopMotion, find_orbit, simulate,
};

const MASS: f64 = 0.03;
const RESTITUTION: f64 = 0.6;
const RHO: f64 = (1.0 + RESTITUTION) / (1.0 - RESTITUTION);

/// A ball in a box that moves by cos t.
fn moving_box(room: f64) -> Result<Scene> {
    let ball = LinearSystem::new(dvector![MASS], dvector![0.0], dvector![0.0])?;
    let moving = |amplitude: f64| {
        StopMotion::harmonic(Harmonic::new(dvector![amplitude.into()], 1.0, 0.0)?).map(Some)
    };
    let wall = Stop::new(0, 0.5 * room, RESTITUTION)?;
    let above = wall.clone().with_motion(moving(1.0)?);
    let below = wall.on_side(Side::Lower).with_motion(moving(-1.0)?);
    Scene::new(ball, Forcing::Unforced, [above, below])
}

/// The phase of the box at an impact, by bisection between none and the fold.
fn phase_of(room: f64) -> f64 {
    let (mut low, mut high) = (0.0, PI - (0.5 * PI * RHO).atan());
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if PI * RHO * middle.sin() - 2.0 * middle.cos() < room {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Energies of orbits beside the closed form.
fn check_energies() -> Result<()> {
    println!("room   energy of a period   closed form");
    for room in [3.0, 5.0, 7.0, 9.0, 11.0, 12.0] {
        let theta = phase_of(room);
        let speed = RHO * theta.sin();
        let scene = moving_box(room)?;
        // Just after an impact with the upper wall, on its way down, and a little off.
        let (q, v) = (
            dvector![0.5 * room + theta.cos() - 1e-9],
            dvector![-1.001 * speed],
        );
        let span = (theta, theta + 2.0 * TAU);
        let run = simulate(&scene, &q, &v, span, &SimulateOptions::default())?;
        let orbit = find_orbit(&scene, &run, Some(1))?;
        let found = *orbit
            .energy()?
            .impact_loss
            .last()
            .expect("a period has times");
        let exact = 4.0 * MASS * speed * speed / RHO;
        println!("{room:<5}  {found:.12}       {exact:.12}");
        assert!((found / exact - 1.0).abs() < 1e-9);
    }
    Ok(())
}

/// The largest swing late in a run of a structure at its resonance, with a ball beside it or not.
fn swing(with_ball: bool) -> Result<(f64, usize)> {
    let (mass, damping) = (dvector![1.0, MASS], dvector![0.01, 0.0]);
    let both = LinearSystem::new(mass, damping, dmatrix![1.0, 0.0; 0.0, 0.0])?;
    let wall = Stop::new(dvector![-1.0, 1.0], 0.3, RESTITUTION)?;
    let walls = [wall.clone(), wall.on_side(Side::Lower)];
    let walls = if with_ball {
        walls.to_vec()
    } else {
        Vec::new()
    };
    let force = Harmonic::new(dvector![0.01.into(), 0.0.into()], 1.0, 0.0)?;
    let scene = Scene::new(both, force, walls)?;
    let rest = DVector::zeros(2);
    let span = (0.0, 200.0 * TAU);
    let run = simulate(&scene, &rest, &rest, span, &SimulateOptions::default())?;
    let late: Vec<f64> = (0..5000)
        .map(|k| (150.0 + f64::from(k) / 100.0) * TAU)
        .collect();
    let moved = run.along(0, Some(&late), 0, ImpactSide::After)?;
    let largest = moved.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    Ok((largest, run.impacts().len()))
}

fn main() -> Result<()> {
    check_energies()?;
    let ((damped, impacts), (alone, _)) = (swing(true)?, swing(false)?);
    println!(
        "largest swing late in the run: {damped:.3} with the ball ({impacts} impacts), {alone:.3} without"
    );
    assert!(damped < 0.7 * alone);
    Ok(())
}

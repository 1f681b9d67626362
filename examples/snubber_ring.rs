//! A rotor in a snubber ring: how far an unbalance throws it, up through its critical speed and down again.
//!
//! A disk on a flexible shaft turns with an unbalance inside a ring that gives way by a spring: a stop all around, with the gap
//! `c - sqrt(x^2 + y^2)`, without friction. You will see up to which speed the disk stays in the ring on the way up, from which on it is in it
//! on the way down, every radius beside the closed form of circular whirls, and which of two whirls it settles on after a push.
//! `snubber_ring.py` draws them.

use std::f64::consts::TAU;
use vibroimpact::nalgebra::{Complex, DVector, dvector};
use vibroimpact::{
    GapFunction, Harmonic, ImpactSide, Keep, LinearSystem, Method, Motion, NonlinearStop, Result,
    Scene, SimulateOptions, Solver, Spring, Trajectory, simulate,
};

/// Damping of the shaft, eccentricity over the clearance, stiffness of the ring over that of the shaft.
const RATIO: f64 = 0.05;
const UNBALANCE: f64 = 0.15;
const RING: f64 = 2.0;
/// A speed with two whirls.
const BOTH: f64 = 1.3;

/// The ring of clearance one; at its very middle no direction is that of the gap.
struct Ring;

impl GapFunction for Ring {
    fn gap(&self, q: &[f64]) -> Result<f64> {
        Ok(1.0 - q[0].hypot(q[1]))
    }

    fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
        let radius = q[0].hypot(q[1]);
        let direction = if radius > 0.0 {
            [q[0] / radius, q[1] / radius]
        } else {
            [1.0, 0.0]
        };
        gradient.copy_from_slice(&direction.map(|x| -x));
        Ok(())
    }
}

/// The rotor at a speed; its unbalance pulls along x and, a quarter of a turn later, along y.
fn rotor(speed: f64) -> Result<Scene> {
    let shaft = LinearSystem::new(
        dvector![1.0, 1.0],
        dvector![2.0 * RATIO, 2.0 * RATIO],
        dvector![1.0, 1.0],
    )?;
    let pull = UNBALANCE * speed * speed;
    let unbalance = dvector![Complex::new(pull, 0.0), Complex::new(0.0, -pull)];
    let ring = NonlinearStop::new(Ring, Spring::new(RING, 0.0, None)?)?;
    Scene::new(shaft, Harmonic::new(unbalance, speed, 0.0)?, [ring])
}

/// The radii of all circular whirls, smallest first: `|1 - w^2 + 2 i D w| r = e w^2` inside the ring, in it
/// `((1 + k - w^2) r - k)^2 + (2 D w r)^2 = (e w^2)^2`.
fn whirls(speed: f64) -> Vec<f64> {
    let (force, damping) = (UNBALANCE * speed * speed, 2.0 * RATIO * speed);
    let elastic = 1.0 + RING - speed * speed;
    let (a, b) = (elastic * elastic + damping * damping, RING * elastic);
    let root = (b * b - a * (RING * RING - force * force)).sqrt();
    let mut found = vec![force / (1.0 - speed * speed).hypot(damping)];
    found.retain(|radius| *radius < 1.0);
    let pressed = [(b - root) / a, (b + root) / a];
    found.extend(pressed.into_iter().filter(|radius| *radius > 1.0));
    found
}

/// A motion at a tolerance, for so many turns.
fn turned(
    scene: &Scene,
    state: (&DVector<f64>, &DVector<f64>),
    end: f64,
    keep: Keep,
) -> Result<Trajectory> {
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-9,
            ..Method::Auto.into()
        },
        keep,
        ..SimulateOptions::default()
    };
    simulate(scene, state.0, state.1, (0.0, end), &options)
}

/// The radius after many turns from a state, and the state then.
fn settled(
    speed: f64,
    state: (&DVector<f64>, &DVector<f64>),
) -> Result<(f64, (DVector<f64>, DVector<f64>))> {
    let (scene, period) = (rotor(speed)?, TAU / speed);
    let before = turned(&scene, state, 160.0 * period, Keep::Final)?;
    let run = turned(&scene, before.last(), 2.0 * period, Keep::Motion)?;
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for k in 0..200 {
        let q = run
            .state(run.t_end() * f64::from(k) / 200.0, ImpactSide::After)?
            .0;
        (low, high) = (low.min(q.norm()), high.max(q.norm()));
    }
    assert!(high - low < 1e-3, "the whirl is a circle");
    let (q, v) = run.last();
    Ok((0.5 * (low + high), (q.clone(), v.clone())))
}

/// The largest speed at which the disk is in the ring, the motion going on from one speed to the next.
fn swept(speeds: impl Iterator<Item = f64>) -> Result<f64> {
    let mut state = (DVector::zeros(2), DVector::zeros(2));
    let mut last: f64 = 0.0;
    for speed in speeds {
        let (radius, next) = settled(speed, (&state.0, &state.1))?;
        state = next;
        assert!(
            whirls(speed)
                .iter()
                .any(|known| (known - radius).abs() < 1e-3)
        );
        if radius > 1.0 {
            last = last.max(speed);
        }
    }
    Ok(last)
}

fn main() -> Result<()> {
    let speeds = || (0..=40).map(|k| 0.7 + 0.02 * f64::from(k));
    let (leaves, meets) = (swept(speeds())?, swept(speeds().rev())?);
    println!(
        "in the ring up to w = {leaves:.2} on the way up, from w = {meets:.2} on the way down"
    );
    assert!(leaves > meets);
    let known = whirls(BOTH);
    println!(
        "at w = {BOTH}: whirls of radius {:.4} inside the ring, {:.4} and {:.4} in it",
        known[0], known[1], known[2]
    );
    for (push, wanted) in [(0.0, known[0]), (2.5, known[2])] {
        let (radius, _) = settled(BOTH, (&DVector::zeros(2), &dvector![0.0, push]))?;
        println!("after a push of {push}: radius {radius:.6}");
        assert!((radius - wanted).abs() < 1e-4);
    }
    Ok(())
}

//! The soft impact oscillator: a driven mass before a stop that gives way, from its graze to chaos.
//!
//! `x'' + 0.02 x' + x = 0.7 w^2 cos(w t)`, a base that is shaken, before a stop at x = 1.26 with a spring 29 times as stiff as the
//! oscillator's own and a dashpot, in parallel. You will see the orbits with one short contact that are born where the stop is grazed, with
//! a duration like the square root of the distance and multipliers that go on from those of the free motion; where the bifurcation
//! diagram meets the stop beside the closed form of the graze; and the exponents of chaos beside the sum that the dampers make.
//! `soft_oscillator.py` draws them.

use std::f64::consts::TAU;
use vibroimpact::nalgebra::dvector;
use vibroimpact::{
    Attraction, Axis, BaseMotion, ContactRelease, DiagramOptions, Direction, LinearSystem,
    LyapunovOptions, Motion, OrbitOptions, Parameter, Pattern, Result, Scene, Spring, Stop,
    bifurcation_diagram, lyapunov_exponents, periodic_orbits,
};

const DAMPING: f64 = 0.02;
const AMPLITUDE: f64 = 0.7;
const CLEARANCE: f64 = 1.26;
const STIFFNESS: f64 = 29.0;
const DASHPOT: f64 = 0.3;
/// A frequency of chaos.
const CHAOS: f64 = 0.905;

fn oscillator(frequency: f64) -> Result<Scene> {
    let system = LinearSystem::new(dvector![1.0], dvector![DAMPING], dvector![1.0])?
        .with_influence(dvector![1.0])?;
    let spring = Spring::new(STIFFNESS, DASHPOT, Some(ContactRelease::Gap))?;
    let shaken = BaseMotion::new(AMPLITUDE, frequency, 0.0)?;
    Scene::new(system, shaken, [Stop::new(0, CLEARANCE, spring)?])
}

/// The lowest frequency at which the free motion, of amplitude `a w^2 / sqrt((1 - w^2)^2 + (c w)^2)`, touches the stop: a quadratic in w^2.
fn graze() -> f64 {
    let square = CLEARANCE * CLEARANCE;
    let (a, b) = (
        square - AMPLITUDE * AMPLITUDE,
        square * (2.0 - DAMPING * DAMPING),
    );
    ((b - (b * b - 4.0 * a * square).sqrt()) / (2.0 * a)).sqrt()
}

/// The orbits with one short contact behind the graze.
fn born() -> Result<()> {
    println!(
        "behind the graze   duration   / its root   multipliers                         stable"
    );
    for half_decades in -18..=-7 {
        let distance = 10f64.powf(0.5 * f64::from(half_decades));
        let scene = oscillator(graze() + distance)?;
        let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
        let admissible = found.iter().find(|each| each.is_admissible() == Some(true));
        let orbit = admissible.expect("one orbit is born at the graze");
        let contact = orbit.contacts()?[0];
        let lasts = contact.end - contact.start;
        let stability = orbit.stability()?;
        let own = &stability.orders[0].multipliers;
        let [one, other] = [own[0], own[1]];
        println!(
            "{distance:<16.1e}   {lasts:.6}   {:.4}       {one:.4}, {other:.4}   {:?}",
            lasts / distance.sqrt(),
            stability.is_stable
        );
        // The determinant is what both dampers leave.
        let left = (-DAMPING * orbit.period() - DASHPOT * lasts).exp();
        assert!(((one * other).re - left).abs() < 1e-9);
        assert_eq!(stability.is_stable, Some(half_decades < -7));
    }
    let before = oscillator(graze() - 1e-9)?;
    let found = periodic_orbits(&before, &Pattern::single(0), &OrbitOptions::default())?;
    assert!(found.iter().all(|each| each.is_admissible() == Some(false)));
    Ok(())
}

fn main() -> Result<()> {
    born()?;
    let step = 0.14 / 280.0;
    let values: Vec<f64> = (0..=280).map(|k| 0.79 + step * f64::from(k)).collect();
    let axis = Axis::new(Parameter::Frequency, values);
    let options = DiagramOptions {
        direction: Direction::Both,
        ..DiagramOptions::default()
    };
    let diagram = bifurcation_diagram(&oscillator(0.8)?, &axis, &options)?;
    let lowest = |is_up: bool| {
        let met = (0..diagram.parameter.len())
            .filter(|&k| diagram.is_up[k] == is_up && diagram.n_impacts[k] > 0);
        met.map(|k| diagram.parameter[k])
            .fold(f64::INFINITY, f64::min)
    };
    println!(
        "\nthe stop is met from w = {:.4} on, closed form {:.6}; on the way down it is to w = {:.4}",
        lowest(true),
        graze(),
        lowest(false)
    );
    assert!((lowest(true) - graze()).abs() <= step);
    let options = LyapunovOptions {
        skip: 5000.0,
        ..LyapunovOptions::default()
    };
    let (rest, span) = (dvector![0.0], (0.0, 10_000.0 * TAU / CHAOS));
    let chaos = lyapunov_exponents(&oscillator(CHAOS)?, &rest, &rest, span, &options)?;
    println!(
        "at w = {CHAOS}: {:.4} +- {:.4}, {:.4}; their sum {:.12}, by the dampers {:.12}",
        chaos.exponents[0], chaos.errors[0], chaos.exponents[1], chaos.sum, chaos.expected_sum
    );
    assert_eq!(chaos.verdict, Attraction::Chaotic);
    assert!((chaos.sum - chaos.expected_sum).abs() < 1e-9);
    Ok(())
}

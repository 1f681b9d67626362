//! Random linear scenes of one to three degrees of freedom: derivatives are those of orbits that are solved beside.

use crate::differences::compare;
use crate::random::{Cases, Random};
use crate::scenes::{harmonic, scene};
use vibroimpact::nalgebra::{DMatrix, DVector};
use vibroimpact::{
    Constraint, LinearSystem, OrbitOptions, Parameter, Pattern, PeriodicOrbit, Scene, Side,
    SimulateOptions, Stop, derivatives, find_orbit, periodic_orbits, simulate,
};

fn random_scene(random: &mut Random) -> Scene {
    let n = 1 + random.below(3);
    let positive = |random: &mut Random, size: f64| {
        let half = random.matrix(n);
        (&half * half.transpose() + DMatrix::identity(n, n)) * size
    };
    let mass = positive(random, 1.0);
    let stiffness = positive(random, 1.0);
    let damping = &mass * random.log(0.01, 0.3) + &stiffness * random.log(0.01, 0.1);
    let system = LinearSystem::new(mass, damping, stiffness).expect("valid");
    let force: Vec<f64> = (0..n).map(|_| random.between(0.5, 2.0)).collect();
    let count = 1 + random.below(2);
    let stops = (0..count).map(|i| {
        let side = if i == 0 { Side::Upper } else { Side::Lower };
        let stop = Stop::new(
            random.below(n),
            random.between(-0.1, 0.5),
            random.between(0.3, 0.9),
        );
        stop.expect("valid").on_side(side)
    });
    let stops: Vec<Stop> = stops.collect();
    scene(
        system,
        harmonic(&force, random.between(0.6, 2.5), 0.0),
        stops,
    )
}

/// An orbit of one or two instants, or one that a run comes near.
fn random_orbit(random: &mut Random, scene: &Scene) -> Option<PeriodicOrbit> {
    let patterns = [
        Pattern::single(0),
        Pattern::new(vec![vec![0], vec![scene.stops().len() - 1]]).expect("valid"),
    ];
    let options = OrbitOptions {
        n_periods: 1 + random.below(2),
        ..OrbitOptions::default()
    };
    let pattern = random.of(&patterns);
    let found = periodic_orbits(scene, &pattern, &options).ok()?;
    if let Some(orbit) = found.iter().next() {
        return Some(orbit.clone());
    }
    let rest = DVector::zeros(scene.n_dof());
    let span = (0.0, 300.0 * scene.period()?);
    let run = simulate(scene, &rest, &rest, span, &SimulateOptions::default()).ok()?;
    find_orbit(scene, &run, None).ok()
}

#[test]
fn derivatives_are_those_of_orbits_beside() {
    let cases = Cases::new(1804, 200);
    let (mut orbits, mut compared) = (0, 0);
    for (case, mut random) in cases.each() {
        let scene = random_scene(&mut random);
        let Some(orbit) = random_orbit(&mut random, &scene) else {
            continue;
        };
        let parameters = [
            Parameter::Frequency,
            Parameter::CLEARANCE.of(0),
            Parameter::RESTITUTION.of(0),
            Parameter::ForcingScale,
            Parameter::DampingScale,
        ];
        let found = derivatives(&orbit, &parameters).expect("derivatives");
        let own = orbit.scene();
        let Constraint::Stop(stop) = &own.stops()[0] else {
            unreachable!("made above");
        };
        let frequency = own.forcing().frequency().expect("forced");
        let values = [
            frequency,
            stop.clearance(),
            stop.restitution().expect("rigid").value(),
            1.0,
            1.0,
        ];
        let mut count = 0;
        for (i, (&parameter, value)) in parameters.iter().zip(values).enumerate() {
            let make = |offset: f64| own.replace(parameter.change(value + offset));
            let name = format!("case {case}, {parameter}");
            count += compare(&orbit, (&found, i), &make, (5e-4, 1e-6, 0.0), &name);
        }
        orbits += usize::from(count > 0);
        compared += count;
    }
    println!("{orbits} orbits, {compared} numbers");
    assert!(cases.have(orbits, 75), "{orbits}");
    assert!(compared > 40 * orbits, "{compared}");
}

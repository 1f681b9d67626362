//! Derivatives of random orbits with lasting contact and impacts that accumulate, against orbits that are solved beside them.

use crate::differences::compare;
use crate::random::{Cases, Random};
use crate::scenes::{harmonic, linear, loaded, scene, upper};
use nalgebra::{DMatrix, DVector, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    Harmonic, Motion, Parameter, Reaction, Scene, SegmentKind, SimulateOptions, StopMotion,
    derivatives, find_orbit, simulate,
};

const SEED: u64 = 57;
const COUNT: usize = 30;
/// Steps in parts of the scale of a number, tolerance and floor of a comparison.
const STEP: f64 = 2e-4;
const ROOM: (f64, f64) = (1e-4, 1.0);

fn drawn(random: &mut Random) -> (Scene, f64) {
    let n = 1 + random.below(3);
    let root = random.matrix(n);
    let mass = &root * root.transpose() * 0.5 + DMatrix::identity(n, n);
    let root = random.matrix(n);
    let stiffness = &root * root.transpose() + DMatrix::identity(n, n) * 0.3;
    let damping = &stiffness * 0.15 + &mass * 0.05;
    let mut load = random.vector(n);
    load[0] += random.between(0.5, 3.0);
    let w = random.between(0.4, 2.0);
    let restitution = random.between(0.2, 0.85);
    let mut stop = upper(0, random.between(0.1, 0.6), restitution);
    if random.chance(30) {
        stop = stop.with_reaction(Reaction::Coordinate).expect("valid");
    }
    if random.chance(20) {
        let motion = Harmonic::new(dvector![0.05.into()], w, random.between(0.0, TAU));
        let motion = StopMotion::harmonic(motion.expect("valid")).expect("valid");
        stop = stop.with_motion(Some(motion));
    }
    let mut stops = vec![stop];
    if random.chance(40) {
        let mut normal = DVector::zeros(n);
        normal[0] = -1.0;
        stops.push(upper(normal, random.between(0.1, 0.6), 0.4));
    }
    let force: Vec<f64> = random.vector(n).iter().map(|x| 3.0 * x).collect();
    let system = loaded(linear(mass, damping, stiffness), load.as_slice());
    (scene(system, harmonic(&force, w, 0.3), stops), restitution)
}

#[test]
fn they_are_the_differences_of_orbits_beside() {
    let cases = Cases::new(SEED, COUNT);
    let (mut compared, mut accumulated) = (0, 0);
    for (number, mut random) in cases.each() {
        let (own, restitution) = drawn(&mut random);
        let zero = DVector::zeros(own.n_dof());
        let end = 60.0 * own.period().expect("forced");
        let run = simulate(&own, &zero, &zero, (0.0, end), &SimulateOptions::default());
        let Ok(orbit) = find_orbit(&own, &run.expect("a run"), None) else {
            continue;
        };
        let all = [
            (Parameter::RESTITUTION.of(0), restitution, 1.0 - restitution),
            (Parameter::ForcingScale, 1.0, 1.0),
            (
                Parameter::Frequency,
                TAU / own.period().expect("forced"),
                1.0,
            ),
        ];
        let numbers = all.map(|own| own.0);
        let found = derivatives(&orbit, &numbers).expect("an answer");
        let mut here = 0;
        for (i, (parameter, value, scale)) in all.into_iter().enumerate() {
            let make = |offset: f64| orbit.scene().replace(parameter.change(value + offset));
            let steps = (STEP * scale, ROOM.0, ROOM.1);
            let case = format!("{number}, {parameter}");
            here += compare(&orbit, (&found, i), &make, steps, &case);
        }
        compared += here;
        let segments = orbit.segments().expect("kept");
        let is_chatter = segments.iter().any(|own| own.kind == SegmentKind::Chatter);
        accumulated += if is_chatter { here } else { 0 };
    }
    assert!(cases.have(compared, 1000), "{compared}");
    assert!(cases.have(accumulated, 500), "{accumulated}");
}

//! Objectives: the gradient is that of the value, by whichever way it is asked.

use crate::scenes::{harmonic, scene, unit_mass, upper};
use vibroimpact::{
    Error, Objective, ObjectiveValue, OrbitEntry, OrbitOptions, Pattern, PeriodicOrbit, Result,
    Scene, periodic_orbits,
};

const START: [f64; 2] = [1.0, 0.8];

fn make(p: &[f64]) -> Result<Scene> {
    if p[1] > 1.0 {
        return Err(Error::bad_value("p", p[1], "a restitution is at most 1"));
    }
    let forcing = harmonic(&[8.5], 2.4, 0.0);
    Ok(scene(unit_mass(0.1, 1.0), forcing, [upper(0, p[0], p[1])]))
}

fn orbit() -> PeriodicOrbit {
    let scene = make(&START).expect("valid");
    let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
    found.expect("a search").into_iter().next().expect("one")
}

fn of(value: ObjectiveValue<'_>) -> Objective<'_> {
    Objective {
        make: &make,
        value,
        orbit: orbit(),
        p: START.to_vec(),
    }
}

#[test]
fn gradients_are_those_of_the_values() {
    for name in [
        "speeds_before[0]",
        "times[0]",
        "max_displacement[0]",
        "v0[0]",
        "phase",
        "period",
    ] {
        let entry = OrbitEntry::of(name, &orbit()).expect("an entry");
        let mut own = of(ObjectiveValue::Entry(entry));
        let p = [1.1, 0.7];
        let (_, gradient) = own.at(&p).expect("a value");
        for k in 0..2 {
            let step = 1e-5;
            let mut beside = [p, p];
            beside[0][k] -= step;
            beside[1][k] += step;
            let [low, high] = beside.map(|p| own.at(&p).expect("a value").0);
            let off = gradient[k] - (high - low) / (2.0 * step);
            assert!(
                off.abs() < 1e-6 * (1.0 + gradient[k].abs()),
                "{name} by {k}: {off:e}"
            );
        }
        assert_eq!(own.p[0], p[0]);
    }
}

#[test]
fn a_function_of_an_entry_gives_what_the_entry_gives() {
    let entry = OrbitEntry::of("speeds_before[0]", &orbit()).expect("an entry");
    let by_entry = of(ObjectiveValue::Entry(entry)).at(&[1.2, 0.75]);
    let function = |orbit: &PeriodicOrbit, found: &vibroimpact::OrbitDerivatives| {
        let row = found.speeds_before.row(0).into_owned();
        Ok((orbit.impacts()[0].approach, row.as_slice().to_vec()))
    };
    let by_function = of(ObjectiveValue::Function(&function)).at(&[1.2, 0.75]);
    assert_eq!(by_entry, by_function);
}

#[test]
fn what_there_is_not_is_refused_and_the_orbit_stays() {
    let orbit = orbit();
    for name in [
        "",
        "speed",
        "speeds_before",
        "speeds_before[1]",
        "period[0]",
        "q0[x]",
        "q0[0",
    ] {
        let refused = OrbitEntry::of(name, &orbit);
        assert!(matches!(refused, Err(Error::BadValue { .. })), "{name}");
    }
    let entry = OrbitEntry::of("phase", &orbit).expect("an entry");
    let mut own = of(ObjectiveValue::Entry(entry));
    for p in [&[1.0][..], &[1.0, f64::NAN], &[1.0, 1.5]] {
        assert!(own.at(p).is_err());
        assert_eq!(own.p, START);
    }
}

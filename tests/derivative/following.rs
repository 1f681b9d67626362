//! An orbit followed from some numbers of its scene to others.

use crate::scenes::{harmonic, scene, unit_mass, upper};
use std::ops::ControlFlow;
use vibroimpact::{
    Error, OrbitOptions, Parameter, Pattern, PeriodicOrbit, Result, Scene, follow_orbit,
    periodic_orbits, with_observer,
};

fn make(p: &[f64]) -> Result<Scene> {
    let forcing = harmonic(&[1.0], p[1], 0.0);
    let unit = scene(unit_mass(0.1, 1.0), forcing, [upper(0, 1.0, 0.8)]);
    unit.replace(Parameter::ForcingScale.change(p[0]))
}

fn orbits(p: &[f64]) -> Vec<PeriodicOrbit> {
    let scene = make(p).expect("valid");
    let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
    found.expect("a search").into_iter().collect()
}

#[test]
fn a_long_way_leads_to_the_orbit_of_its_end() {
    let start = [8.5, 2.4];
    for end in [[8.6, 2.4], [30.0, 2.2], [9.0, 3.5], [6.0, 2.3]] {
        let orbit = &orbits(&start)[0];
        let found = follow_orbit(orbit, &make, (&start, &end)).expect("an orbit");
        let known = orbits(&end);
        let off = |own: &PeriodicOrbit| {
            (own.v0() - found.v0()).norm() + (own.phase() - found.phase()).abs()
        };
        assert!(known.iter().any(|own| off(own) < 1e-9), "{end:?}");
    }
}

#[test]
fn where_there_is_no_orbit_that_is_said() {
    let start = [8.5, 2.4];
    let orbit = &orbits(&start)[0];
    // Too little force to reach the stop.
    let found = follow_orbit(orbit, &make, (&start, &[0.0, 2.4]));
    assert!(
        matches!(found, Err(Error::NoConvergence { .. })),
        "{found:?}"
    );
    let follow = || follow_orbit(orbit, &make, (&start, &[9.0, 2.4]));
    let found = with_observer(|_| ControlFlow::Break(()), follow);
    assert_eq!(found.err(), Some(Error::Interrupted));
}

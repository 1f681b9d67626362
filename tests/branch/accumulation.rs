//! Grazes that accumulate towards the border of a chatter.

use crate::scenes::{USUAL, followed};
use std::ops::ControlFlow;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    ContinuationOptions, Error, Harmonic, Heading, LinearSystem, Parameter, PeriodicOrbit, Scene,
    SimulateOptions, Special, SpecialKind, Stop, accumulation, find_orbit, simulate, with_observer,
};

/// The motion of `x'' + x = cos w t` before a stop, from rest.
fn motion(w: f64, clearance: f64, restitution: f64) -> PeriodicOrbit {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], w, 0.0).expect("valid");
    let stop = Stop::new(0, clearance, restitution).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let (start, rest) = (dvector![-0.5], dvector![0.0]);
    let long = (0.0, 80.0 * std::f64::consts::TAU / w);
    let run = simulate(&scene, &start, &rest, long, &SimulateOptions::default());
    find_orbit(&scene, &run.expect("a run"), None).expect("an orbit")
}

fn first_of(
    kind: SpecialKind,
    orbit: &PeriodicOrbit,
    (heading, range): (Heading, (f64, f64)),
) -> Special {
    let options = ContinuationOptions {
        heading,
        ..Default::default()
    };
    let branch = followed(orbit, Parameter::CLEARANCE, range, &options);
    let found = branch.special.iter().find(|own| own.kind == kind);
    found
        .unwrap_or_else(|| panic!("no {kind:?}: {:?}", branch.ends))
        .clone()
}

fn border_from(graze: &Special, range: (f64, f64)) -> Special {
    let found = accumulation(graze, Parameter::CLEARANCE, range);
    found.expect("a search").expect("a border")
}

#[test]
fn grazes_accumulate_at_the_border_that_is_known() {
    // By bisection, whether the impacts behind a release come to rest before the next, in 34 digits.
    for (w, clearance, restitution, known, enough) in [
        (0.3, 0.15, 0.8, 0.123_448_597_848_029_15, 1e-6),
        (0.5, 0.245, 0.5, 0.231_461_027_029_044_54, 1e-8),
    ] {
        let range = (known - 0.1, known + 0.2);
        let orbit = motion(w, clearance, restitution);
        let graze = first_of(SpecialKind::Graze, &orbit, (Heading::Down, range));
        let border = border_from(&graze, range);
        let off = (border.parameter - known).abs();
        assert_eq!(border.kind, SpecialKind::ChatterBorder);
        assert!(
            off < border.error && border.error < enough,
            "{restitution}: {off:e} {:e}",
            border.error
        );
        let more = border.orbit.impacts().len() - graze.orbit.impacts().len();
        assert!(more > 15, "{more}");
    }
}

#[test]
fn a_border_is_the_same_from_both_sides() {
    for (w, restitution, apart, held, range) in [
        (0.5, 0.5, 0.245, 0.2, (0.1, 0.4)),
        (0.3, 0.6, 0.59, 0.5, (0.45, 0.85)),
        (0.3, 0.75, 0.2488, 0.2, (0.15, 0.5)),
    ] {
        let orbit = motion(w, apart, restitution);
        let graze = first_of(SpecialKind::Graze, &orbit, (Heading::Down, range));
        let of_impacts = border_from(&graze, range);
        let held = motion(w, held, restitution);
        let of_stick = first_of(SpecialKind::ChatterBorder, &held, (Heading::Up, range));
        let off = (of_impacts.parameter - of_stick.parameter).abs();
        assert!(
            off <= of_impacts.error + of_stick.error && of_impacts.error < 1e-6,
            "{restitution}: {off:e} {:e} {:e}",
            of_impacts.error,
            of_stick.error
        );
    }
}

#[test]
fn other_grazes_do_not_accumulate() {
    // The motion that hits nothing touches the stop; behind that no impacts follow each other.
    let orbit = &USUAL.orbits(1)[0];
    let options = ContinuationOptions::default();
    let range = (0.1, 2.0);
    let branch = followed(orbit, Parameter::ForcingScale, range, &options);
    let lost = branch
        .special
        .iter()
        .find(|own| own.kind == SpecialKind::LostImpact);
    let lost = lost.expect("one");
    let refused = accumulation(lost, Parameter::ForcingScale, range);
    let error = refused.expect_err("no graze").to_string();
    assert!(
        error.contains("special is lost_impact") && error.contains("graze"),
        "{error}"
    );
    let born = vibroimpact::branches(lost, Parameter::ForcingScale, range).expect("branches");
    let free = born
        .iter()
        .find(|own| own.orbit.impacts().is_empty())
        .expect("one");
    let up = ContinuationOptions {
        heading: Heading::Up,
        ..options
    };
    // A factor counts from the scene of an orbit.
    let branch = followed(&free.orbit, Parameter::ForcingScale, (0.9, 1.1), &up);
    let graze = branch.special.last().expect("a graze");
    assert_eq!(graze.kind, SpecialKind::Graze);
    let found = accumulation(graze, Parameter::ForcingScale, (0.9, 1.1));
    assert!(found.expect("a search").is_none());
}

#[test]
fn a_search_is_broken_off() {
    let range = (0.1, 0.4);
    let orbit = motion(0.5, 0.245, 0.5);
    let graze = first_of(SpecialKind::Graze, &orbit, (Heading::Down, range));
    let search = || accumulation(&graze, Parameter::CLEARANCE, range);
    let found = with_observer(|_| ControlFlow::Break(()), search);
    assert!(matches!(found, Err(Error::Interrupted)));
}

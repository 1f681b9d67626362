//! Where an orbit has no derivatives it says so: not a number, with the reason, never a large number.

use crate::scenes::{harmonic, linear, periods, scene, shaken_ball, unit_mass, upper};
use vibroimpact::nalgebra::{DVector, dvector};
use vibroimpact::{
    Branch, Change, ContinuationOptions, Error, Motion, OrbitDerivatives, Parameter, Pattern,
    PeriodicOrbit, Scene, SegmentKind, SimulateOptions, SpecialKind, StopNumber, continuation,
    derivatives, derivatives_of, find_orbit, periodic_orbits, simulate,
};

fn one_stop(force: f64, frequency: f64, clearance: f64) -> Scene {
    let forcing = harmonic(&[force], frequency, 0.0);
    scene(unit_mass(0.1, 1.0), forcing, [upper(0, clearance, 0.8)])
}

fn orbit_of(scene: &Scene) -> PeriodicOrbit {
    let found = periodic_orbits(scene, &Pattern::single(0), &periods(1));
    found.expect("a search")[0].clone()
}

fn followed(orbit: &PeriodicOrbit, number: Parameter, range: (f64, f64)) -> Branch {
    let options = ContinuationOptions::default();
    continuation(orbit, number, range, &options).expect("a branch")
}

fn at_special(branch: &Branch, kind: SpecialKind) -> &PeriodicOrbit {
    let found = branch.special.iter().find(|own| own.kind == kind);
    &found
        .unwrap_or_else(|| panic!("no {kind:?}: {:?}", branch.ends))
        .orbit
}

/// Nothing is a number, and the reason has these words.
fn check_none(found: &OrbitDerivatives, words: &str) {
    let numbers = [
        &found.q0,
        &found.v0,
        &found.speeds_before,
        &found.times,
        &found.min_gap,
        &found.max_displacement,
    ];
    assert!(numbers.iter().all(|own| own.iter().all(|x| x.is_nan())));
    assert!(
        found
            .phase
            .iter()
            .chain(found.period.iter())
            .all(|x| x.is_nan())
    );
    assert!(found.multipliers.iter().all(|mu| mu.re.is_nan()));
    assert!(found.reason.contains(words), "{}", found.reason);
}

#[test]
fn a_fold_has_none() {
    let orbit = orbit_of(&one_stop(1.0, 2.8, -0.5));
    let branch = followed(&orbit, Parameter::ForcingScale, (0.2, 5.0));
    let fold = at_special(&branch, SpecialKind::Fold);
    let found = derivatives(fold, &[Parameter::ForcingScale, Parameter::RESTITUTION]);
    check_none(&found.expect("an answer"), "at a fold");
    // Beside it they are large, and right.
    let near = branch.orbits.iter().min_by(|a, b| {
        let away =
            |own: &PeriodicOrbit| (own.q0() - fold.q0()).norm() + (own.v0() - fold.v0()).norm();
        let far = |own: &PeriodicOrbit| {
            if away(own) < 1e-3 {
                f64::INFINITY
            } else {
                away(own)
            }
        };
        far(a).total_cmp(&far(b))
    });
    let found = derivatives(near.expect("one"), &[Parameter::ForcingScale]).expect("an answer");
    assert!(
        found.reason.is_empty() && found.v0[(0, 0)].abs() > 3.0,
        "{found:?}"
    );
}

#[test]
fn a_graze_has_none() {
    // An orbit that hits its stop, which another stop nearly touches.
    let one = one_stop(8.5, 2.4, 1.0);
    let orbit = orbit_of(&one);
    let lowest = -orbit.max_displacement().expect("positions")[0];
    let mut stops = one.stops().to_vec();
    let touched = upper(dvector![-1.0], -lowest, 0.5);
    stops.push(touched.into());
    let both = one.replace(Change::Stops(stops)).expect("valid");
    let touching = find_orbit(&both, &orbit, None).expect("found");
    let found = derivatives(&touching, &[Parameter::Frequency]).expect("an answer");
    check_none(&found, "grazes stop 1");
    // An impact that has lost its speed.
    let branch = followed(&orbit, Parameter::ForcingScale, (0.1, 1.2));
    let last = at_special(&branch, SpecialKind::LostImpact);
    let found = derivatives(last, &[Parameter::ForcingScale]).expect("an answer");
    check_none(&found, "grazes stop 0");
}

#[test]
fn stops_that_are_hit_together_have_none() {
    let forcing = harmonic(&[8.5, 8.5], 2.4, 0.0);
    let same = |x: f64| dvector![x, x];
    let system = linear(same(1.0), same(0.1), same(1.0));
    let both = scene(system, forcing, [upper(0, 1.0, 0.8), upper(1, 1.0, 0.8)]);
    let pattern = Pattern::new(vec![vec![0, 1]]).expect("valid");
    let found = periodic_orbits(&both, &pattern, &periods(1)).expect("a search");
    let found = derivatives(&found[0], &[Parameter::Frequency]).expect("an answer");
    check_none(&found, "hits stops 0 and 1 together");
}

#[test]
fn a_contact_without_duration_has_none() {
    let scene = shaken_ball(0.5, 1.3, 0.0);
    let span = (0.0, 12.0 * scene.period().expect("forced"));
    let run = simulate(
        &scene,
        &dvector![0.3],
        &dvector![0.0],
        span,
        &SimulateOptions::default(),
    );
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let branch = followed(&orbit, Parameter::ForcingScale, (0.8, 3.0));
    let from = *branch.parameter.last().expect("one");
    let mut last = branch.orbits.last().expect("one").clone();
    let duration = |orbit: &PeriodicOrbit| -> f64 {
        let segments = orbit.segments().expect("kept");
        let held = segments.iter().filter(|own| own.kind == SegmentKind::Stick);
        held.map(|own| own.end - own.start).sum()
    };
    // Short contacts have large derivatives, right up to the border, which is sought by halves.
    let found = derivatives(&last, &[Parameter::ForcingScale]).expect("an answer");
    assert!(duration(&last) < 1e-3 && found.times.amax() > 10.0 && found.reason.is_empty());
    let (mut low, mut high) = (0.0, 1e-5);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let there = scene.replace(Parameter::ForcingScale.change(from + middle));
        match find_orbit(&there.expect("valid"), &last, None) {
            Ok(found) => (low, last) = (middle, found),
            Err(_) => high = middle,
        }
    }
    assert!(duration(&last) < 1e-6);
    let found = derivatives(&last, &[Parameter::ForcingScale]).expect("an answer");
    check_none(&found, "one-sided only");
}

#[test]
fn a_family_has_none() {
    // Elastic impacts without damping or forcing: an orbit for each energy.
    let scene = scene(
        unit_mass(0.0, 1.0),
        vibroimpact::Forcing::Unforced,
        [upper(0, 0.3, 1.0)],
    );
    let run = simulate(
        &scene,
        &dvector![0.3],
        &dvector![-1.0],
        (0.0, 40.0),
        &SimulateOptions::default(),
    );
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let found = derivatives(&orbit, &[Parameter::CLEARANCE]).expect("an answer");
    check_none(&found, "one of a family");
}

#[test]
fn multipliers_that_meet_have_none() {
    // Two coordinates alike and apart from each other: each multiplier is there twice.
    let forcing = harmonic(&[8.5, 1.0], 2.4, 0.0);
    let same = |x: f64| dvector![x, x];
    let system = linear(same(1.0), same(0.1), same(1.0));
    let apart = scene(system, forcing, [upper(0, 1.0, 0.8)]);
    let orbit = orbit_of(&apart);
    let found = derivatives(&orbit, &[Parameter::Frequency]).expect("an answer");
    // The free coordinate's pair is simple.
    assert!(found.reason.is_empty(), "{}", found.reason);
    let three = |x: f64| DVector::from_element(3, x);
    let forcing = harmonic(&[8.5, 1.0, 1.0], 2.4, 0.0);
    let system = linear(three(1.0), three(0.1), three(1.0));
    let apart = scene(system, forcing, [upper(0, 1.0, 0.8)]);
    let found = derivatives(&orbit_of(&apart), &[Parameter::Frequency]).expect("an answer");
    let count = found.multipliers.iter().filter(|mu| mu.re.is_nan()).count();
    assert_eq!(count, 4);
    assert!(found.reason.contains("one of several"), "{}", found.reason);
    assert!(
        found
            .v0
            .iter()
            .chain(found.q0.iter())
            .all(|x| x.is_finite())
    );
}

#[test]
fn an_extreme_at_two_places_has_none() {
    // Between two stops alike: farthest from zero at both impacts, of which only one stop moves.
    let stops = [
        upper(0, 0.4, 0.7),
        upper(0, 0.4, 0.7).on_side(vibroimpact::Side::Lower),
    ];
    let room = scene(unit_mass(0.1, 1.0), harmonic(&[3.0], 1.7, 0.0), stops);
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let found = periodic_orbits(&room, &pattern, &periods(1)).expect("a search");
    let numbers = [Parameter::CLEARANCE.of(0), Parameter::CLEARANCE];
    let found = derivatives(&found[0], &numbers).expect("an answer");
    assert!(found.max_displacement[(0, 0)].is_nan());
    assert!((found.max_displacement[(0, 1)] - 1.0).abs() < 1e-9);
    let words = "coordinate 0 is farthest from zero at several times";
    assert!(found.reason.contains(words), "{}", found.reason);
}

#[test]
fn a_number_at_the_end_of_its_range_has_one_of_one_side() {
    let orbit = |e: f64| {
        orbit_of(
            &one_stop(8.5, 2.4, 1.0)
                .replace(Parameter::RESTITUTION.change(e))
                .expect("valid"),
        )
    };
    for (e, side) in [(0.0, 1.0), (1.0, -1.0)] {
        let found = derivatives(&orbit(e), &[Parameter::RESTITUTION]).expect("an answer");
        let speed = |steps: f64| orbit(e + side * 1e-4 * steps).impacts()[0].approach;
        let rate = (-1.5 * speed(0.0) + 2.0 * speed(1.0) - 0.5 * speed(2.0)) / (side * 1e-4);
        let own = found.speeds_before[(0, 0)];
        assert!((own / rate - 1.0).abs() < 1e-6, "{e}: {own} {rate}");
    }
}

#[test]
fn bad_numbers_are_refused() {
    let scene = one_stop(8.5, 2.4, 1.0);
    let orbit = orbit_of(&scene);
    let said = |found: Result<OrbitDerivatives, Error>| found.expect_err("refused").to_string();
    assert!(said(derivatives(&orbit, &[Parameter::Phase])).contains("shifts time alone"));
    assert!(
        said(derivatives(&orbit, &[Parameter::CLEARANCE.of(3)]))
            .contains("must be a number that the scene")
    );
    let make = |p: &[f64]| scene.replace(Change::EachStop(StopNumber::Clearance, vec![p[0]]));
    assert!(said(derivatives_of(&orbit, &make, &[1.2])).contains("does not close"));
    assert!(said(derivatives_of(&orbit, &make, &[f64::NAN])).contains("finite"));
    let none = derivatives(&orbit, &[]).expect("nothing to do");
    assert_eq!(none.q0.shape(), (1, 0));
}

#[test]
fn a_multiplier_that_is_alone_has_one_however_large() {
    // Just above where the impact has no speed: it multiplies deviations by something like 1/speed.
    let lost = 4.766_046_580_17;
    let slowest = |force: f64| {
        let found = periodic_orbits(&one_stop(force, 2.4, 1.0), &Pattern::single(0), &periods(1));
        let found = found.expect("a search");
        let speed = |own: &&PeriodicOrbit| own.impacts()[0].approach.abs();
        let slow = found.iter().min_by(|a, b| speed(a).total_cmp(&speed(b)));
        slow.expect("one").clone()
    };
    let largest = |force: f64| {
        let orbit = slowest(force);
        let stability = orbit.stability().expect("multipliers");
        stability.orders[0].multipliers[0].re
    };
    let mut huge = 0;
    for above in [1e-3, 1e-4, 1e-5, 3e-6] {
        let force = lost * (1.0 + above);
        let found = derivatives(&slowest(force), &[Parameter::ForcingScale]).expect("an answer");
        assert!(found.reason.is_empty(), "{above}: {}", found.reason);
        let own = found.multipliers[(0, 0)];
        let step = 0.02 * above;
        let difference =
            |h: f64| (largest(force * (1.0 + h)) - largest(force * (1.0 - h))) / (2.0 * h);
        let expected = (4.0 * difference(step) - difference(2.0 * step)) / 3.0;
        assert!(
            (own.re / expected - 1.0).abs() < 1e-4,
            "{above}: {own} {expected}"
        );
        huge += usize::from(largest(force).abs() > 1e5);
    }
    assert!(huge > 0);
}

//! Branches through touches of stops that give way, against closed forms of the motion without contact and the numbers of the references.

use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Branch, ContactRelease, ContinuationOptions, Guess, Harmonic, LinearSystem, Motion,
    OrbitOptions, Parameter, Pattern, PeriodicOrbit, Scene, Special, SpecialKind, Spring, Stop,
    TouchOutcome, continuation, find_orbit, periodic_orbits,
};

/// The scene of G12 and G18 of the references: `x'' + 0.1 x' + x = cos 0.8 t`, a stop at 0.5.
fn scene_of(release: ContactRelease, preload: f64, forcing: f64) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let law = Spring::new(20.0, 0.5, Some(release)).expect("valid");
    let law = law.with_preload(preload).expect("valid");
    let force = Harmonic::new(dvector![forcing.into()], 0.8, 0.0).expect("valid");
    let stop = Stop::new(0, 0.5, law).expect("valid");
    Scene::new(system, force, [stop]).expect("valid")
}

/// The forcing at which the motion without contact touches the stop.
fn touching() -> f64 {
    0.5 * (0.36f64.powi(2) + 0.08f64.powi(2)).sqrt()
}

fn met(scene: &Scene) -> PeriodicOrbit {
    let all = periodic_orbits(scene, &Pattern::single(0), &OrbitOptions::default());
    let all = all.expect("orbits");
    let own = all.iter().find(|own| own.is_admissible() == Some(true));
    own.expect("one is admissible").clone()
}

fn apart(scene: &Scene) -> PeriodicOrbit {
    let (q, v) = (dvector![0.0], dvector![0.0]);
    let guess = Guess::State {
        q: &q,
        v: &v,
        period: None,
    };
    find_orbit(scene, guess, Some(1)).expect("an orbit")
}

fn followed(orbit: &PeriodicOrbit, between: (f64, f64)) -> Branch {
    continuation(
        orbit,
        Parameter::ForcingScale,
        between,
        &ContinuationOptions::default(),
    )
    .expect("a branch")
}

fn special(branch: &Branch, kind: SpecialKind) -> &Special {
    let found = branch.special.iter().find(|own| own.kind == kind);
    found.unwrap_or_else(|| panic!("no {}: {:?}", kind.name(), branch.ends))
}

#[test]
fn a_branch_goes_through_a_touch_from_both_sides() {
    for (release, kind) in [
        (ContactRelease::Gap, SpecialKind::Touch),
        (ContactRelease::Force, SpecialKind::BorderCollision),
        (ContactRelease::Clipped, SpecialKind::BorderCollision),
    ] {
        let scene = scene_of(release, 0.0, 1.0);
        let down = followed(&met(&scene), (0.05, 2.0));
        let weak = scene_of(release, 0.0, 0.1);
        let up = followed(&apart(&weak), (0.5, 20.0));
        for (branch, unit) in [(&down, 1.0), (&up, 0.1)] {
            let touch = special(branch, kind);
            let off = touch.parameter * unit - touching();
            assert!(off.abs() < 1e-14, "{release:?}: {off:e}");
            // Contacts on one side alone.
            for (orbit, value) in branch.orbits.iter().zip(&branch.parameter) {
                let has_contact = !orbit.contacts().expect("contacts").is_empty();
                assert_eq!(has_contact, *value > touch.parameter, "{release:?} {value}");
                assert_eq!(orbit.is_admissible(), Some(true), "{release:?} {value}");
            }
            let ends = branch.parameter.iter().copied();
            assert!(ends.fold(0.0, f64::max) * unit > 1.99, "{:?}", branch.ends);
        }
        // The doubling that follows is the same one, whichever way it is come to.
        let [one, other] = [&down, &up].map(|own| special(own, SpecialKind::PeriodDoubling));
        let off = one.parameter - 0.1 * other.parameter;
        assert!(off.abs() < 1e-12, "{release:?}: {off:e}");
    }
}

#[test]
fn multipliers_beside_a_touch_are_those_of_the_references() {
    let branch = followed(
        &met(&scene_of(ContactRelease::Force, 0.0, 1.0)),
        (0.05, 2.0),
    );
    let touch = special(&branch, SpecialKind::BorderCollision);
    let own = touch.touch.as_ref().expect("multipliers");
    let [before, after] = own.traces();
    // Without contact the trace is that of a damped oscillator.
    let (period, decay) = (std::f64::consts::TAU / 0.8, 0.05);
    let free = 2.0 * f64::exp(-decay * period) * ((1.0f64 - decay * decay).sqrt() * period).cos();
    assert!((before - free).abs() < 1e-13, "{before}");
    // G18.
    assert!((after - -0.324_756_224_549_594).abs() < 1e-13, "{after}");
    assert_eq!(own.outcome(), TouchOutcome::Persists);
    // The other way round before and behind are exchanged.
    let other = followed(
        &apart(&scene_of(ContactRelease::Force, 0.0, 0.1)),
        (0.5, 20.0),
    );
    let other = special(&other, SpecialKind::BorderCollision)
        .touch
        .as_ref()
        .expect("multipliers");
    assert!((other.traces()[1] - after).abs() < 1e-13);
}

#[test]
fn a_rule_of_numbers_decides() {
    let decided = [
        ([0, 1], [0, 0], TouchOutcome::Fold),
        ([1, 1], [0, 1], TouchOutcome::Doubling),
        ([2, 0], [1, 1], TouchOutcome::Persists),
        ([1, 2], [0, 1], TouchOutcome::Fold),
    ];
    for (above, below, outcome) in decided {
        assert_eq!(TouchOutcome::of_counts(above, below), outcome);
    }
}

#[test]
fn a_preload_ends_a_branch_as_an_impact_does() {
    let scene = scene_of(ContactRelease::Gap, 0.3, 1.0);
    let down = followed(&met(&scene), (0.05, 2.0));
    let lost = special(&down, SpecialKind::LostImpact);
    assert!(
        (lost.parameter - touching()).abs() < 1e-13,
        "{}",
        lost.parameter
    );
    // The last orbit is beside it.
    assert!(
        (down.parameter[0] - touching()).abs() < 1e-3,
        "{}",
        down.parameter[0]
    );
    let weak = scene_of(ContactRelease::Gap, 0.3, 0.1);
    let graze = followed(&apart(&weak), (0.5, 20.0));
    let graze = special(&graze, SpecialKind::Graze);
    assert!((0.1 * graze.parameter - touching()).abs() < 1e-14);
}

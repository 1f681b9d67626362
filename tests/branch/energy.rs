//! Families of motions that keep their energy, which is their number.

use crate::motions::check_retraced;
use crate::random::Random;
use crate::scenes::USUAL;
use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Branch, Candidate, ContinuationOptions, ContinuationParameter, EndReason, Error, Forcing,
    Guess, LinearSystem, Motion, PendulumChain, PeriodicOrbit, Result, Scene, SimulateOptions,
    SpecialKind, Stop, System, Wall, WallSide, branches, continuation_over_energy, find_orbit,
    simulate,
};

fn scene(system: impl Into<System>, stops: &[Stop]) -> Scene {
    Scene::new(system, Forcing::Unforced, stops.to_vec()).expect("valid")
}

fn upper(coordinate: usize, clearance: f64) -> Stop {
    Stop::new(coordinate, clearance, 1.0).expect("valid")
}

fn orbit(scene: &Scene, q: &[f64], v: &[f64], period: f64) -> PeriodicOrbit {
    let (q, v) = (&DVector::from_row_slice(q), &DVector::from_row_slice(v));
    let period = Some(period);
    find_orbit(scene, Guess::State { q, v, period }, None).expect("an orbit")
}

fn tried(orbit: &PeriodicOrbit, between: (f64, f64)) -> Result<Branch> {
    continuation_over_energy(orbit, between, &ContinuationOptions::default())
}

fn followed(orbit: &PeriodicOrbit, between: (f64, f64)) -> Branch {
    let branch = tried(orbit, between).expect("a family");
    for (own, energy) in branch.orbits.iter().zip(&branch.parameter) {
        let all = own.energy().expect("a ledger");
        for (kinetic, potential) in all.kinetic.iter().zip(&all.potential) {
            let off = (kinetic + potential) / energy - 1.0;
            assert!(off.abs() < 1e-9, "{energy}: {off:e}");
        }
    }
    branch
}

#[test]
fn one_mass_has_its_backbone() {
    let mut random = Random::new(41);
    for _ in 0..40 {
        let (k, d) = (random.between(0.2, 5.0), random.between(-1.0, 1.0));
        let scale = 10f64.powf(random.between(-6.0, 6.0));
        let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![k]).expect("valid");
        let w = k.sqrt();
        let period = |amplitude: f64| 2.0 * (PI - (d * scale / amplitude).acos()) / w;
        let a = scale * (d.abs() + random.between(0.5, 2.0));
        let scene = scene(system, &[upper(0, d * scale)]);
        let first = orbit(&scene, &[-a], &[0.0], period(a));
        let energy = 0.5 * k * a * a;
        let branch = followed(&first, (0.1 * k * (d * scale).powi(2), 30.0 * energy));
        for (own, energy) in branch.orbits.iter().zip(&branch.parameter) {
            let expected = period((2.0 * energy / k).sqrt());
            let off = own.period() / expected - 1.0;
            // Beside the touch the period has a root in it.
            assert!(
                off.abs() < 1e-9 || own.impacts()[0].approach < 1e-3 * a * w,
                "{off:e}"
            );
        }
        assert_eq!(branch.ends[1].reason, EndReason::Range);
        if d > 0.0 {
            // Down to where the stop is touched alone.
            let last = branch.special.first().expect("a boundary");
            assert_eq!(last.kind, SpecialKind::LostImpact);
            let touched = 0.5 * k * (d * scale).powi(2);
            assert!(
                (last.parameter / touched - 1.0).abs() < 1e-8,
                "{} {touched}",
                last.parameter
            );
        }
        let verdicts = branch.is_stable().expect("counts");
        // Next to the touch an orbit has no multipliers.
        assert!(!verdicts.contains(&Some(false)) && verdicts.last() == Some(&Some(true)));
    }
}

/// Two masses between walls, the second one before a stop, in a unit of time.
fn chain(clearance: f64, time: f64) -> Scene {
    let system = LinearSystem::new(
        dvector![1.0, 1.0],
        dmatrix![0.0, 0.0; 0.0, 0.0],
        dmatrix![2.0, -1.0; -1.0, 2.0] / (time * time),
    );
    scene(system.expect("valid"), &[upper(1, clearance)])
}

#[test]
fn two_masses_have_families_at_both_modes() {
    for (mode, w) in [([1.0, 1.0], 1.0f64), ([-1.0, 1.0], 3f64.sqrt())] {
        let own = chain(1.0, 1.0);
        let q = [-1.2 * mode[0], -1.2 * mode[1]];
        let first = orbit(&own, &q, &[0.0, 0.0], 0.95 * TAU / w);
        let branch = followed(&first, (0.1, 40.0));
        assert!(branch.orbits.len() > 20);
        check_retraced(&branch, 1e-8);
        // A family begins where its mode touches the stop: the energy of the mode that reaches 1.
        let last = branch.special.first().expect("a boundary");
        assert_eq!(last.kind, SpecialKind::LostImpact);
        let touched = w * w;
        assert!(
            (last.parameter / touched - 1.0).abs() < 1e-7,
            "{}",
            last.parameter
        );
        // The same from its other end.
        let back = followed(branch.orbits.last().expect("one"), (0.1, 40.0));
        let kinds = |own: &Branch| -> Vec<_> {
            own.special
                .iter()
                .map(|own| (own.kind, (own.parameter * 1e7).round()))
                .collect()
        };
        assert_eq!(kinds(&branch), kinds(&back));
    }
}

#[test]
fn where_a_family_doubles_another_is_born() {
    let mut found = 0;
    for ratio in [0.5, 1.0, 2.0] {
        let system = LinearSystem::new(
            dvector![1.0, ratio],
            dmatrix![0.0, 0.0; 0.0, 0.0],
            dmatrix![2.0, -1.0; -1.0, 1.5],
        );
        let own = scene(system.expect("valid"), &[upper(1, 1.0)]);
        let first = orbit(&own, &[-1.2, -1.6], &[0.0, 0.0], 6.0);
        let branch = followed(&first, (0.2, 60.0));
        for special in &branch.special {
            let born: Vec<Candidate> =
                branches(special, ContinuationParameter::Energy, (0.2, 60.0)).expect("a search");
            if special.kind != SpecialKind::PeriodDoubling {
                continue;
            }
            found += 1;
            let own = &born[0].orbit;
            assert_eq!(own.impacts().len(), 2 * special.orbit.impacts().len());
            let off = own.period() / special.orbit.period() / 2.0 - 1.0;
            assert!(off.abs() < 0.1, "{off}");
            let next = followed(own, (0.2, 60.0));
            assert!(next.orbits.len() > 3);
            check_retraced(&next, 1e-6);
        }
    }
    assert!(found > 0);
}

#[test]
fn a_pendulum_before_a_wall_swings_as_elliptic_integrals_say() {
    let (length, gravity) = (1.3, 2.0);
    let system = PendulumChain::new(dvector![1.5], dvector![length], &dvector![0.0], gravity);
    let wall = Wall::new(0, 0.0, 1.0, WallSide::Right).expect("valid");
    let own = Scene::new(system.expect("valid"), Forcing::Unforced, [wall]).expect("valid");
    let weight = 1.5 * gravity * length;
    // By the mean of arithmetic and geometric means; E = weight (1 - cos A).
    let swing = |energy: f64| {
        let (mut a, mut g) = (1.0f64, (1.0 - energy / weight / 2.0).sqrt());
        for _ in 0..30 {
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
        }
        PI * (length / gravity).sqrt() / a
    };
    let (q, v) = (&dvector![-0.6], &dvector![0.0]);
    let period = Some(swing(weight * (1.0 - 0.6f64.cos())));
    let first = find_orbit(&own, Guess::State { q, v, period }, None).expect("an orbit");
    let branch = followed(&first, (0.01 * weight, 1.9 * weight));
    for (own, energy) in branch.orbits.iter().zip(&branch.parameter) {
        let off = own.period() / swing(*energy) - 1.0;
        assert!(off.abs() < 1e-9, "{energy}: {off:e}");
    }
    assert!(branch.ends.iter().all(|end| end.reason == EndReason::Range));
}

#[test]
fn what_keeps_no_energy_has_no_family() {
    let between = (1e-3, 1e3);
    let forced = &USUAL.orbits(1)[0];
    let refused = |found: Result<Branch>| match found {
        Err(Error::BadValue { argument, rule, .. }) => (argument, rule),
        other => panic!("{other:?}"),
    };
    assert!(
        refused(tried(forced, between))
            .1
            .contains("without forcing")
    );
    // Self-excited, alone at its energy.
    let system = LinearSystem::new(dvector![1.0], dmatrix![-0.1], dmatrix![1.0]).expect("valid");
    let own = scene(system, &[Stop::new(0, 0.5, 0.8).expect("valid")]);
    let (q, v) = (dvector![0.0], dvector![0.6]);
    let run = simulate(&own, &q, &v, (0.0, 400.0), &SimulateOptions::default()).expect("a run");
    let first = find_orbit(&own, &run, None).expect("a cycle");
    assert!(
        refused(tried(&first, between))
            .1
            .contains("keep their energy")
    );
    // Outside the range.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let first = orbit(&scene(system, &[upper(0, 1.0)]), &[-2.0], &[0.0], 4.2);
    assert_eq!(refused(tried(&first, (3.0, 4.0))).0, "between");
}

#[test]
fn microseconds_are_as_good_as_seconds() {
    let of = |time: f64| {
        let first = orbit(&chain(1.0, time), &[-1.2, -1.2], &[0.0, 0.0], 5.97 * time);
        let scale = time.powi(-2);
        let branch = followed(&first, (0.1 * scale, 40.0 * scale));
        let special = branch.special.iter();
        let special: Vec<_> = special
            .map(|own| (own.kind, (own.parameter / scale * 1e6).round()))
            .collect();
        let stable = branch.is_stable().expect("counts");
        (
            special,
            stable.iter().filter(|own| **own == Some(true)).count(),
        )
    };
    assert_eq!(of(1.0), of(1e-6));
    assert_eq!(of(1.0), of(1e5));
}

#[test]
fn a_member_of_a_family_is_neither_stable_nor_unstable() {
    let branch = {
        let first = orbit(&chain(1.0, 1.0), &[-1.2, -1.2], &[0.0, 0.0], 5.97);
        followed(&first, (0.1, 40.0))
    };
    let verdicts = branch.is_stable().expect("counts");
    for (own, verdict) in branch.orbits.iter().zip(verdicts) {
        let alone = own.stability().expect("multipliers").is_stable;
        // What leaves the circle is unstable either way.
        assert!(
            alone
                == if verdict == Some(false) {
                    Some(false)
                } else {
                    None
                }
                || verdict.is_none()
        );
    }
}

#[test]
fn a_family_ends_where_its_motion_comes_to_rest() {
    // A mass that a spring presses against the stop, where it rests with the energy k d^2/2.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let own = scene(system, &[upper(0, -0.5)]);
    let period = |a: f64| 2.0 * (PI - (-0.5 / a).acos());
    let first = orbit(&own, &[-1.0], &[0.0], period(1.0));
    let branch = followed(&first, (0.1, 4.0));
    assert_eq!(branch.ends[0].reason, EndReason::Boundary);
    assert!(
        branch.ends[0].detail.contains("comes to rest"),
        "{:?}",
        branch.ends
    );
    assert!((branch.parameter[0] - 0.125).abs() < 1e-6 && branch.special.is_empty());
    // Nothing is left of a motion whose period none of its family has.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let own = scene(system, &[upper(0, 0.0)]);
    let (q, v) = (&dvector![-1.0], &dvector![0.0]);
    let period = Some(3.0);
    let found = find_orbit(&own, Guess::State { q, v, period }, None);
    assert!(
        matches!(found, Err(Error::NoConvergence { .. })),
        "{found:?}"
    );
}

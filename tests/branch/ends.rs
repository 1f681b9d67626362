//! Why branches end, and what is refused.

use crate::scenes::{Oscillator, USUAL, followed};
use std::ops::ControlFlow;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    ContinuationOptions, EndReason, Error, Harmonic, Heading, LinearSystem, OrbitOptions,
    Parameter, Pattern, PeriodicOrbit, Scene, Side, SimulateOptions, SpecialKind, Stop, Virtual,
    continuation, continuation_of, find_orbit, periodic_orbits, simulate, with_observer,
};

#[test]
fn an_impact_that_loses_its_speed_is_a_boundary() {
    let orbit = &USUAL.orbits(1)[0];
    let options = ContinuationOptions::default();
    let branch = followed(orbit, Parameter::ForcingScale, (0.1, 2.0), &options);
    assert_eq!(branch.ends[0].reason, EndReason::Boundary);
    assert_eq!(branch.ends[1].reason, EndReason::Range);
    assert!(
        (8.5 * branch.parameter[0] - 4.766_046_580).abs() < 2e-9,
        "{}",
        8.5 * branch.parameter[0]
    );
    assert_eq!(branch.parameter.last(), Some(&2.0));
    assert!(
        branch.ends[0].detail.contains("stop 0"),
        "{}",
        branch.ends[0].detail
    );
    // Kept, it goes on behind it.
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..options
    };
    let longer = followed(orbit, Parameter::ForcingScale, (0.1, 2.0), &keep);
    let least = longer
        .parameter
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    assert!(least <= branch.parameter[0] && longer.orbits.len() > branch.orbits.len());
    // Arclength grows along it.
    assert!(longer.arclength.windows(2).all(|pair| pair[0] < pair[1]));
}

#[test]
fn an_island_is_closed() {
    // Between two resonances, where the force is above the fold of some frequencies alone.
    let own = Oscillator {
        eta: 0.005,
        force: 0.3,
        frequency: 0.543,
        ..USUAL
    };
    let orbit = &own.orbits(1)[0];
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    };
    let branch = followed(orbit, Parameter::Frequency, (0.505, 0.66), &keep);
    assert!(branch.is_closed);
    for (orbit, &w) in branch.orbits.iter().zip(&branch.parameter) {
        let miss = own
            .at(Parameter::Frequency, w)
            .miss(1, orbit.impacts()[0].approach);
        assert!(miss.abs() < 1e-9, "{miss:e}");
    }
}

#[test]
fn points_and_observers_end_it() {
    let orbit = &USUAL.orbits(1)[0];
    let few = ContinuationOptions {
        max_points: 5,
        heading: Heading::Up,
        ..ContinuationOptions::default()
    };
    let branch = followed(orbit, Parameter::ForcingScale, (0.1, 2.0), &few);
    assert_eq!(branch.orbits.len(), 6);
    assert_eq!(branch.ends[1].reason, EndReason::Points);
    assert_eq!(branch.ends[0].reason, EndReason::Start);
    assert_eq!(branch.parameter[0], 1.0);
    // Told of the values from 0.1 to 2 in parts of that range.
    let break_off = |part: f64| {
        if part < 0.6 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    };
    let options = ContinuationOptions::default();
    let follow = || continuation(orbit, Parameter::ForcingScale, (0.1, 2.0), &options);
    let found = with_observer(break_off, follow);
    let branch = found.expect("what there is");
    assert_eq!(branch.ends[1].reason, EndReason::Interrupted);
    let (last, before) = branch.parameter.split_last().expect("a point");
    assert!(*last >= 0.1 + 0.6 * 1.9 && before.iter().all(|value| *value < 0.1 + 0.6 * 1.9));
}

#[test]
fn the_domain_of_a_function_ends_it() {
    let orbit = &USUAL.orbits(1)[0];
    let make = |p: f64| {
        if p > 9.0 {
            return Err(Error::bad_value("p", p, "it must not be above 9"));
        }
        Ok(Oscillator { force: p, ..USUAL }.scene())
    };
    let options = ContinuationOptions::default();
    let found = continuation_of(orbit, &make, 8.5, (5.0, 12.0), &options);
    let branch = found.expect("a branch");
    assert_eq!(branch.ends[1].reason, EndReason::Domain);
    let last = *branch.parameter.last().expect("one");
    assert!(last <= 9.0 && last > 9.0 - 1e-4, "{last}");
    // Its own error comes out as itself.
    let failing = |p: f64| {
        if p > 9.0 {
            return Err(Error::function(std::fmt::Error));
        }
        Ok(Oscillator { force: p, ..USUAL }.scene())
    };
    let found = continuation_of(orbit, &failing, 8.5, (5.0, 12.0), &options);
    assert!(matches!(found, Err(Error::Function(_))));
}

#[test]
fn what_makes_no_branch_is_refused() {
    let orbit = &USUAL.orbits(1)[0];
    let options = ContinuationOptions::default();
    let message = |parameter: Parameter, between: (f64, f64), options: &ContinuationOptions| {
        let found = continuation(orbit, parameter, between, options);
        found.expect_err("refused").to_string()
    };
    let scale = Parameter::ForcingScale;
    let says = |text: String, part: &str| assert!(text.contains(part), "{text}");
    says(
        message(scale, (2.0, 3.0), &options),
        "between is (2, 3), but the orbit is at 1",
    );
    says(
        message(scale, (2.0, 0.5), &options),
        "the first must be the lower one",
    );
    says(
        message(scale, (1.0, 1.0), &options),
        "the first must be the lower one",
    );
    says(message(scale, (0.0, f64::INFINITY), &options), "between");
    says(
        message(Parameter::RESTITUTION, (0.5, 1.2), &options),
        "between",
    );
    says(
        message(Parameter::CLEARANCE.of(3), (0.5, 1.2), &options),
        "parameter is \"clearance[3]\"",
    );
    says(
        message(Parameter::Phase, (0.0, 1.0), &options),
        "parameter is \"phase\"",
    );
    for steps in [
        [0.0, 1e-3, 0.1],
        [1e-3, 1e-4, 0.1],
        [1e-8, 0.2, 0.1],
        [1e-8, f64::NAN, 0.1],
    ] {
        let wrong = ContinuationOptions {
            steps,
            ..options.clone()
        };
        says(message(scale, (0.5, 2.0), &wrong), "step");
    }
    let none = ContinuationOptions {
        max_points: 0,
        ..options.clone()
    };
    says(message(scale, (0.5, 2.0), &none), "max_points is 0");
    // Not admissible: the other stop is passed.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0).expect("valid");
    let stops = [1.0, 1.01].map(|d| Stop::new(0, d, 0.8).expect("valid"));
    let scene = Scene::new(system, force, stops).expect("valid");
    let found = periodic_orbits(&scene, &Pattern::single(1), &OrbitOptions::default());
    let wrong = &found.expect("one")[0];
    let found = continuation(wrong, scale, (0.5, 2.0), &options);
    says(
        found.expect_err("refused").to_string(),
        "breaks a rule of contact",
    );
}

#[test]
fn an_orbit_at_an_end_of_the_range_is_there_once() {
    let orbit = &USUAL.orbits(1)[0];
    let options = ContinuationOptions::default();
    let branch = followed(orbit, Parameter::ForcingScale, (1.0, 1.5), &options);
    assert_eq!(branch.parameter[0], 1.0);
    assert!(branch.parameter.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(branch.ends.iter().all(|end| end.reason == EndReason::Range));
}

#[test]
fn the_border_of_a_chatter_is_known_from_its_power_law() {
    // x'' + x = cos 0.3 t before a stop at d, e = 0.8: the stick shrinks to nothing at a d known to 18 digits.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.3, 0.0).expect("valid");
    let stop = Stop::new(0, 0.0, 0.8).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let (start, rest) = (dvector![-0.5], dvector![0.0]);
    let long = (0.0, 40.0 * std::f64::consts::TAU / 0.3);
    let run = simulate(&scene, &start, &rest, long, &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let up = ContinuationOptions {
        heading: Heading::Up,
        ..Default::default()
    };
    let branch = followed(&orbit, Parameter::CLEARANCE, (-0.2, 0.3), &up);
    let border = branch.special.last().expect("a border");
    assert_eq!(border.kind, SpecialKind::ChatterBorder);
    let off = (border.parameter - 0.123_448_597_848_029_15).abs();
    assert!(
        off < 1e-9 && off < border.error && border.error < 1e-8,
        "{off:e} {:e}",
        border.error
    );
}

#[test]
fn impacts_that_vanish_all_at_once_do_so_at_one_place_from_both_sides() {
    // x'' + x = cos w t before a stop at 0: let go at rest where the force turns, the flight (w sin t - sin w t)/(1 - w^2) is over at
    // t = pi/w, where the force turns again, and at w = 1/3 without speed. Contact lasts half a period there.
    let vanishing = 1.0 / 3.0;
    let sides = [
        (0.30, Heading::Up),
        (0.32, Heading::Up),
        (0.334, Heading::Down),
        (0.34, Heading::Down),
    ];
    for (frequency, heading) in sides {
        let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]);
        let force = Harmonic::new(dvector![1.0.into()], frequency, 0.0).expect("valid");
        let stop = Stop::new(0, 0.0, 0.8).expect("valid");
        let scene = Scene::new(system.expect("valid"), force, [stop]).expect("valid");
        let (start, rest) = (dvector![-0.5], dvector![0.0]);
        let long = (0.0, 60.0 * std::f64::consts::TAU / frequency);
        let run = simulate(&scene, &start, &rest, long, &SimulateOptions::default());
        let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
        let options = ContinuationOptions {
            heading,
            ..Default::default()
        };
        let branch = followed(&orbit, Parameter::Frequency, (0.25, 0.45), &options);
        let [border] = branch.special.as_slice() else {
            panic!("{frequency}: {:?}", branch.ends);
        };
        let off = (border.parameter - vanishing).abs();
        assert_eq!(border.kind, SpecialKind::VanishingImpacts, "{frequency}");
        assert!(
            off <= border.error && border.error < 1e-6,
            "{frequency}: {off:e} {:e}",
            border.error
        );
    }
}

#[test]
fn a_branch_that_goes_on_beyond_its_boundary_has_it_all_the_same() {
    let orbit = &USUAL.orbits(1)[0];
    let [stopped, kept] = [Virtual::Stop, Virtual::Keep].map(|beyond| {
        let options = ContinuationOptions {
            beyond,
            ..Default::default()
        };
        followed(orbit, Parameter::ForcingScale, (0.1, 2.0), &options)
    });
    let lost = |branch: &vibroimpact::Branch| {
        let own = branch.special.iter();
        let own: Vec<_> = own
            .filter(|own| own.kind == SpecialKind::LostImpact)
            .collect();
        let all: Vec<_> = branch
            .special
            .iter()
            .map(|own| (own.kind, own.parameter))
            .collect();
        assert_eq!(
            own.len(),
            1,
            "{all:?} {:?} {:?}",
            branch.ends,
            branch.parameter
        );
        (own[0].parameter, own[0].arclength)
    };
    let (one, other) = (lost(&stopped), lost(&kept));
    assert!((one.0 - other.0).abs() < 1e-9 && (one.1 - other.1).abs() < 1e-3);
    assert!(kept.arclength[0] < other.1);
    // From behind it too.
    let k = kept.arclength.partition_point(|length| *length < other.1) - 2;
    let behind = &kept.orbits[k];
    assert_eq!(behind.is_admissible(), Some(false));
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let factor = kept.parameter[k];
    let range = (0.9, 2.0 / factor);
    let again = followed(behind, Parameter::ForcingScale, range, &keep);
    let (parameter, _) = lost(&again);
    assert!((parameter * factor - one.0).abs() < 1e-9);
}

/// An oscillator of unit mass and stiffness before a stop.
fn oscillator(eta: f64, w: f64, force: f64, clearance: f64, restitution: f64) -> Oscillator {
    Oscillator {
        eta,
        force,
        frequency: w,
        clearance,
        restitution,
    }
}

fn admissible(own: Oscillator) -> PeriodicOrbit {
    let found = own.orbits(1).into_iter();
    let mut kept = found.filter(|own| own.is_admissible() == Some(true));
    kept.next().expect("an orbit")
}

#[test]
fn no_point_lies_outside_the_range() {
    for (own, range) in [
        (oscillator(0.1, 2.5, 1.6, 0.1, 0.9), (1.5, 3.75)),
        (oscillator(0.1, 1.4, 3.8, 0.9, 1.0), (0.84, 2.1)),
        (oscillator(0.05, 2.0, 2.4, 0.3, 0.7), (1.2, 3.0)),
    ] {
        let options = ContinuationOptions::default();
        let branch = followed(&admissible(own), Parameter::Frequency, range, &options);
        let inside = |p: &f64| (range.0..=range.1).contains(p);
        assert!(
            branch.parameter.iter().all(inside),
            "{:?}",
            branch.parameter
        );
        assert!(branch.special.iter().all(|own| inside(&own.parameter)));
    }
}

#[test]
fn a_closed_branch_ends_where_it_began_and_turns_as_often_back_as_forth() {
    for own in [
        oscillator(0.064, 2.5157, 1.9107, 0.97037, 0.6592),
        oscillator(0.0922, 2.8592, 0.7387, 0.3426, 0.8429),
        oscillator(0.0205, 2.6445, 1.3745, 0.6850, 0.8250),
    ] {
        for orbit in own.orbits(2) {
            let options = ContinuationOptions {
                beyond: Virtual::Keep,
                ..ContinuationOptions::default()
            };
            let range = (0.3 * own.frequency, 3.0 * own.frequency);
            let branch = followed(&orbit, Parameter::Frequency, range, &options);
            assert!(branch.is_closed, "{:?}", branch.ends);
            let last = branch.orbits.len() - 1;
            assert!(branch.parameter[0] == branch.parameter[last]);
            assert!(branch.orbits[0].q0() == branch.orbits[last].q0());
            let special = branch.special.iter();
            let folds = special.filter(|own| own.kind == SpecialKind::Fold).count();
            assert!(folds > 0 && folds.is_multiple_of(2), "{folds}");
        }
    }
}

#[test]
fn a_stop_that_holds_after_one_impact_keeps_its_restitution() {
    // A ball that stays on its table: with e > 0 it would bounce first.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![0.0]).expect("valid");
    let system = system.with_load(dvector![-1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.3.into()], 1.0, 0.0).expect("valid");
    let table = Stop::new(0, 0.0, 0.0).expect("valid").on_side(Side::Lower);
    let scene = Scene::new(system, force, [table]).expect("valid");
    let run = simulate(
        &scene,
        &dvector![0.3],
        &dvector![0.0],
        (0.0, 75.0),
        &SimulateOptions::default(),
    );
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let refused = continuation(
        &orbit,
        Parameter::RESTITUTION,
        (0.0, 0.9),
        &ContinuationOptions::default(),
    );
    assert!(refused.is_err());
}

//! Curves in two numbers on which special points lie, against closed forms.

use crate::random::Random;
use crate::scenes::{Oscillator, USUAL, followed};
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    BifurcationCurve, Constraint, ContinuationOptions, CurveOf, EndReason, FreeParameter, Harmonic,
    ImpactSide, Kind, LinearSystem, Motion, OrbitOptions, PaperOptions, Parameter, Pattern,
    PeriodicOrbit, Scene, Special, SpecialKind, Stop, Virtual, bifurcation_curve,
    bifurcation_curve_of, continuation, paper_scene, periodic_orbits,
};

const PLANES: [([Parameter; 2], [(f64, f64); 2]); 5] = [
    (
        [Parameter::Frequency, Parameter::ForcingScale],
        [(0.5, 4.0), (0.05, 5.0)],
    ),
    (
        [Parameter::ForcingScale, Parameter::Frequency],
        [(0.05, 5.0), (0.5, 4.0)],
    ),
    (
        [Parameter::Frequency, Parameter::CLEARANCE],
        [(0.5, 4.0), (-1.0, 2.0)],
    ),
    (
        [Parameter::RESTITUTION, Parameter::ForcingScale],
        [(0.0, 1.0), (0.05, 5.0)],
    ),
    (
        [Parameter::DampingScale, Parameter::CLEARANCE],
        [(0.1, 5.0), (-1.0, 2.0)],
    ),
];

fn curve(special: &Special, plane: ([Parameter; 2], [(f64, f64); 2])) -> BifurcationCurve {
    let options = ContinuationOptions::default();
    bifurcation_curve(CurveOf::Special(special), plane.0, plane.1, &options).expect("a curve")
}

/// The clearance of the first stop of an orbit.
fn clearance(orbit: &PeriodicOrbit) -> f64 {
    match &orbit.scene().stops()[0] {
        Constraint::Stop(stop) => stop.clearance(),
        _ => panic!("a stop"),
    }
}

/// The force at which a special point of one impact in a period lies.
fn critical(own: Oscillator, kind: SpecialKind) -> f64 {
    let speed = match kind {
        SpecialKind::Fold => own.fold_speed(1),
        SpecialKind::PeriodDoubling => own.doubling_speed(1),
        _ => 0.0,
    };
    own.force_of(1, speed)
}

#[test]
fn every_point_of_a_curve_lies_on_the_closed_form() {
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let mut seen = [0; 3];
    for case in 0..40 {
        let random = &mut Random::of_case(61, case);
        let own = Oscillator {
            eta: random.between(0.02, 0.2),
            force: random.between(1.0, 6.0),
            frequency: random.between(0.8, 3.5),
            clearance: random.between(-0.8, 1.2),
            restitution: random.between(0.2, 0.9),
        };
        let orbits = own.orbits(1);
        let Some(orbit) = orbits.first() else {
            continue;
        };
        // The number that is followed to a special point is the second of the plane; the curve begins in a scene where it is one.
        let branch = followed(orbit, Parameter::ForcingScale, (0.1, 4.0), &keep);
        // A stop that is touched in between has no closed form here.
        let known = branch
            .special
            .iter()
            .filter(|own| own.kind != SpecialKind::Graze);
        for special in known {
            let start = Oscillator {
                force: own.force * special.parameter,
                ..own
            };
            let (names, ranges) = PLANES[case as usize % PLANES.len()];
            let is_inside =
                |axis: usize, value: f64| (ranges[axis].0..=ranges[axis].1).contains(&value);
            let values = names.map(|name| match name {
                Parameter::Frequency => own.frequency,
                Parameter::CLEARANCE => own.clearance,
                Parameter::RESTITUTION => own.restitution,
                _ => 1.0,
            });
            if !(is_inside(0, values[0]) && is_inside(1, values[1])) {
                continue;
            }
            let found = curve(special, (names, ranges));
            assert!(
                found.x.len() > 3,
                "{case} {:?} {:?}",
                special.kind,
                found.ends
            );
            for (&x, &y) in found.x.iter().zip(&found.y) {
                let there = start.at(names[0], x).at(names[1], y);
                let miss = critical(there, special.kind) / there.force - 1.0;
                assert!(
                    miss.abs() < 1e-8,
                    "{case} {:?} {names:?} ({x}, {y}): {miss:e}",
                    special.kind
                );
            }
            seen[usize::from(special.kind == SpecialKind::Fold)] += 1;
        }
    }
    assert!(seen[0] > 8 && seen[1] > 4, "{seen:?}");
}

#[test]
fn curves_of_impacts_that_take_nearly_all_speed_are_as_short() {
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let plane = (
        [Parameter::Frequency, Parameter::ForcingScale],
        [(2.1, 2.7), (0.05, 5.0)],
    );
    for restitution in [0.0, 1e-12, 1e-6, 1e-4, 1e-3, 0.1] {
        let own = Oscillator {
            force: 6.0,
            restitution,
            ..USUAL
        };
        let orbit = &own.orbits(1)[0];
        let branch = followed(orbit, Parameter::ForcingScale, (0.1, 4.0), &keep);
        for kind in [SpecialKind::Fold, SpecialKind::PeriodDoubling] {
            let special = branch.special.iter().find(|own| own.kind == kind);
            let special = special.expect("one of each");
            let found = curve(special, plane);
            let start = Oscillator {
                force: own.force * special.parameter,
                ..own
            };
            assert!(
                (10..60).contains(&found.x.len()),
                "{restitution} {kind:?}: {}",
                found.x.len()
            );
            for (&x, &y) in found.x.iter().zip(&found.y) {
                let there = start
                    .at(Parameter::Frequency, x)
                    .at(Parameter::ForcingScale, y);
                let miss = critical(there, kind) / there.force - 1.0;
                assert!(
                    miss.abs() < 1e-8,
                    "{restitution} {kind:?} ({x}, {y}): {miss:e}"
                );
            }
        }
    }
}

#[test]
fn a_curve_is_on_its_form_up_to_the_end_of_a_range_of_frequencies() {
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let found_by_others = Oscillator {
        eta: 0.110_785_601_859_873_61,
        force: 4.124_167_511_356_951,
        frequency: 3.204_805_110_573_055_5,
        clearance: -0.168_259_597_373_636_5,
        restitution: 0.8,
    };
    let without_speed = Oscillator {
        eta: 0.1,
        force: 2.2,
        frequency: 1.8,
        clearance: 0.8,
        restitution: 0.0,
    };
    for (own, n) in [(found_by_others, 2), (without_speed, 1)] {
        let orbit = &own.orbits(n)[0];
        let branch = followed(orbit, Parameter::ForcingScale, (0.02, 4.0), &keep);
        let fold = branch
            .special
            .iter()
            .find(|own| own.kind == SpecialKind::Fold);
        let fold = fold.expect("one");
        let w = own.frequency;
        for high in [1.39, 1.4, 1.41] {
            let plane = [Parameter::Frequency, Parameter::ForcingScale];
            let found = curve(fold, (plane, [(0.7 * w, high * w), (0.01, 6.0)]));
            assert_eq!(found.ends[1].reason, EndReason::Range);
            for (k, (&x, &y)) in found.x.iter().zip(&found.y).enumerate() {
                let there = own.at(Parameter::Frequency, x);
                let known = there.force_of(n, there.fold_speed(n)) / own.force / fold.parameter;
                assert!((y / known - 1.0).abs() < 1e-8, "{high} ({x}, {y}): {known}");
                let period = std::f64::consts::TAU * n as f64 / x;
                assert!((found.orbits[k].period() / period - 1.0).abs() < 1e-13);
            }
        }
    }
}

#[test]
fn a_curve_of_grazes_is_that_of_the_amplitude() {
    let own = Oscillator {
        force: 4.0,
        ..USUAL
    };
    let found = periodic_orbits(&own.scene(), &Pattern::none(), &OrbitOptions::default());
    let rest = &found.expect("one")[0];
    let branch = followed(
        rest,
        Parameter::ForcingScale,
        (0.5, 2.0),
        &ContinuationOptions::default(),
    );
    let graze = &branch.special[0];
    assert_eq!(graze.kind, SpecialKind::Graze);
    let found = curve(
        graze,
        (
            [Parameter::Frequency, Parameter::ForcingScale],
            [(1.2, 4.0), (0.05, 4.0)],
        ),
    );
    let start = Oscillator {
        force: 4.0 * graze.parameter,
        ..own
    };
    for (&x, &y) in found.x.iter().zip(&found.y) {
        let there = start
            .at(Parameter::Frequency, x)
            .at(Parameter::ForcingScale, y);
        assert!(
            (critical(there, SpecialKind::Graze) / there.force - 1.0).abs() < 1e-9,
            "{x} {y}"
        );
    }
    assert!(found.orbits.iter().all(|orbit| orbit.impacts().is_empty()));
    assert!(
        found.ends.iter().all(|end| end.reason == EndReason::Range),
        "{:?}",
        found.ends
    );
    // Folds and doublings end on it where sin(w_d T) = 0: w = 2 w_d/j.
    let own_frequency = (1.0f64 - 0.05 * 0.05).sqrt();
    let resonance = 2.0 * own_frequency;
    let meetings: Vec<f64> = found.special.iter().map(|own| own.parameters[0]).collect();
    assert!(
        meetings.iter().any(|w| (w - resonance).abs() < 1e-6),
        "{meetings:?}"
    );
}

#[test]
fn stops_that_are_hit_together_are_a_curve() {
    // The paper's first kind: both stops at one instant, at the clearances that a search with a free one finds for each frequency.
    let scene = paper_scene(Kind::One, &PaperOptions::default()).expect("a scene");
    let pattern = Pattern::new(Kind::One.pattern()).expect("valid");
    let free = OrbitOptions {
        n_periods: Kind::One.n_periods(),
        free: Some(FreeParameter::Clearance),
        ..Default::default()
    };
    let found = periodic_orbits(&scene, &pattern, &free).expect("a search");
    let orbit = found.iter().find(|own| own.is_admissible() == Some(true));
    let orbit = orbit.expect("the paper's orbit");
    let make = |w: f64, c: f64| {
        let there = scene.replace(Parameter::Frequency.change(w))?;
        there.replace(Parameter::CLEARANCE.change(c))
    };
    let start = [1.5, clearance(orbit)];
    let between = [(1.3, 1.7), (-3.0, 3.0)];
    let options = ContinuationOptions::default();
    let curve = bifurcation_curve_of(CurveOf::Orbit(orbit), &make, start, between, &options);
    let curve = curve.expect("a curve");
    assert!(curve.x.len() > 5, "{:?}", curve.ends);
    for k in (0..curve.x.len()).step_by(3) {
        let impacts = curve.orbits[k].impacts();
        assert!(impacts.len() == 2 && impacts[0].time == impacts[1].time);
        let there = scene
            .replace(Parameter::Frequency.change(curve.x[k]))
            .expect("valid");
        let known = periodic_orbits(&there, &pattern, &free).expect("a search");
        let off = known.iter().map(|own| (clearance(own) - curve.y[k]).abs());
        let off = off.fold(f64::INFINITY, f64::min);
        assert!(off < 1e-9, "{} {}: {off:e}", curve.x[k], curve.y[k]);
    }
    // One that hits its stops one after the other is none.
    let alone = USUAL.orbits(1);
    let plane = [Parameter::Frequency, Parameter::CLEARANCE];
    let refused = bifurcation_curve(
        CurveOf::Orbit(&alone[0]),
        plane,
        [(2.0, 3.0), (0.5, 1.5)],
        &ContinuationOptions::default(),
    );
    assert!(refused.is_err_and(|error| error.to_string().contains("one instant")));
}

/// Two masses, the first thrown back by its stop, so that the distance to another, across both, has a corner there.
fn thrown(random: &mut Random) -> (Scene, DVector<f64>) {
    let couple = random.between(0.2, 0.6);
    let stiffness = dmatrix![1.0 + couple, -couple; -couple, 1.0 + couple];
    let damping = &stiffness * random.between(0.02, 0.1);
    let system = LinearSystem::new(dvector![1.0, random.between(0.5, 2.0)], damping, stiffness);
    let force = dvector![1.0.into(), random.between(-0.5, 0.5).into()];
    let force = Harmonic::new(force, random.between(0.6, 1.6), 0.0).expect("valid");
    let first = Stop::new(0, random.between(0.1, 0.5), random.between(0.3, 0.9));
    let across = dvector![1.0, random.between(-0.4, 0.4)];
    let other = Stop::new(
        across.clone(),
        random.between(0.6, 1.5),
        random.between(0.3, 0.9),
    );
    let stops = [first.expect("valid"), other.expect("valid")];
    let scene = Scene::new(system.expect("valid"), force, stops);
    (scene.expect("valid"), across)
}

#[test]
fn a_corner_that_one_stop_hits_has_a_curve_on_which_the_other_is_reached_there() {
    let mut curves = 0;
    for seed in 0..40 {
        let (scene, across) = thrown(&mut Random::new(seed));
        let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
        let Some(orbit) = found.expect("a search").into_iter().next() else {
            continue;
        };
        if orbit.is_admissible() != Some(true) {
            continue;
        }
        let room = Parameter::CLEARANCE.of(1);
        let options = ContinuationOptions::default();
        let branch = continuation(&orbit, room, (0.0, 2.0), &options);
        let Ok(branch) = branch else { continue };
        let corner = branch.special.iter();
        let corner = corner.filter(|own| own.kind == SpecialKind::Corner && own.stop == Some(1));
        for corner in corner {
            let plane = [room, Parameter::Frequency];
            let w = TAU / orbit.scene().period().expect("forced");
            let between = [(0.0, 2.0), (0.9 * w, 1.1 * w)];
            let options = ContinuationOptions {
                max_points: 20,
                ..Default::default()
            };
            let curve = bifurcation_curve(CurveOf::Special(corner), plane, between, &options);
            let curve = curve.expect("a curve");
            assert!(curve.x.len() > 5, "{seed}: {:?}", curve.ends);
            for (orbit, (x, y)) in curve.orbits.iter().zip(curve.x.iter().zip(&curve.y)) {
                let w = TAU / orbit.scene().period().expect("forced");
                assert!((w - y).abs() < 1e-12);
                let impact = orbit.impacts()[0];
                let gap = x - across.dot(
                    &orbit
                        .state(impact.time, ImpactSide::Before)
                        .expect("a time")
                        .0,
                );
                assert!(gap.abs() < 1e-9, "{seed}: {gap:e} at ({x}, {y})");
                assert!(impact.approach > 0.0 && orbit.pattern() == &Pattern::single(0));
            }
            curves += 1;
        }
    }
    assert!(curves >= 3, "{curves}");
}

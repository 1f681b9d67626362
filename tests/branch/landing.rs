//! Landing and release borders, against closed forms.

use crate::scenes::{Oscillator, followed, pressed, settled};
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{Complex, dmatrix, dvector};
use vibroimpact::{
    ContinuationOptions, Fourier, Harmonic, Heading, LinearSystem, Motion, Parameter,
    PeriodicOrbit, Scene, SegmentKind, SimulateOptions, Special, SpecialKind, Stop, branches,
    continuation_of, find_orbit, simulate,
};

const RANGE: (f64, f64) = (0.2, 6.0);

/// An oscillator whose impacts take all speed, which hits nothing at first.
fn oscillator(frequency: f64, clearance: f64) -> Oscillator {
    Oscillator {
        eta: 0.05,
        force: 5.0,
        frequency,
        clearance,
        restitution: 0.0,
    }
}

/// The orbit that it comes to from rest next to its stop.
fn settled_beside(own: Oscillator) -> Option<PeriodicOrbit> {
    settled(&own.scene(), own.clearance - 0.1, 60)
}

/// How far from the stop a motion is, a while after it left that without speed and acceleration at a phase.
fn away(own: Oscillator, phase: f64, late: f64) -> f64 {
    let Oscillator {
        eta,
        force,
        frequency: w,
        clearance: d,
        ..
    } = own;
    let steady = Complex::new(force, 0.0) / Complex::new(1.0 - w * w, 2.0 * eta * w);
    let at = |t: f64| {
        let turned = steady * Complex::from_polar(1.0, phase + w * t);
        (turned.re, -w * turned.im)
    };
    let (x, v) = at(0.0);
    let (q, v) = (d - x, -v);
    let own = (1.0 - eta * eta).sqrt();
    let free = q * (own * late).cos() + (v + eta * q) / own * (own * late).sin();
    (-eta * late).exp() * free + at(late).0 - d
}

/// The least of [`away`] at a landing with no acceleration, where the motion leaves or was let go: both at the phase at which the force pulls it off as the spring does.
fn miss(own: Oscillator, n_periods: usize) -> f64 {
    let phase = (own.clearance / own.force).acos();
    let turns = (0..=n_periods).map(|n| n as f64 * TAU);
    let all = turns.flat_map(|turns| {
        let late = [(phase, turns), (phase, turns - 2.0 * phase)];
        late.map(|(phase, angle)| (phase, angle / own.frequency))
    });
    let flown = all.filter(|(_, late)| *late > 0.1);
    let each = flown.map(|(phase, late)| away(own, phase, late).abs());
    each.fold(f64::INFINITY, f64::min)
}

fn n_sticks(orbit: &PeriodicOrbit) -> usize {
    let segments = orbit.segments().expect("kept");
    let sticks = segments.iter().filter(|own| own.kind == SegmentKind::Stick);
    sticks.count()
}

fn of_kind(all: &[Special], kind: SpecialKind) -> impl Iterator<Item = &Special> {
    all.iter().filter(move |own| own.kind == kind)
}

#[test]
fn a_landing_without_acceleration_is_a_border_from_both_sides() {
    let options = ContinuationOptions::default();
    let mut seen = [0; 4];
    for k in 0..16 {
        for clearance in [0.3, -0.4] {
            let own = oscillator(0.25 + 0.25 * f64::from(k), clearance);
            let Some(orbit) = settled_beside(own).filter(|orbit| orbit.n_periods() <= 3) else {
                continue;
            };
            if orbit.impacts().len() > 1 {
                continue;
            }
            let branch = followed(&orbit, Parameter::Frequency, RANGE, &options);
            for border in of_kind(&branch.special, SpecialKind::LandingBorder) {
                let w = border.parameter;
                let there = own.at(Parameter::Frequency, w);
                let case = format!("{} {clearance} at {w}", own.frequency);
                let off = miss(there, border.orbit.n_periods());
                assert!(off < 1e-9, "{case}: {off:e} {:e}", border.error);
                assert!(border.error < 1e-10, "{case}: {:e}", border.error);
                let born = branches(border, Parameter::Frequency, RANGE).expect("a search");
                let [other] = born.as_slice() else {
                    panic!("{case}: {}", born.len());
                };
                assert_eq!(other.orbit.is_admissible(), Some(true), "{case}");
                // The orbit next to the border is on the other side.
                let mean = branch.parameter.iter().sum::<f64>() / branch.parameter.len() as f64;
                assert!(other.is_above == (mean < w), "{case}: from {mean}");
                // The other branch comes back to the border.
                let range = (w - 0.02, w + 0.02);
                let back = followed(&other.orbit, Parameter::Frequency, range, &options);
                let again = of_kind(&back.special, SpecialKind::LandingBorder);
                let off = again.map(|own| (own.parameter - w).abs());
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(off < 1e-9, "{case}: {off:e} {:?}", back.ends);
                let more = n_sticks(&other.orbit) > n_sticks(&border.orbit);
                let hits = other.orbit.impacts().len() > border.orbit.impacts().len();
                seen[usize::from(more) + 2 * usize::from(hits)] += 1;
            }
        }
    }
    // One stay less, one more, one flight more; a flight less is what the other branch has.
    assert!(seen[0] > 2 && seen[2] > 2, "{seen:?}");
}

#[test]
fn behind_its_rise_a_flight_comes_to_nothing() {
    for restitution in [0.0, 0.3] {
        let make = |second: f64| pressed(second, restitution);
        let scene = make(1.05).expect("valid");
        let first = settled(&scene, 0.0, 20).expect("an orbit");
        let options = ContinuationOptions {
            heading: Heading::Both,
            ..Default::default()
        };
        let branch = continuation_of(&first, &make, 1.05, (0.5, 1.2), &options);
        let branch = branch.expect("a branch");
        let mut borders = of_kind(&branch.special, SpecialKind::ReleaseBorder);
        let border = borders.next();
        let border = border.unwrap_or_else(|| panic!("{restitution} {:?}", branch.ends));
        // The force of the contact, F - F_2 at its least, is zero there.
        let off = (border.parameter - 1.0).abs();
        assert!(
            off < 1e-8 && off <= 10.0 * border.error,
            "{off:e} {:e}",
            border.error
        );
        let born = branches(border, &make, (0.5, 1.2)).expect("a search");
        let [held] = born.as_slice() else {
            panic!("{restitution}: {}", born.len());
        };
        assert!(!held.is_above && held.orbit.is_admissible() == Some(true));
        let own = branch.orbits.last().expect("one");
        assert_eq!(n_sticks(&held.orbit) + 1, n_sticks(own));
    }
}

/// A mass under a load and a force, before a stop that takes all speed, followed over the force from the motion that it comes to.
fn under_a_load(
    [damping, stiffness, load, clearance]: [f64; 4],
    force: &[Complex<f64>],
    frequency: f64,
    between: (f64, f64),
) -> (PeriodicOrbit, vibroimpact::Branch) {
    let system = LinearSystem::new(dvector![1.0], dmatrix![damping], dmatrix![stiffness]);
    let system = system.and_then(|own| own.with_load(dvector![load]));
    let force = force.iter().map(|a| dvector![*a]).collect();
    let force = Fourier::new(force, frequency, 0.0).expect("valid");
    let stop = Stop::new(0, clearance, 0.0).expect("valid");
    let scene = Scene::new(system.expect("valid"), force, [stop]).expect("valid");
    let orbit = settled(&scene, 0.0, 60).expect("an orbit");
    let options = ContinuationOptions::default();
    let branch = followed(&orbit, Parameter::ForcingScale, between, &options);
    (orbit, branch)
}

#[test]
fn a_stay_that_comes_to_nothing_is_located_whatever_is_found_beyond() {
    let force = [Complex::new(-1.190_499, 0.097_636)];
    let (_, branch) = under_a_load(
        [0.311_836, 0.0, 0.479_397, 0.539_079],
        &force,
        1.084_269,
        (0.3, 3.0),
    );
    let border = branch.special.last().expect("an end");
    assert_eq!(border.kind, SpecialKind::LandingBorder, "{:?}", branch.ends);
    assert!(border.error < 1e-10, "{:e}", border.error);
    let born = branches(border, Parameter::ForcingScale, (0.3, 3.0)).expect("a search");
    assert!(
        born.iter()
            .any(|own| own.orbit.is_admissible() == Some(true) && own.is_above)
    );
    // Behind it there is no free impact to begin a period with, or there are stops hit at one instant: no panic either.
    let force = [
        Complex::new(-2.319_400_64, -0.808_398_79),
        Complex::new(0.123_823_07, 1.034_063_75),
    ];
    let numbers = [0.099_403_82, 1.0, 1.019_765_05, 0.257_817_77];
    let (_, branch) = under_a_load(numbers, &force, 0.875_530_2, (0.3, 1.1));
    for special in &branch.special {
        branches(special, Parameter::ForcingScale, (0.3, 1.1)).expect("a search");
    }
}

#[test]
fn a_candidate_has_the_number_of_its_scene() {
    for k in 0..6 {
        let own = oscillator(0.3 + 0.3 * f64::from(k), 0.3);
        let Some(orbit) = settled_beside(own).filter(|orbit| orbit.n_periods() <= 2) else {
            continue;
        };
        let range = (0.2, 4.0);
        let options = ContinuationOptions::default();
        let branch = followed(&orbit, Parameter::ForcingScale, range, &options);
        for border in of_kind(&branch.special, SpecialKind::LandingBorder) {
            for other in branches(border, Parameter::ForcingScale, range).expect("a search") {
                let vibroimpact::Forcing::Harmonic(force) = other.orbit.scene().forcing() else {
                    panic!("a harmonic force");
                };
                let factor = force.amplitude()[0].re / own.force;
                assert!(
                    (factor - other.parameter).abs() < 1e-12,
                    "{factor} {}",
                    other.parameter
                );
            }
        }
    }
}

#[test]
fn a_mass_that_is_let_go_for_the_first_time_is_pressed_on_by_as_much_as_it_is_pulled() {
    // Held for good while the load is larger than the force's amplitude; K = 0.
    let force = [Complex::new(-1.190_499, 0.097_636)];
    let numbers = [0.311_836, 0.0, 0.479_397, 0.539_079];
    let (_, branch) = under_a_load(numbers, &force, 1.084_269, (0.3, 3.0));
    let known = numbers[2] / force[0].norm();
    let release = branch.special.first().expect("an end");
    assert_eq!(
        release.kind,
        SpecialKind::ReleaseBorder,
        "{:?}",
        branch.ends
    );
    let off = (release.parameter - known).abs();
    assert!(
        off < 1e-10 && release.error < 1e-10,
        "{off:e} {:e}",
        release.error
    );
    let is_fold = |own: &&Special| own.kind == SpecialKind::Fold;
    assert!(branch.special.iter().find(is_fold).is_none());
    let born = branches(release, Parameter::ForcingScale, (0.3, 3.0)).expect("a search");
    let [held] = born.as_slice() else {
        panic!("{}", born.len());
    };
    assert!(!held.is_above && held.orbit.impacts().is_empty());
    assert_eq!(held.orbit.is_admissible(), Some(true));
    // Back to it from the side that is held for good, and beyond.
    let unit = held.parameter;
    let options = ContinuationOptions::default();
    let range = (0.3 / unit, 3.0 / unit);
    let branch = followed(&held.orbit, Parameter::ForcingScale, range, &options);
    let rise = branch.special.last().expect("an end");
    assert_eq!(rise.kind, SpecialKind::Rise, "{:?}", branch.ends);
    assert!((rise.parameter * unit - known).abs() < 1e-10);
    let born = branches(rise, Parameter::ForcingScale, range).expect("a search");
    let [flown] = born.as_slice() else {
        panic!("{}", born.len());
    };
    assert!(flown.is_above && flown.orbit.impacts().len() == 1);
    assert_eq!(flown.orbit.is_admissible(), Some(true));
}

#[test]
fn a_release_border_behind_impacts_that_accumulate_is_where_the_force_comes_to_zero() {
    // Two masses, the first held before its stop: it is let go where the force on it comes to zero, and comes back by ever slower impacts.
    let (stiff, soft, coupling) = (4.972_053_764, 3.440_796_572, -1.809_635_552);
    let (damping, forces) = (0.105_098_998, [0.872_470_53, 2.939_966_33]);
    let (clearance, begin) = (-0.220_144_248, 2.054_384);
    let force = |w: f64| {
        let moved = Complex::from(forces[1]) / Complex::new(soft - w * w, w * damping);
        let held = -(stiff - coupling * coupling / soft) * clearance;
        held - (forces[0] - moved * coupling).norm()
    };
    let (mut low, mut high) = (2.5, 2.6);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if force(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let system = LinearSystem::new(
        dvector![1.0, 1.0],
        dmatrix![damping, 0.0; 0.0, damping],
        dmatrix![stiff, coupling; coupling, soft],
    );
    let force = Harmonic::new(dvector![forces[0].into(), forces[1].into()], begin, 0.0);
    let stop = Stop::new(0, clearance, 0.3).expect("valid");
    let scene = Scene::new(system.expect("valid"), force.expect("valid"), [stop]).expect("valid");
    let (q, v) = (dvector![-0.6, -0.6], dvector![0.0, 0.0]);
    let until = 60.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let options = ContinuationOptions::default();
    let branch = followed(&orbit, Parameter::Frequency, (1.5, 2.9), &options);
    let border = of_kind(&branch.special, SpecialKind::ReleaseBorder).next();
    let border = border.expect("it comes to an end");
    let off = (border.parameter - low).abs();
    assert!(off < 1e-9, "{off:e} {:e}", border.error);
}

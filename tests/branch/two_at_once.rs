//! Points of curves at which two things happen at once.

use crate::random::Random;
use crate::scenes::{USUAL, followed};
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{Complex, DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    BifurcationCurve, ContinuationOptions, CurveOf, EndReason, Harmonic, LinearSystem,
    OrbitOptions, Parameter, Pattern, PeriodicOrbit, Scene, Side, Special, SpecialKind, Stop,
    Virtual, bifurcation_curve, continuation, periodic_orbits,
};

const KEEP: ContinuationOptions = ContinuationOptions {
    beyond: Virtual::Keep,
    max_points: 400,
    heading: vibroimpact::Heading::Both,
    steps: [1e-8, 1e-3, 0.05],
    symmetric: None,
};

fn curve(
    special: &Special,
    plane: [Parameter; 2],
    between: [(f64, f64); 2],
) -> vibroimpact::Result<BifurcationCurve> {
    bifurcation_curve(CurveOf::Special(special), plane, between, &KEEP)
}

/// A mass between two stops under a force.
fn between_stops(force: f64) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![force.into()], 2.0, 0.0).expect("valid");
    let upper = Stop::new(0, 0.5, 0.6).expect("valid");
    let lower = Stop::new(0, 0.3, 0.8).expect("valid").on_side(Side::Lower);
    Scene::new(system, force, [upper, lower]).expect("valid")
}

#[test]
fn at_a_cusp_two_curves_of_folds_meet() {
    let plane = [Parameter::Frequency, Parameter::ForcingScale];
    let range = [(0.5, 4.0), (0.1, 4.0)];
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let mut forces = Vec::new();
    for force in [3.0, 4.0] {
        let found = periodic_orbits(&between_stops(force), &pattern, &OrbitOptions::default());
        let orbit = &found.expect("a search")[0];
        let branch = followed(orbit, Parameter::Frequency, range[0], &KEEP);
        let mut folds = branch.special.iter();
        let fold = folds.rfind(|own| own.kind == SpecialKind::Fold);
        let found = curve(fold.expect("one"), plane, range).expect("a curve");
        let cusp = found.special.iter().find(|own| own.kind == "cusp");
        let cusp = cusp.unwrap_or_else(|| panic!("{:?}", found.ends));
        assert!(cusp.error[0] < 1e-9 && cusp.error[1] < 1e-9);
        let [x, y] = cusp.parameters;
        forces.push((x, force * y));
        // Both arms lie on one side of it; on that side a branch has two folds, one on each arm, on the other none.
        let arm = |late: f64| {
            let away = found.arclength.iter().map(|s| s - cusp.arclength);
            let near = away
                .enumerate()
                .filter(|(_, s)| s * late > 0.0 && s.abs() > 0.02);
            let (k, _) = near
                .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
                .expect("points");
            k
        };
        let (one, other) = (arm(1.0), arm(-1.0));
        assert!((found.x[one] - x) * (found.x[other] - x) > 0.0);
        let start = &found.orbits[one];
        let at = Special {
            orbit: start.clone(),
            ..fold.expect("one").clone()
        };
        let through = followed(&at.orbit, Parameter::ForcingScale, (0.5, 2.0), &KEEP);
        let second = through
            .special
            .iter()
            .filter(|own| own.kind == SpecialKind::Fold)
            .map(|own| own.parameter * found.y[one])
            .filter(|own| (own - found.y[one]).abs() > 1e-7)
            .map(|own| (own - y).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(second < 3.0 * (found.y[one] - y).abs() + 1e-3, "{second}");
        let beyond = followed(&cusp.orbit, Parameter::ForcingScale, (0.95, 1.05), &KEEP);
        let folds = beyond
            .special
            .iter()
            .filter(|own| own.kind == SpecialKind::Fold);
        let off = folds
            .map(|own| (own.parameter - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-3, "{off}");
    }
    // The same cusp, of forces in other units.
    let off = (forces[0].0 - forces[1].0).abs() + (forces[0].1 - forces[1].1).abs();
    assert!(off < 1e-9, "{off:e}");
}

#[test]
fn two_stops_are_touched_at_once_where_both_are_as_far() {
    let own = crate::scenes::Oscillator {
        force: 4.0,
        ..USUAL
    };
    let lower = Stop::new(0, 1.4, 0.7).expect("valid").on_side(Side::Lower);
    let upper = Stop::new(0, 1.0, 0.8).expect("valid");
    let one = own.scene();
    let scene = Scene::new(one.system().clone(), one.forcing().clone(), [upper, lower]);
    let scene = scene.expect("valid");
    let found = periodic_orbits(&scene, &Pattern::none(), &OrbitOptions::default());
    let branch = followed(
        &found.expect("one")[0],
        Parameter::ForcingScale,
        (0.5, 2.0),
        &ContinuationOptions::default(),
    );
    let graze = &branch.special[0];
    let plane = [Parameter::Frequency, Parameter::CLEARANCE.of(1)];
    let found = curve(graze, plane, [(1.5, 3.5), (0.5, 2.0)]).expect("a curve");
    let double = found.special.iter().find(|own| own.kind == "double_graze");
    let double = double.unwrap_or_else(|| panic!("{:?}", found.ends));
    // The amplitude is that of one stop, and so far the other is.
    assert!((double.parameters[1] - 1.0).abs() < 1e-9 && (double.parameters[0] - 2.4).abs() < 1e-9);
    for gap in double.orbit.min_gap().expect("known") {
        assert!(gap.abs() < 1e-9, "{gap:e}");
    }
}

/// A scene of two or three coordinates, by its number.
fn scene_of(case: u64) -> Scene {
    let random = &mut Random::of_case(67, case);
    let n = 2 + (case % 2) as usize;
    let a = DMatrix::from_fn(n, n, |_, _| random.between(-1.5, 1.5));
    let k = &a * a.transpose() + DMatrix::identity(n, n) * 0.5;
    let c = &k * (0.1 * random.between(0.2, 1.0)) + DMatrix::identity(n, n) * 0.02;
    let m = DVector::from_fn(n, |_, _| random.between(0.5, 2.0));
    let system = LinearSystem::new(m, c, k).expect("valid");
    let force = DVector::from_fn(n, |_, _| Complex::new(random.between(-4.0, 4.0), 0.0));
    let force = Harmonic::new(force, random.between(0.5, 3.0), 0.0).expect("valid");
    let stop = Stop::new(0, random.between(-0.3, 0.8), random.between(0.3, 0.95)).expect("valid");
    Scene::new(system, force, [stop]).expect("valid")
}

fn multipliers(orbit: &PeriodicOrbit) -> Vec<Complex<f64>> {
    let orders = &orbit.stability().expect("multipliers").orders;
    let first = orders.first();
    first.map_or(Vec::new(), |own| own.multipliers.iter().copied().collect())
}

#[test]
fn resonances_are_where_the_multipliers_are_and_curves_meet_there() {
    let plane = [Parameter::Frequency, Parameter::ForcingScale];
    let range = [(0.3, 4.0), (0.1, 8.0)];
    let (mut seen, mut met) = ([0; 4], 0);
    for case in 0..14 {
        let scene = scene_of(case);
        let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
        let Some(orbit) = found.expect("a search").into_iter().next() else {
            continue;
        };
        let Ok(branch) = continuation(&orbit, Parameter::Frequency, range[0], &KEEP) else {
            continue;
        };
        let mut ends = Vec::new();
        for special in &branch.special {
            let is_one = matches!(
                special.kind,
                SpecialKind::Torus | SpecialKind::Fold | SpecialKind::PeriodDoubling
            );
            if !is_one {
                continue;
            }
            let Ok(found) = curve(special, plane, range) else {
                panic!("{case} {:?} {}", special.kind, special.parameter);
            };
            let angles = [1.0, 2.0, 3.0, 4.0].map(|k| TAU / k);
            for own in &found.special {
                let Some(k) = own.kind.strip_prefix("strong_1_") else {
                    continue;
                };
                let k: usize = k.parse().expect("a number");
                let at = Complex::from_polar(1.0, angles[k - 1]);
                // Beside a touch there are none.
                if multipliers(&own.orbit).is_empty() {
                    continue;
                }
                // Two that are equal are known to the root of what one is.
                let both = multipliers(&own.orbit);
                let near = both
                    .iter()
                    .filter(|mu| (*mu - at).norm() < 1e-4 || (*mu - at.conj()).norm() < 1e-4);
                let case = format!(
                    "{case} {:?} {} at {:?} {both:?}",
                    special.kind, own.kind, own.parameters
                );
                assert_eq!(near.count(), 2, "{case}");
                assert!(
                    own.error[0] < 1e-8 && own.error[1] < 1e-8,
                    "{case}: {:?}",
                    own.error
                );
                seen[k - 1] += 1;
                if k < 3 {
                    ends.push((special.kind, k, own.parameters));
                }
            }
            for end in &found.ends {
                let is_torus = special.kind == SpecialKind::Torus;
                assert!(!is_torus || end.reason != EndReason::Step, "{case} {end:?}");
            }
        }
        // A curve of tori ends on one of folds or of doublings.
        for (kind, k, at) in &ends {
            let others = ends.iter().filter(|own| own.0 != *kind && own.1 == *k);
            let off = others.map(|own| (own.2[0] - at[0]).abs() + (own.2[1] - at[1]).abs());
            met += usize::from(
                *kind == SpecialKind::Torus && off.fold(f64::INFINITY, f64::min) < 1e-8,
            );
        }
    }
    assert!(seen.iter().all(|n| *n > 0) && met > 0, "{seen:?} {met}");
}

#[test]
fn a_curve_of_folds_becomes_virtual_where_another_stop_is_touched() {
    let plane = [Parameter::Frequency, Parameter::ForcingScale];
    let mut seen = 0;
    for case in 0..12 {
        let random = &mut Random::of_case(68, case);
        let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
        let force = Harmonic::new(dvector![random.between(2.0, 6.0).into()], 2.4, 0.0);
        let upper =
            Stop::new(0, random.between(-0.5, 0.5), random.between(0.2, 0.9)).expect("valid");
        let lower = Stop::new(0, random.between(0.8, 2.0), 0.8)
            .expect("valid")
            .on_side(Side::Lower);
        let scene = Scene::new(system, force.expect("valid"), [upper, lower]).expect("valid");
        let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
        for orbit in found.expect("a search").into_iter().take(1) {
            let branch = followed(&orbit, Parameter::ForcingScale, (0.1, 4.0), &KEEP);
            for special in &branch.special {
                if !matches!(
                    special.kind,
                    SpecialKind::Fold | SpecialKind::PeriodDoubling
                ) {
                    continue;
                }
                let found = curve(special, plane, [(0.6, 4.0), (0.1, 6.0)]).expect("a curve");
                let touches: Vec<_> = found
                    .special
                    .iter()
                    .filter(|own| own.kind == "graze")
                    .collect();
                for touch in &touches {
                    let gaps = touch.orbit.min_gap().expect("known");
                    let least = gaps
                        .iter()
                        .map(|gap| gap.abs())
                        .fold(f64::INFINITY, f64::min);
                    assert!(
                        gaps.iter().all(|gap| *gap > -1e-9) && least < 1e-9,
                        "{case} {gaps:?}"
                    );
                }
                // Every change is named.
                let changes = found
                    .is_virtual
                    .windows(2)
                    .filter(|two| two[0] != two[1])
                    .count();
                let named = found
                    .special
                    .iter()
                    .filter(|own| own.kind != "fold_flip" && own.kind != "cusp");
                assert!(named.count() >= changes, "{case} {:?}", special.kind);
                seen += touches.len();
            }
        }
    }
    assert!(seen > 3, "{seen}");
}

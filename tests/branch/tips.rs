//! Doubled branches end where both rounds are one, at the doubling of the branch that they meet there.

use crate::random::Random;
use crate::scenes::{Oscillator, USUAL, beside_a_doubling, followed};
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Branch, ContinuationOptions, EndReason, Harmonic, Kind, LinearSystem, OrbitOptions,
    PaperOptions, Parameter, Pattern, PendulumChain, PeriodicOrbit, Scene, SimulateOptions,
    Special, SpecialKind, Stop, Virtual, branches, continuation_of, find_orbit, paper_scene,
    periodic_orbits, simulate,
};

fn kept() -> ContinuationOptions {
    ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    }
}

/// The doublings of a branch, its tips among them.
fn doublings(branch: &Branch) -> impl Iterator<Item = &Special> {
    let kind = SpecialKind::PeriodDoubling;
    branch.special.iter().filter(move |own| own.kind == kind)
}

/// The tips of a branch at its first and its last point.
fn tips(branch: &Branch) -> [Option<&Special>; 2] {
    let ends = [branch.special.first(), branch.special.last()];
    std::array::from_fn(|k| {
        let is_tip = branch.ends[k].reason == EndReason::Doubling;
        ends[k].filter(|_| is_tip)
    })
}

/// The tip of a branch that is nearest to a value, and whether it is the last point.
fn tip_near(branch: &Branch, value: f64) -> (&Special, bool) {
    let off = |own: &Special| (own.parameter - value).abs();
    match tips(branch) {
        [Some(first), Some(last)] if off(first) < off(last) => (first, false),
        [_, Some(last)] => (last, true),
        [Some(first), None] => (first, false),
        [None, None] => panic!("{value} {:?}", branch.ends),
    }
}

/// Checks that a doubled branch ends at a doubling that is known to so much, and that it has every orbit once.
fn check_tip(branch: &Branch, doubling: f64, known: f64) {
    let (tip, is_last) = tip_near(branch, doubling);
    let off = (tip.parameter - doubling).abs();
    assert!(off <= known, "{} {doubling} {off:e}", tip.parameter);
    assert!(tip.error <= known, "{:e}", tip.error);
    assert_eq!(tip.kind, SpecialKind::PeriodDoubling);
    let count = branch.orbits.len();
    let last = if is_last { count - 1 } else { 0 };
    let whole = &branch.orbits[last];
    assert_eq!(whole.n_periods(), 2 * tip.orbit.n_periods());
    assert_eq!(whole.impacts().len(), 2 * tip.orbit.impacts().len());
    // From one orbit to the next the rounds part the same way.
    let apart = |k: usize| {
        let impacts = branch.orbits[k].impacts();
        let half = impacts.len() / 2;
        let pairs = (0..half).map(|i| impacts[i].approach - impacts[i + half].approach);
        pairs.collect::<Vec<f64>>()
    };
    let size = whole
        .impacts()
        .iter()
        .fold(0.0f64, |m, own| m.max(own.approach.abs()));
    assert!(
        apart(last).iter().all(|d| d.abs() < 1e-9 * size),
        "{:?}",
        apart(last)
    );
    let is_tip =
        |k: usize| tips(branch)[usize::from(k > 0)].is_some() && (k == 0 || k == count - 1);
    for k in (1..count).filter(|&k| !is_tip(k - 1) && !is_tip(k)) {
        let (one, other) = (apart(k - 1), apart(k));
        let along: f64 = one.iter().zip(&other).map(|(a, b)| a * b).sum();
        assert!(along > 0.0, "{k} of {count}: {one:?} {other:?}");
    }
}

#[test]
fn a_doubled_branch_has_its_tip_at_the_closed_form() {
    let mut seen = 0;
    for case in 0..200 {
        let random = &mut Random::of_case(71, case);
        let Some((start, orbit)) = beside_a_doubling(random) else {
            continue;
        };
        let scale = Parameter::ForcingScale;
        let range = (0.8, 1.3);
        let branch = followed(&orbit, scale, range, &kept());
        for doubling in doublings(&branch) {
            let born = branches(doubling, scale, range).expect("branches");
            let force = |value: f64| {
                let oscillator = Oscillator {
                    force: value,
                    ..start
                };
                Ok(oscillator.scene())
            };
            let unit = start.force;
            let forces = (range.0 * unit, range.1 * unit);
            let along = |orbit: &PeriodicOrbit, at: f64| {
                continuation_of(orbit, &force, at, forces, &kept()).expect("a branch")
            };
            let found = along(&born[0].orbit, born[0].parameter * unit);
            let known = 1e-10 * unit;
            // Of several doublings it is one.
            let wanted = doubling.parameter * unit;
            check_tip(&found, wanted, known);
            // From its far end it comes back to the same tip.
            let (tip, is_last) = tip_near(&found, wanted);
            let far = if is_last { 1 } else { found.orbits.len() - 2 };
            let again = along(&found.orbits[far], found.parameter[far]);
            check_tip(&again, wanted, known);
            // There is the motion that it was doubled from.
            let parent = branches(tip, &force, forces).expect("one");
            assert_eq!(parent.len(), 1);
            assert_eq!(parent[0].orbit.n_periods(), 1);
            let miss = Oscillator {
                force: parent[0].parameter,
                ..start
            }
            .miss(1, parent[0].orbit.impacts()[0].approach);
            assert!(miss.abs() < 1e-9, "{miss:e}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}

/// Branches over the force that are doubled from one, and how many of them there are.
fn check_doubled(branch: &Branch, range: (f64, f64), known: f64) -> usize {
    let mut seen = 0;
    for doubling in doublings(branch) {
        for born in branches(doubling, Parameter::ForcingScale, range).expect("branches") {
            if born.orbit.n_periods() <= branch.orbits[0].n_periods() {
                continue;
            }
            let unit = born.parameter;
            let own = (range.0 / unit, range.1 / unit);
            let found = followed(&born.orbit, Parameter::ForcingScale, own, &kept());
            check_tip(&found, doubling.parameter / unit, known);
            seen += 1;
        }
    }
    seen
}

#[test]
fn between_two_doublings_a_doubled_branch_has_two_tips() {
    let own = Oscillator {
        eta: 0.05,
        frequency: 1.0,
        force: 1.8,
        clearance: 0.4,
        restitution: 0.8,
    };
    let (parameter, range) = (Parameter::Frequency, (0.6, 1.5));
    let orbits = own.orbits(1).into_iter();
    let mut kept = orbits.filter(|orbit| orbit.is_admissible() == Some(true));
    let options = ContinuationOptions::default();
    let branch = followed(&kept.next().expect("one"), parameter, range, &options);
    let doublings: Vec<&Special> = doublings(&branch).collect();
    let mut seen = 0;
    for doubling in &doublings {
        for born in branches(doubling, parameter, range).expect("branches") {
            let found = followed(&born.orbit, parameter, range, &options);
            if let [Some(first), Some(last)] = tips(&found) {
                seen += 1;
                for tip in [first, last] {
                    let is_there = |own: &&Special| (own.parameter - tip.parameter).abs() < 1e-10;
                    assert!(doublings.iter().any(is_there), "{}", tip.parameter);
                    check_tip(&found, tip.parameter, 1e-10);
                }
                assert!((first.parameter - last.parameter).abs() > 1e-3);
            }
        }
    }
    assert!(seen > 0);
}

/// One mass, by its mass, damping and stiffness, under a force of some frequency before a stop.
fn alone(numbers: [f64; 3], f: f64, w: f64, d: f64, e: f64) -> Scene {
    let [m, c, k] = numbers;
    let system = LinearSystem::new(dvector![m], dmatrix![c], dmatrix![k]).expect("valid");
    let force = Harmonic::new(dvector![f.into()], w, 0.0).expect("valid");
    Scene::new(system, force, [Stop::new(0, d, e).expect("valid")]).expect("valid")
}

/// The orbit of so many periods that one mass comes to from rest.
fn from_rest(scene: &Scene, n_periods: usize) -> PeriodicOrbit {
    let zero = dvector![0.0];
    let span = (0.0, 150.0 * scene.period().expect("forced"));
    let run = simulate(scene, &zero, &zero, span, &SimulateOptions::default());
    find_orbit(scene, &run.expect("a run"), Some(n_periods)).expect("an orbit")
}

/// From whichever of its orbits a doubled branch is followed: here one whose tip lies beside a graze, and one whose parent has a fold next to
/// the doubling.
#[test]
fn a_tip_is_found_from_everywhere() {
    let w = 3.912_097_754_468_318_6;
    let graze = alone(
        [1.125_483_89, 0.080_923_51, 1.953_028_86],
        -6.766_161_28,
        w,
        0.460_125_646_651_300_4,
        0.931_094_959_802_558_2,
    );
    let w = 1.432_159_251_034_394_8;
    let fold = alone(
        [1.777_606, 0.205_124_37, 0.531_492_14],
        -3.001_581_24,
        w,
        0.390_569_771_781_631_3,
        0.558_925_190_779_223_5,
    );
    let options = ContinuationOptions::default();
    for (scene, parameter, range, near) in [
        (graze, Parameter::Frequency, (3.042, 4.639), 3.8663),
        (fold, Parameter::CLEARANCE, (0.05, 2.0), 0.39794),
    ] {
        let orbit = from_rest(&scene, 4);
        let parent = followed(&orbit, parameter, range, &options);
        let doubling = doublings(&parent)
            .find(|own| (own.parameter - near).abs() < 1e-3)
            .expect("one");
        let born = branches(doubling, parameter, range).expect("branches");
        let whole = followed(&born[0].orbit, parameter, range, &options);
        check_tip(&whole, doubling.parameter, 1e-10);
        let count = whole.orbits.len();
        for k in (1..count - 1).step_by(3) {
            let again = followed(&whole.orbits[k], parameter, range, &options);
            check_tip(&again, doubling.parameter, 1e-10);
            assert_eq!(
                tips(&again).map(|own| own.is_some()),
                tips(&whole).map(|own| own.is_some()),
                "{k}"
            );
        }
    }
}

#[test]
fn many_modes_have_their_tips_too() {
    let mut seen = 0;
    for case in 0..60 {
        let random = &mut Random::of_case(83, case);
        let n = if random.chance(50) { 12 } else { 2 };
        let system = LinearSystem::new(
            DVector::from_element(n, 1.0),
            DVector::from_fn(n, |i, _| 0.1 * (1.0 + i as f64)),
            DVector::from_fn(n, |i, _| (1.0 + i as f64).powi(2)),
        );
        let force = DVector::from_fn(n, |i, _| (8.5 / (1.0 + 3.0 * i as f64)).into());
        let force = Harmonic::new(force, random.between(2.2, 2.9), 0.0).expect("valid");
        let normal = DVector::from_fn(n, |i, _| 1.0 / (1.0 + 2.0 * i as f64));
        let stop = Stop::new(normal, random.between(0.5, 1.2), random.between(0.6, 0.9));
        let scene = Scene::new(system.expect("valid"), force, [stop.expect("valid")]);
        let scene = scene.expect("valid");
        let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
        for orbit in found.expect("a search").iter() {
            let branch = followed(orbit, Parameter::ForcingScale, (0.5, 2.0), &kept());
            seen += check_doubled(&branch, (0.5, 2.0), 1e-9);
        }
    }
    assert!(seen > 10, "{seen}");
}

#[test]
fn large_motions_of_a_pendulum_have_their_tip() {
    let options = PaperOptions {
        linear: false,
        ..PaperOptions::default()
    };
    let scene = paper_scene(Kind::Three, &options).expect("valid");
    let (q, v) = (dvector![0.1, -0.1], dvector![0.0, 0.0]);
    let until = 120.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    assert_eq!(orbit.n_periods(), 4);
    let w = std::f64::consts::TAU * orbit.n_periods() as f64 / orbit.period();
    let range = (0.97 * w, 1.03 * w);
    let found = followed(&orbit, Parameter::Frequency, range, &kept());
    let (tip, _) = tip_near(&found, w);
    let parent = branches(tip, Parameter::Frequency, range).expect("one");
    assert_eq!(parent[0].orbit.n_periods(), 2);
    let near = scene_of(&parent[0].orbit, 1.0001 * tip.parameter);
    let beside = find_orbit(&near, &parent[0].orbit, None).expect("beside it");
    let branch = followed(&beside, Parameter::Frequency, range, &kept());
    let doubling = doublings(&branch).next();
    check_tip(&found, doubling.expect("one").parameter, 1e-9);
}

fn scene_of(orbit: &PeriodicOrbit, w: f64) -> Scene {
    orbit
        .scene()
        .replace(Parameter::Frequency.change(w))
        .expect("valid")
}

/// Two rounds of a motion as one are no doubled one: they are followed as one round is.
#[test]
fn one_round_gone_through_twice_is_not_cut_short() {
    let scene = USUAL.scene();
    let [one, two] = [1, 2].map(|rounds| {
        let orbit = from_rest(&scene, rounds);
        assert_eq!(orbit.impacts().len(), rounds);
        followed(
            &orbit,
            Parameter::ForcingScale,
            (0.5, 1.5),
            &ContinuationOptions::default(),
        )
    });
    for k in [0, 1] {
        assert_eq!(one.ends[k].reason, two.ends[k].reason, "{:?}", two.ends);
    }
    let ends = |branch: &Branch| {
        [
            branch.parameter[0],
            branch.parameter[branch.parameter.len() - 1],
        ]
    };
    for (a, b) in ends(&one).iter().zip(ends(&two)) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
    // Where one round doubles another branch of two is crossed.
    let doubling = doublings(&one).next();
    let crossing = two
        .special
        .iter()
        .find(|own| own.kind == SpecialKind::BranchPoint);
    let off = (doubling.expect("one").parameter - crossing.expect("one").parameter).abs();
    assert!(off < 1e-10, "{off:e}");
}

/// Two doubled branches that come close to each other without crossing: what is found does not depend on the steps.
#[test]
fn long_steps_do_not_lead_from_a_branch_to_one_that_is_close() {
    let d = 0.239_615_881_103_708_35;
    let scene = alone(
        [1.529_191_71, 0.074_127_08, 1.575_206],
        2.237_660_78,
        2.376_320_347_235_399,
        d,
        0.491_283_905_216_844,
    );
    let orbit = from_rest(&scene, 3);
    let (parameter, range) = (Parameter::CLEARANCE, (0.05, 2.0));
    let (usual, short) = (
        ContinuationOptions::default(),
        ContinuationOptions {
            steps: [1e-8, 1e-4, 2e-3],
            max_points: 5000,
            ..ContinuationOptions::default()
        },
    );
    let parent = followed(&orbit, parameter, range, &usual);
    let mut seen = 0;
    for doubling in doublings(&parent) {
        let born = branches(doubling, parameter, range).expect("branches");
        let all = [&usual, &short].map(|options| {
            let branch = followed(&born[0].orbit, parameter, range, options);
            let special = branch.special.iter();
            special
                .map(|own| (own.kind, own.parameter))
                .collect::<Vec<_>>()
        });
        let [long, fine] = &all;
        assert_eq!(long.len(), fine.len(), "{all:?}");
        for ((one, at), (other, there)) in long.iter().zip(fine) {
            assert!(one == other && (at - there).abs() < 1e-9, "{all:?}");
        }
        seen += 1;
    }
    assert_eq!(seen, 2);
}

/// `x'' + x'/2 + sin x = f cos(2 t/3)` hits nothing; its first doubling is at f = 1.0663 (Baker, Gollub, Chaotic Dynamics, 1990).
#[test]
fn a_driven_pendulum_that_hits_nothing_has_its_tip_where_it_is_known() {
    let chain = PendulumChain::new(dvector![1.0], dvector![1.0], &dvector![0.5], 1.0);
    let scene = |f: f64| {
        let force = Harmonic::new(dvector![f.into()], 2.0 / 3.0, 0.0).expect("valid");
        Scene::new(chain.clone().expect("valid"), force, Vec::<Stop>::new())
    };
    let begun = scene(1.07).expect("valid");
    let (q, v) = (dvector![1.5], dvector![0.0]);
    let until = 600.0 * begun.period().expect("forced");
    let run = simulate(&begun, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&begun, &run.expect("a run"), Some(2)).expect("an orbit");
    let found = continuation_of(&orbit, &scene, 1.07, (1.05, 1.075), &kept()).expect("a branch");
    let (tip, _) = tip_near(&found, 1.0663);
    assert!(
        (1.0663..1.0664).contains(&tip.parameter),
        "{}",
        tip.parameter
    );
    let parent = branches(tip, &scene, (1.05, 1.075)).expect("one");
    let (orbit, at) = (&parent[0].orbit, 1.06);
    let orbit = find_orbit(&scene(at).expect("valid"), orbit, None).expect("beside it");
    let branch = continuation_of(&orbit, &scene, at, (1.05, 1.075), &kept()).expect("one");
    let doubling = doublings(&branch).next();
    let doubling = doubling.unwrap_or_else(|| panic!("{:?} {:?}", branch.parameter, branch.ends));
    let off = (doubling.parameter - tip.parameter).abs();
    assert!(off < 1e-10, "{off:e}");
}

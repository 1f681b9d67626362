//! Branches of scenes of many modes, which are followed by their impulses: what is found holds of the orbits, as their dense matrices say.

use crate::random::Random;
use crate::scenes::followed;
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{Complex, DMatrix, DVector};
use vibroimpact::{
    Branch, Candidate, ContinuationOptions, Harmonic, LinearSystem, OrbitOptions, Parameter,
    Pattern, PeriodicOrbit, Scene, SimulateOptions, SpecialKind, Stop, Virtual, branches,
    find_orbit, periodic_orbits, simulate,
};

/// Unit masses coupled at random, whose modes decay.
fn scene(random: &mut Random, n: usize, stops: usize) -> Scene {
    let half = random.matrix(n);
    let stiffness = &half * half.transpose() / n as f64 * 4.0 + DMatrix::identity(n, n);
    let damping = DMatrix::identity(n, n) * 0.04 + &stiffness * 0.03;
    let system = LinearSystem::new(DMatrix::identity(n, n), damping, stiffness).expect("valid");
    let force: Vec<Complex<f64>> = random.vector(n).iter().map(|&x| x.into()).collect();
    let force = Harmonic::new(DVector::from_vec(force), random.between(0.7, 1.6), 0.0);
    let stops = (0..stops).map(|i| {
        let stop = Stop::new(i, random.between(0.02, 0.1), random.between(0.5, 0.9));
        stop.expect("valid")
    });
    Scene::new(system, force.expect("valid"), stops.collect::<Vec<_>>()).expect("valid")
}

/// An orbit of one impact, or one that a run settles on.
fn orbit(random: &mut Random, scene: &Scene) -> Option<PeriodicOrbit> {
    let found = periodic_orbits(scene, &Pattern::single(0), &OrbitOptions::default()).ok()?;
    if let Some(orbit) = found
        .iter()
        .find(|orbit| orbit.is_admissible() == Some(true))
        && random.chance(50)
    {
        return Some(orbit.clone());
    }
    let rest = DVector::zeros(scene.n_dof());
    let span = (0.0, 200.0 * scene.period()?);
    let run = simulate(scene, &rest, &rest, span, &SimulateOptions::default()).ok()?;
    find_orbit(scene, &run, None).ok()
}

/// How many multipliers of an orbit lie outside the circle, by its dense matrix; none if one is next to it.
fn outside(orbit: &PeriodicOrbit) -> Option<usize> {
    let stability = orbit.stability().expect("multipliers");
    let all = &stability.orders.first()?.multipliers;
    if all.iter().any(|mu| (mu.norm() - 1.0).abs() < 1e-6) {
        return None;
    }
    Some(all.iter().filter(|mu| mu.norm() > 1.0).count())
}

/// Whether a number is a multiplier.
fn has(orbit: &PeriodicOrbit, mu: Complex<f64>, tolerance: f64) -> bool {
    let stability = orbit.stability().expect("multipliers");
    let all = &stability.orders[0].multipliers;
    all.iter().any(|own| (own - mu).norm() < tolerance)
}

fn check(branch: &Branch, case: u64) {
    let counts = branch.n_unstable().expect("counts");
    for (k, (orbit, count)) in branch.orbits.iter().zip(&counts).enumerate().step_by(3) {
        if let Some(exact) = outside(orbit) {
            assert_eq!(*count, Some(exact), "{case} {k} at {}", branch.parameter[k]);
        }
        // It closes: another search finds it where it is.
        let again = find_orbit(orbit.scene(), orbit, None).expect("closed");
        let off = (again.v0() - orbit.v0()).amax() / orbit.v0().amax();
        // Beside folds what closes to 1e-11 is known to less.
        assert!(off < 1e-7, "{case} {k}: {off:e}");
    }
}

#[test]
fn orbits_close_and_their_multipliers_are_counted() {
    let (mut points, mut special) = (0, [0; 4]);
    for case in 0..14 {
        let mut random = Random::of_case(2718, case);
        let stops = 1 + random.below(2);
        let n = 24 + random.below(3);
        let own = scene(&mut random, n, stops);
        let Some(first) = orbit(&mut random, &own) else {
            continue;
        };
        if first.impacts().is_empty() {
            continue;
        }
        let (parameter, range) = random.of(&[
            (Parameter::ForcingScale, (0.3, 3.0)),
            (Parameter::Frequency, (0.6, 1.8)),
            (Parameter::CLEARANCE.of(0), (0.001, 0.2)),
            (Parameter::RESTITUTION.of(0), (0.05, 0.95)),
        ]);
        let options = ContinuationOptions {
            beyond: Virtual::Keep,
            max_points: 60,
            ..ContinuationOptions::default()
        };
        let branch = followed(&first, parameter, range, &options);
        // Through lasting contact all unknowns are followed.
        if branch.outside.is_none() {
            continue;
        }
        check(&branch, case);
        points += branch.orbits.len();
        for found in &branch.special {
            match found.kind {
                SpecialKind::Fold => {
                    special[0] += 1;
                    assert!(has(&found.orbit, Complex::new(1.0, 0.0), 1e-4));
                }
                SpecialKind::PeriodDoubling => {
                    special[1] += 1;
                    assert!(has(&found.orbit, Complex::new(-1.0, 0.0), 1e-6));
                    let born = branches(found, parameter, range).expect("a search");
                    // At a tip it is the one of half the period.
                    let is_doubled =
                        |own: &&Candidate| own.orbit.n_periods() > found.orbit.n_periods();
                    if let Some(twice) = born.first().filter(is_doubled) {
                        special[3] += 1;
                        assert_eq!(twice.orbit.n_periods(), 2 * found.orbit.n_periods());
                        let next = followed(
                            &twice.orbit,
                            parameter,
                            range,
                            &ContinuationOptions {
                                max_points: 5,
                                ..options.clone()
                            },
                        );
                        check(&next, case);
                    }
                }
                SpecialKind::Torus => {
                    special[2] += 1;
                    let turn = TAU * found.rotation.expect("a pair");
                    assert!(has(&found.orbit, Complex::from_polar(1.0, turn), 1e-6));
                }
                _ => {}
            }
        }
    }
    assert!(
        points > 300 && special[0] > 2 && special[1] > 2,
        "{points} {special:?}"
    );
}

/// A scene of some coordinates, alone or among others that see nothing, with the range of a number.
struct Padded<'a> {
    stiffness: &'a [f64],
    damping: &'a [f64],
    force: &'a [f64],
    normal: &'a [f64],
    numbers: [f64; 3],
    parameter: Parameter,
    range: (f64, f64),
}

impl Padded<'_> {
    fn branch(&self, n: usize) -> Branch {
        let with = |own: &[f64], rest: f64| {
            DVector::from_fn(n, |i, _| own.get(i).copied().unwrap_or(rest))
        };
        let ones = DVector::from_element(n, 1.0);
        let system = LinearSystem::new(ones, with(self.damping, 6.0), with(self.stiffness, 25.0));
        let [w, clearance, restitution] = self.numbers;
        let force = with(self.force, 0.0).map(Complex::from);
        let force = Harmonic::new(force, w, 0.0).expect("valid");
        let stop = Stop::new(with(self.normal, 0.0), clearance, restitution).expect("valid");
        let own = Scene::new(system.expect("valid"), force, [stop]).expect("valid");
        let found = periodic_orbits(&own, &Pattern::single(0), &OrbitOptions::default());
        let found = found.expect("a search");
        let mut admissible = found.iter().filter(|own| own.is_admissible() == Some(true));
        let first = admissible.next().expect("one");
        followed(
            first,
            self.parameter,
            self.range,
            &ContinuationOptions::default(),
        )
    }
}

#[test]
fn coordinates_that_see_nothing_change_nothing() {
    let light = Padded {
        stiffness: &[1.0, 4.41, 5.29],
        damping: &[0.006, 0.0126, 0.0138],
        force: &[1.0, 0.0, 0.0],
        normal: &[1.0, 0.2, 0.1],
        numbers: [1.37, 0.0, 0.6],
        parameter: Parameter::DampingScale,
        range: (0.05, 3.0),
    };
    let all = [
        Padded {
            parameter: Parameter::Frequency,
            range: (1.25, 1.5),
            ..light
        },
        light,
        Padded {
            stiffness: &[1.0],
            damping: &[0.33],
            force: &[1.0],
            normal: &[1.0],
            numbers: [2.92, -0.0512, 0.5482],
            parameter: Parameter::Frequency,
            range: (1.75, 4.7),
        },
        Padded {
            stiffness: &[1.261, 1.8535],
            damping: &[0.1586, 0.0792],
            force: &[-0.3144, -0.4272],
            normal: &[1.0, 0.6661],
            numbers: [1.35245, 0.28239, 0.47239],
            parameter: Parameter::DampingScale,
            range: (0.2, 3.0),
        },
        Padded {
            stiffness: &[2.861_910_821_358_6, 2.109_868_731_835_738],
            damping: &[0.010_317_814_036_700_708, 0.012_073_781_974_692_098],
            force: &[-0.833_817_128_841_376_3, 0.131_233_533_733_696_1],
            normal: &[1.0, 0.431_960_786_441_107_75],
            numbers: [
                2.460_389_466_524_633_4,
                -0.031_869_857_086_653_09,
                0.706_469_602_967_259,
            ],
            parameter: Parameter::CLEARANCE.of(0),
            range: (-1.0, 1.0),
        },
        Padded {
            stiffness: &[1.0],
            damping: &[0.02],
            force: &[1.0],
            normal: &[1.0],
            numbers: [2.5, 0.0, 0.6],
            parameter: Parameter::DampingScale,
            range: (0.0, 3.0),
        },
    ];
    for (case, own) in all.iter().enumerate() {
        let (few, many) = (own.branch(own.stiffness.len()), own.branch(24));
        let width = own.range.1 - own.range.0;
        let list = |branch: &Branch| -> Vec<_> {
            let special = branch.special.iter();
            special
                .map(|own| (own.kind, (own.parameter / width * 1e6).round()))
                .collect()
        };
        assert_eq!(
            list(&few),
            list(&many),
            "{case} {:?} {:?}",
            few.ends,
            many.ends
        );
        for (one, other) in few.ends.iter().zip(&many.ends) {
            assert_eq!(one.reason, other.reason, "{case}");
        }
        let counts = many.n_unstable().expect("counts");
        for (orbit, count) in many.orbits.iter().zip(counts).step_by(5) {
            if let Some(exact) = outside(orbit) {
                assert_eq!(count, Some(exact), "{case} {}", orbit.phase());
            }
        }
    }
}

/// What hits nothing is the response to the forcing, to which many modes are no more than few: `x = Re (k - m w^2 + i c w)^-1 f e^{iwt}` of
/// each comes to the stop where its largest sum along the normal does.
#[test]
fn a_motion_that_hits_nothing_is_followed_to_its_touch() {
    const CLEARANCE: f64 = 0.5;
    for n in [24, 60] {
        let of = |f: fn(f64) -> f64| DVector::from_fn(n, |i, _| f(1.0 + i as f64));
        let (m, c, k) = (of(|_| 1.0), of(|w| 0.02 * w), of(|w| w * w));
        let (f, normal) = (of(|w| 1.0 / w), of(|w| 1.0 / (0.9 + 0.1 * w)));
        let system = LinearSystem::new(m, c.clone(), k.clone()).expect("valid");
        let force = Harmonic::new(f.map(Complex::from), 2.4, 0.3).expect("valid");
        let stop = Stop::new(normal.clone(), CLEARANCE, 0.8).expect("valid");
        let scene = Scene::new(system, force, [stop]).expect("valid");
        let found = periodic_orbits(&scene, &Pattern::none(), &OrbitOptions::default());
        let rest = &found.expect("one")[0];
        let touch = |w: f64| {
            let each = (0..n).map(|i| normal[i] * f[i] / Complex::new(k[i] - w * w, c[i] * w));
            each.sum::<Complex<f64>>().norm()
        };
        let (scale, range) = (Parameter::ForcingScale, (0.2, 3.0));
        let branch = followed(rest, scale, range, &ContinuationOptions::default());
        assert!(branch.outside.is_some(), "{n}");
        assert!(
            branch
                .n_unstable()
                .expect("counts")
                .iter()
                .all(|own| *own == Some(0))
        );
        let graze = branch.special.last().expect("a touch");
        assert_eq!(graze.kind, SpecialKind::Graze);
        let off = (graze.parameter * touch(2.4) / CLEARANCE - 1.0).abs();
        assert!(off < 1e-10, "{n} {off:e}");
        for (orbit, value) in branch.orbits.iter().zip(&branch.parameter) {
            let least = CLEARANCE - value * touch(2.4);
            assert!(
                (orbit.min_gap().expect("gaps")[0] - least).abs() < 1e-10,
                "{n} {value}"
            );
        }
        // What is born there is followed by its impulse.
        let born = branches(graze, scale, range).expect("branches");
        let one = born
            .iter()
            .find(|own| own.orbit.impacts().len() == 1)
            .expect("one");
        let unit = one.parameter;
        let options = ContinuationOptions {
            beyond: Virtual::Keep,
            max_points: 10,
            ..ContinuationOptions::default()
        };
        let next = followed(&one.orbit, scale, (0.2 / unit, 3.0 / unit), &options);
        assert!(next.outside.is_some() && next.orbits.len() > 5);
        // Over the frequency the phase at which it begins stays, too.
        let over = followed(rest, Parameter::Frequency, (2.3, 2.6), &options);
        for (orbit, w) in over.orbits.iter().zip(&over.parameter) {
            assert!((orbit.min_gap().expect("gaps")[0] - (CLEARANCE - touch(*w))).abs() < 1e-10);
        }
    }
}

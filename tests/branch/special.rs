//! Special points against closed forms, and the law that multipliers cross the unit circle at them alone.

use crate::random::Random;
use crate::scenes::{Oscillator, USUAL, followed};
use vibroimpact::nalgebra::{Complex, DMatrix, DVector, dvector};
use vibroimpact::{
    BaseMotion, Branch, ContinuationOptions, CurveOf, Harmonic, ImpactSide, LinearSystem, Motion,
    OrbitOptions, Parameter, Pattern, PendulumChain, Scene, SimulateOptions, Special, SpecialKind,
    Stop, Virtual, Wall, WallSide, bifurcation_curve, find_orbit, periodic_orbits, simulate,
};

fn keep() -> ContinuationOptions {
    ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    }
}

fn of(branch: &Branch, kind: SpecialKind) -> Vec<&Special> {
    branch
        .special
        .iter()
        .filter(|own| own.kind == kind)
        .collect()
}

#[test]
fn the_fold_and_the_doubling_of_a_preloaded_stop() {
    let own = Oscillator {
        force: 1.0,
        frequency: 2.8,
        clearance: -0.5,
        ..USUAL
    };
    let orbit = &own.orbits(1)[0];
    let branch = followed(orbit, Parameter::ForcingScale, (0.2, 9.0), &keep());
    let [fold] = of(&branch, SpecialKind::Fold)[..] else {
        panic!("{:?}", branch.special.len());
    };
    assert!(
        (fold.parameter - 0.393_225_563_977_3).abs() < 1e-12,
        "{}",
        fold.parameter
    );
    assert!((fold.orbit.impacts()[0].approach - 1.137_306_814_6).abs() < 1e-5);
    let doublings = of(&branch, SpecialKind::PeriodDoubling);
    let found: Vec<f64> = doublings.iter().map(|own| own.parameter).collect();
    assert!(
        found.iter().any(|p| (p - 7.748_237_460_8).abs() < 1e-9),
        "{found:?}"
    );
    for own in [fold, doublings[0]] {
        assert!(own.error < 1e-9, "{:e}", own.error);
        let place = branch
            .arclength
            .partition_point(|length| *length < own.arclength);
        assert!(place > 0 && place < branch.arclength.len());
    }
}

/// Every fold and doubling of one oscillator lies where the closed form has it, and none is missing where the force is followed.
fn check(own: Oscillator, n_periods: usize, parameter: Parameter, branch: &Branch) -> usize {
    let width = branch
        .parameter
        .iter()
        .fold(0.0f64, |w, p| w.max((p - branch.parameter[0]).abs()));
    for special in &branch.special {
        let speed = special.orbit.impacts()[0].approach;
        let miss = |value: f64| {
            let there = own.at(parameter, value);
            let force = match special.kind {
                SpecialKind::Fold if parameter == Parameter::ForcingScale => {
                    there.force_of(n_periods, there.fold_speed(n_periods))
                }
                SpecialKind::PeriodDoubling => {
                    there.force_of(n_periods, there.doubling_speed(n_periods))
                }
                _ => there.force_of(n_periods, speed),
            };
            force / there.force - 1.0
        };
        // Where the closed form depends little on the number, it is known less well than its orbit.
        let off = miss(special.parameter).abs();
        let step = 1e-6 * width;
        let slope =
            (miss(special.parameter + step) - miss(special.parameter - step)) / (2.0 * step);
        let error = off / slope.abs();
        assert!(
            off < 1e-9 || error < 1e-10 * width,
            "{own:?} {parameter} {:?} at {} {off:e} {error:e}",
            special.kind,
            special.parameter
        );
    }
    if parameter == Parameter::ForcingScale {
        let (low, high) = (
            branch.parameter[0],
            branch.parameter[branch.parameter.len() - 1],
        );
        let speeds: Vec<f64> = branch
            .orbits
            .iter()
            .map(|own| own.impacts()[0].approach)
            .collect();
        let range = [low.min(high), low.max(high)];
        let least = speeds.iter().copied().fold(f64::INFINITY, f64::min);
        let most = speeds.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let wanted = [own.fold_speed(n_periods), own.doubling_speed(n_periods)];
        for (kind, speed) in [SpecialKind::Fold, SpecialKind::PeriodDoubling]
            .into_iter()
            .zip(wanted)
        {
            if speed > least && speed < most {
                assert!(
                    !of(branch, kind).is_empty(),
                    "{own:?} {kind:?} {speed} {range:?}"
                );
            }
        }
    }
    branch.special.len()
}

#[test]
fn special_points_lie_on_their_closed_forms() {
    let random = &mut Random::new(18);
    let mut count = 0;
    for _ in 0..200 {
        let own = Oscillator {
            eta: 0.3 * random.unit(),
            force: 0.5 + 8.0 * random.unit(),
            frequency: 0.6 + 3.0 * random.unit(),
            clearance: 2.0 * random.unit() - 0.8,
            restitution: 0.95 * random.unit(),
        };
        let n_periods = 1 + (2.0 * random.unit()) as usize;
        let (parameter, range) = match (5.0 * random.unit()) as usize {
            0 => (Parameter::Frequency, (0.5, 4.0)),
            1 => (Parameter::CLEARANCE, (-1.0, 1.5)),
            2 => (Parameter::RESTITUTION, (0.0, 1.0)),
            3 => (Parameter::DampingScale, (0.1, 3.0)),
            _ => (Parameter::ForcingScale, (0.05, 4.0)),
        };
        for orbit in own.orbits(n_periods).iter().take(1) {
            let branch = followed(orbit, parameter, range, &keep());
            count += check(own, n_periods, parameter, &branch);
        }
    }
    assert!(count > 50, "{count}");
}

#[test]
fn multipliers_cross_the_circle_at_special_points_alone() {
    for (own, parameter, range) in [
        (USUAL, Parameter::ForcingScale, (0.6, 2.0)),
        (USUAL, Parameter::Frequency, (2.05, 3.5)),
        (
            Oscillator {
                force: 1.0,
                frequency: 2.8,
                clearance: -0.5,
                ..USUAL
            },
            Parameter::ForcingScale,
            (0.2, 9.0),
        ),
    ] {
        let branch = followed(
            &own.orbits(1)[0],
            parameter,
            range,
            &ContinuationOptions::default(),
        );
        let counts = branch.n_unstable().expect("multipliers");
        for k in 1..counts.len() {
            let [before, after] = [k - 1, k].map(|k| counts[k].expect("a derivative"));
            let span = branch.arclength[k - 1]..branch.arclength[k];
            let crossed = branch.special.iter().filter(|own| {
                let is_crossing =
                    [SpecialKind::Fold, SpecialKind::PeriodDoubling].contains(&own.kind);
                is_crossing && span.contains(&own.arclength)
            });
            assert_eq!(
                before.abs_diff(after) % 2,
                crossed.count() % 2,
                "{parameter} {span:?}"
            );
        }
    }
}

#[test]
fn boundaries_are_named() {
    let options = ContinuationOptions::default();
    let orbit = &USUAL.orbits(1)[0];
    let branch = followed(orbit, Parameter::ForcingScale, (0.1, 2.0), &options);
    let [lost] = of(&branch, SpecialKind::LostImpact)[..] else {
        panic!("{:?}", branch.special);
    };
    assert_eq!((lost.stop, lost.parameter), (Some(0), branch.parameter[0]));
    let touch = USUAL.closed(1).z * USUAL.clearance / USUAL.force;
    assert!(
        (lost.parameter - touch).abs() <= lost.error.max(1e-10),
        "{} {touch} {:e}",
        lost.parameter,
        lost.error
    );
    // The motion that hits nothing comes to the same force from below.
    let quiet = Oscillator {
        force: 1.0,
        ..USUAL
    };
    let found = periodic_orbits(&quiet.scene(), &Pattern::none(), &OrbitOptions::default());
    let branch = followed(
        &found.expect("one")[0],
        Parameter::ForcingScale,
        (0.1, 9.0),
        &options,
    );
    let [graze] = of(&branch, SpecialKind::Graze)[..] else {
        panic!("{:?}", branch.special);
    };
    assert!((graze.parameter - touch * USUAL.force).abs() < 1e-9);
    assert_eq!(graze.stop, Some(0));
    // On the slow side of a fold the stop that is hit is touched in between.
    let preloaded = Oscillator {
        force: 1.0,
        frequency: 2.8,
        clearance: -0.5,
        ..USUAL
    };
    let orbit = &preloaded.orbits(1)[0];
    let branch = followed(orbit, Parameter::ForcingScale, (0.2, 9.0), &options);
    let [graze] = of(&branch, SpecialKind::Graze)[..] else {
        panic!("{:?}", branch.special);
    };
    let (time, period) = (graze.time.expect("a time"), graze.orbit.period());
    assert!(time > 0.1 * period && time < 0.9 * period, "{time}");
    let (q, v) = graze.orbit.state(time, ImpactSide::After).expect("a time");
    assert!((q[0] + 0.5).abs() < 1e-8 && v[0].abs() < 1e-4, "{q} {v}");
}

/// The sum of all changes of the number of multipliers outside the circle that special points stand for, in a range of arclength.
fn jumps(branch: &Branch, from: f64, to: f64) -> usize {
    let own = branch
        .special
        .iter()
        .filter(|own| own.arclength > from && own.arclength <= to);
    own.map(|own| match own.kind {
        SpecialKind::Fold
        | SpecialKind::PeriodDoubling
        | SpecialKind::Pitchfork
        | SpecialKind::BranchPoint => 1,
        SpecialKind::Torus => 2,
        _ => 0,
    })
    .sum()
}

/// How fast moduli of multipliers change with the number about a special point, by the points beside it.
fn rate(branch: &Branch, special: &Special) -> f64 {
    let k = branch.arclength.partition_point(|s| *s < special.arclength);
    let [before, after] = [k - 1, k].map(|k| {
        let orders = &branch.orbits[k].stability().expect("multipliers").orders;
        let all = orders[0].multipliers.iter();
        all.map(|mu| mu.norm()).collect::<Vec<f64>>()
    });
    let pairs = before.iter().zip(&after).map(|(a, b)| (a - b).abs());
    let change = pairs.fold(0.0, f64::max);
    change / (branch.parameter[k] - branch.parameter[k - 1]).abs()
}

#[test]
fn multipliers_leave_the_circle_at_special_points_alone() {
    let (mut tori, mut changes) = (0, 0);
    for case in 0..120 {
        let random = &mut Random::of_case(91, case);
        let n = 2 + random.below(2);
        let half = random.matrix(n);
        let stiffness = DMatrix::identity(n, n) + &half * half.transpose();
        let damping = &stiffness * random.between(0.002, 0.1);
        let mut force = random.vector(n).map(Complex::from);
        force[0] += 1.0;
        let system = LinearSystem::new(DVector::from_element(n, 1.0), damping, stiffness);
        let force = Harmonic::new(force, random.between(0.5, 3.0), 0.0).expect("valid");
        let stop = Stop::new(n - 1, random.between(-0.3, 0.5), random.between(0.2, 0.95));
        let scene =
            Scene::new(system.expect("valid"), force, [stop.expect("valid")]).expect("valid");
        let Ok(found) = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())
        else {
            continue;
        };
        for orbit in found {
            let branch = followed(&orbit, Parameter::Frequency, (0.4, 3.5), &keep());
            let counts = branch.n_unstable().expect("multipliers");
            for k in 1..counts.len() {
                let (Some(one), Some(other)) = (counts[k - 1], counts[k]) else {
                    continue;
                };
                let jumps = jumps(&branch, branch.arclength[k - 1], branch.arclength[k]);
                let change = one.abs_diff(other);
                assert!(
                    change <= jumps && (jumps - change).is_multiple_of(2),
                    "{case} at {}: {one} to {other}, {jumps}",
                    branch.parameter[k]
                );
                changes += change;
            }
            for torus in of(&branch, SpecialKind::Torus) {
                let rotation = torus.rotation.expect("a number");
                let orders = &torus.orbit.stability().expect("multipliers").orders;
                let turned = Complex::from_polar(1.0, std::f64::consts::TAU * rotation);
                let off = orders[0].multipliers.iter().map(|mu| (mu - turned).norm());
                let off = off.fold(f64::INFINITY, f64::min);
                // As well as multipliers are known, a closed motion being so to 1e-11, and what the number's error makes of them.
                let known = 1e-9 + 2.0 * torus.error * rate(&branch, torus);
                assert!(off < known, "{off:e}, known to {known:e}");
                assert!(rotation > 0.0 && rotation < 0.5 && torus.error < 1e-9);
                if tori < 3 {
                    check_curve(torus);
                }
                tori += 1;
            }
        }
    }
    assert!(tori > 5 && changes > 50, "{tori} {changes}");
}

/// A torus over frequency and force: on all its curve two multipliers lie on the circle.
fn check_curve(torus: &Special) {
    let plane = [Parameter::Frequency, Parameter::ForcingScale];
    let options = ContinuationOptions {
        max_points: 10,
        ..ContinuationOptions::default()
    };
    let between = [(0.3, 3.6), (0.5, 2.0)];
    let curve = bifurcation_curve(CurveOf::Special(torus), plane, between, &options);
    let curve = curve.expect("a curve");
    assert!(curve.x.len() > 3, "{:?}", curve.ends);
    for orbit in &curve.orbits {
        let orders = &orbit.stability().expect("multipliers").orders;
        let own = orders[0].multipliers.iter().filter(|mu| mu.im > 0.0);
        let off = own.fold(f64::INFINITY, |least: f64, mu| {
            least.min((mu.norm() - 1.0).abs())
        });
        assert!(off < 1e-8, "{off:e}");
    }
}

/// A pendulum that a shaken base presses against a wall, which takes all speed: slower than `w^2 = g tan q/A` the base does not pull it off. There
/// the release comes to an instant at which the force is zero without a change of sign, the branch turns, and every multiplier stays zero.
#[test]
fn where_a_force_only_touches_zero_a_branch_turns_and_nothing_doubles() {
    const SHAKE: f64 = 0.122_042_484_297_036_89;
    const LENGTH: f64 = 0.880_979_668_168_189_5;
    const AT: f64 = 0.059_779_021_141_880_204;
    let chain = PendulumChain::new(
        dvector![1.3],
        dvector![LENGTH],
        &dvector![0.007_241_868_880_808_756],
        1.0,
    );
    let base = BaseMotion::new(SHAKE, 0.934_321_216_130_183_8, 0.0).expect("valid");
    let wall = Wall::new(0, AT, 0.0, WallSide::Right).expect("valid");
    let scene = Scene::new(chain.expect("valid"), base, [wall]).expect("valid");
    let (q, v) = (dvector![0.0], dvector![0.0]);
    let until = 60.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let branch = followed(&orbit, Parameter::Frequency, (0.7, 1.0), &keep());
    let turn = ((AT / LENGTH).asin().tan() / SHAKE).sqrt();
    let near = |own: &&Special| (own.parameter - turn).abs() < 1e-3;
    let found: Vec<&Special> = branch.special.iter().filter(near).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].kind, SpecialKind::Fold);
    assert!(
        (found[0].parameter - turn).abs() < 1e-10,
        "{}",
        found[0].parameter
    );
}

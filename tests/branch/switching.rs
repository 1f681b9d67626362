//! Branches that meet a branch at its special points, against the laws of what is born there.

use crate::random::Random;
use crate::scenes::{Oscillator, USUAL, beside_a_doubling, followed, pressed, settled};
use vibroimpact::nalgebra::{Complex, DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    Branch, Candidate, ContinuationOptions, Harmonic, Heading, ImpactSide, LinearSystem, Motion,
    OrbitOptions, Parameter, Pattern, PeriodicOrbit, Scene, SegmentKind, SimulateOptions, Special,
    SpecialKind, Stop, Virtual, branches, continuation_of, find_orbit, periodic_orbits, simulate,
};

fn one_of(branch: &Branch, kind: SpecialKind) -> &Special {
    let mut own = branch.special.iter().filter(|own| own.kind == kind);
    own.next().expect("a special point")
}

fn stable(own: &Candidate) -> bool {
    own.orbit.stability().expect("multipliers").is_stable == Some(true)
}

#[test]
fn doubled_orbits_exchange_stability_with_their_branch() {
    let mut seen = 0;
    for case in 0..200 {
        let random = &mut Random::of_case(71, case);
        let Some((start, orbit)) = beside_a_doubling(random) else {
            continue;
        };
        let (parameter, range) = (Parameter::ForcingScale, (0.8, 1.3));
        let options = ContinuationOptions {
            beyond: Virtual::Keep,
            ..Default::default()
        };
        let branch = followed(&orbit, parameter, range, &options);
        let doublings = branch.special.iter();
        let doublings = doublings.filter(|own| own.kind == SpecialKind::PeriodDoubling);
        for doubling in doublings {
            let born = branches(doubling, parameter, range).expect("branches");
            let [born] = born.as_slice() else {
                panic!("{start:?}: {}", born.len());
            };
            assert_eq!(born.orbit.n_periods(), 2);
            let impacts = born.orbit.impacts();
            let speeds = [impacts[0].approach, impacts[1].approach];
            let at = doubling.orbit.impacts()[0].approach;
            assert!(speeds[0] != speeds[1]);
            assert!((0.5 * (speeds[0] + speeds[1]) / at - 1.0).abs() < 0.05);
            // Stable where the branch is not, with one multiplier more outside where it is stable.
            let other = find_orbit(&branch_scene(&start, born.parameter), &orbit, None);
            let other = other.expect("the branch beside it");
            let is_stable = other.stability().expect("multipliers").is_stable;
            assert_eq!(Some(stable(born)), is_stable.map(|is| !is), "{start:?}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}

fn branch_scene(own: &Oscillator, scale: f64) -> Scene {
    own.at(Parameter::ForcingScale, scale).scene()
}

/// A random system of n coordinates that is shaken at the first before a stop of the last.
struct Touched {
    scene: Scene,
    /// Rates of change of the state, and the kick of an impact of speed one.
    rates: DMatrix<f64>,
    kick: DVector<f64>,
    amplitude: f64,
}

fn touched(n: usize, random: &mut Random) -> Touched {
    let half = DMatrix::from_fn(n, n, |_, _| random.between(-0.5, 0.5));
    let stiffness = DMatrix::identity(n, n) + &half * half.transpose();
    let damping = &stiffness * random.between(0.02, 0.2);
    let frequency = random.between(0.6, 2.5);
    let restitution = random.between(0.2, 0.95);
    let mut force = DVector::zeros(n);
    force[0] = Complex::from(1.0);
    let mass = DVector::from_element(n, 1.0);
    let w2 = DMatrix::identity(n, n) * (frequency * frequency);
    let dynamic =
        (&stiffness - w2).map(Complex::from) + (&damping * frequency).map(|c| Complex::new(0.0, c));
    let answer = dynamic.lu().solve(&force).expect("regular");
    let amplitude = answer[n - 1].norm();
    let system = LinearSystem::new(mass, damping.clone(), stiffness.clone()).expect("valid");
    let force = Harmonic::new(force, frequency, 0.0).expect("valid");
    let stop = Stop::new(n - 1, 1.02 * amplitude, restitution).expect("valid");
    let mut rates = DMatrix::zeros(2 * n, 2 * n);
    rates.view_mut((0, n), (n, n)).fill_with_identity();
    rates.view_mut((n, 0), (n, n)).copy_from(&-stiffness);
    rates.view_mut((n, n), (n, n)).copy_from(&-damping);
    let mut kick = DVector::zeros(2 * n);
    kick[2 * n - 1] = 1.0 + restitution;
    Touched {
        scene: Scene::new(system, force, [stop]).expect("valid"),
        rates,
        kick,
        amplitude,
    }
}

#[test]
fn what_is_born_at_a_graze_lies_where_kappa_says() {
    let (mut seen, mut kept) = (0, [0, 0]);
    for case in 0..60 {
        let random = &mut Random::of_case(72, case);
        let n = 1 + random.below(3);
        let own = touched(n, random);
        let found = periodic_orbits(&own.scene, &Pattern::none(), &OrbitOptions::default());
        let orbit = &found.expect("a search")[0];
        let (parameter, range) = (Parameter::ForcingScale, (0.5, 1.5));
        let options = ContinuationOptions {
            heading: Heading::Up,
            ..Default::default()
        };
        let branch = followed(orbit, parameter, range, &options);
        let graze = one_of(&branch, SpecialKind::Graze);
        assert!((graze.parameter - 1.02).abs() < 1e-9);
        let born = branches(graze, parameter, range).expect("branches");
        let whole = (&own.rates * orbit.period()).exp();
        let identity = DMatrix::identity(2 * n, 2 * n);
        for m in 1..=6u32 {
            let rounds = whole.pow(m);
            let inverse = (&identity - &rounds).try_inverse().expect("regular");
            let gap = |deviation: DVector<f64>| -deviation[n - 1];
            let kappa = gap(&inverse * &rounds * &own.kick);
            let returns = (1..m).map(|j| kappa - gap(whole.pow(j) * &inverse * &own.kick));
            let least = returns.fold(f64::INFINITY, f64::min);
            if kappa.abs() < 0.05 || least.abs() < 0.05 {
                continue;
            }
            let own_rounds = |born: &&Candidate| born.orbit.n_periods() == m as usize;
            let born = born.iter().find(own_rounds).expect("an orbit");
            let speed = born.orbit.impacts()[0].approach;
            let predicted = -kappa * speed / own.amplitude;
            let gone = born.parameter - graze.parameter;
            assert!(
                (gone / predicted - 1.0).abs() < 0.1,
                "{case} {m}: {gone} {predicted}"
            );
            assert_eq!(born.is_above, kappa < 0.0);
            let is_admissible = born.orbit.is_admissible() == Some(true);
            assert_eq!(is_admissible, least > 0.0, "{case} {m}: {least}");
            assert!(!stable(born));
            seen += 1;
            kept[usize::from(is_admissible)] += 1;
        }
    }
    assert!(
        seen > 100 && kept[0] > 20 && kept[1] > 20,
        "{seen} {kept:?}"
    );
}

#[test]
fn an_impact_without_speed_leaves_the_motion_that_hits_nothing() {
    let orbit = &USUAL.orbits(1)[0];
    let (parameter, range) = (Parameter::ForcingScale, (0.1, 2.0));
    let branch = followed(orbit, parameter, range, &ContinuationOptions::default());
    let lost = one_of(&branch, SpecialKind::LostImpact);
    let born = branches(lost, parameter, range).expect("branches");
    let rest = &born[0];
    assert!(rest.orbit.impacts().is_empty() && !rest.is_above && stable(rest));
    // The others are born there with it: two periods below, three above (kappa 1.45, -0.84).
    let sides: Vec<(usize, bool)> = (born[1..].iter())
        .map(|own| (own.orbit.n_periods(), own.is_above))
        .collect();
    assert!(
        sides.contains(&(2, false)) && sides.contains(&(3, true)),
        "{sides:?}"
    );
    assert!(!sides.iter().any(|own| own.0 == 1));
    let is_admissible = |own: &&Candidate| own.orbit.is_admissible() == Some(true);
    let admissible: Vec<usize> = (born.iter().filter(is_admissible))
        .map(|own| own.orbit.n_periods())
        .collect();
    assert_eq!(admissible, [1, 2]);
}

#[test]
fn one_impact_of_two_rounds_leaves_one_round() {
    // The branch of one impact in two periods, down to its graze, which is that of the motion that hits nothing, gone round once.
    let own = Oscillator {
        force: 4.6,
        ..USUAL
    };
    let orbits = own.orbits(2);
    let orbit = orbits.iter().find(|own| own.is_admissible() == Some(true));
    let (parameter, range) = (Parameter::ForcingScale, (0.5, 2.0));
    let options = ContinuationOptions::default();
    let branch = followed(orbit.expect("one"), parameter, range, &options);
    let lost = one_of(&branch, SpecialKind::LostImpact);
    let born = branches(lost, parameter, range).expect("branches");
    let rest = born.iter().find(|own| own.orbit.impacts().is_empty());
    let rest = rest.expect("it");
    assert_eq!(rest.orbit.n_periods(), 1);
    assert!(
        born.iter()
            .any(|own| own.orbit.n_periods() == 1 && own.orbit.impacts().len() == 1)
    );
}

#[test]
fn two_oscillators_side_by_side_change_the_order_of_their_impacts() {
    let system = LinearSystem::new(
        dvector![1.0, 1.0],
        dmatrix![0.1, 0.0; 0.0, 0.1],
        dmatrix![1.0, 0.0; 0.0, 1.3],
    );
    let force = Harmonic::new(dvector![8.0.into(), 8.0.into()], 2.4, 0.0).expect("valid");
    let stops = [Stop::new(0, 1.0, 0.8), Stop::new(1, 0.7, 0.7)].map(|stop| stop.expect("valid"));
    let scene = Scene::new(system.expect("valid"), force, stops).expect("valid");
    let patterns = [[[0], [1]], [[1], [0]]]
        .map(|own| Pattern::new(own.map(Vec::from).to_vec()).expect("valid"));
    let found = patterns.iter().flat_map(|pattern| {
        let found = periodic_orbits(&scene, pattern, &OrbitOptions::default());
        found.expect("a search").into_iter().collect::<Vec<_>>()
    });
    let orbit = found
        .into_iter()
        .find(|own| own.is_admissible() == Some(true));
    let orbit = orbit.expect("an orbit");
    let (parameter, range) = (Parameter::CLEARANCE.of(1), (-1.5, 2.0));
    let branch = followed(&orbit, parameter, range, &ContinuationOptions::default());
    let corner = one_of(&branch, SpecialKind::Corner);
    let born = branches(corner, parameter, range).expect("branches");
    let [beyond] = born.as_slice() else {
        panic!("{}", born.len());
    };
    assert_eq!(beyond.orbit.is_admissible(), Some(true));
    // The impact of the first oscillator knows nothing of the other one.
    let speed = |orbit: &vibroimpact::PeriodicOrbit| {
        let mut own = orbit.impacts().iter().filter(|impact| impact.stop == 0);
        own.next().expect("one").approach
    };
    assert!((speed(&beyond.orbit) / speed(&orbit) - 1.0).abs() < 1e-9);
    let is_before = |orbit: &vibroimpact::PeriodicOrbit| orbit.impacts()[0].stop;
    let late = |orbit: &vibroimpact::PeriodicOrbit| {
        let impacts = orbit.impacts();
        let late = (impacts[1].phase - impacts[0].phase).rem_euclid(std::f64::consts::TAU);
        if is_before(orbit) == 0 {
            late
        } else {
            std::f64::consts::TAU - late
        }
    };
    let [one, other] = [&corner.orbit, &beyond.orbit].map(late);
    let around = |x: f64| {
        (x + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
    };
    assert!(
        around(one).abs() < 1e-6 && around(other).abs() < 0.1 && around(other) * around(one) < 0.0
    );
}

#[test]
fn behind_a_rise_the_stop_is_left_and_landed_on_again() {
    for restitution in [0.0, 0.3] {
        let make = |second: f64| pressed(second, restitution);
        let scene = make(0.6).expect("valid");
        let first = settled(&scene, 0.0, 20).expect("an orbit");
        let options = ContinuationOptions::default();
        let branch = continuation_of(&first, &make, 0.6, (0.5, 1.2), &options);
        let branch = branch.expect("a branch");
        let rise = branch.special.last().expect("an end");
        assert_eq!(
            rise.kind,
            SpecialKind::Rise,
            "{restitution} {:?}",
            branch.ends
        );
        assert!((rise.parameter - 1.0).abs() < 1e-9, "{}", rise.parameter);
        let born = branches(rise, &make, (0.5, 1.2)).expect("a search");
        let [other] = born.as_slice() else {
            panic!("{restitution}: {}", born.len());
        };
        assert!(other.is_above && other.orbit.is_admissible() == Some(true));
        // One contact more than the motion before has.
        let sticks = |orbit: &PeriodicOrbit| {
            orbit
                .segments()
                .expect("kept")
                .iter()
                .filter(|own| own.kind == SegmentKind::Stick)
                .count()
        };
        assert_eq!(sticks(&other.orbit), sticks(&rise.orbit) + 1);
        let run = simulate(
            other.orbit.scene(),
            &other.orbit.q0(),
            &other.orbit.v0(),
            (0.0, other.orbit.period()),
            &SimulateOptions::default(),
        );
        let run = run.expect("a run");
        let (_, v) = run.last();
        let off = (v - other
            .orbit
            .state(other.orbit.period(), ImpactSide::After)
            .expect("a time")
            .1)
            .amax();
        assert!(off < 1e-9, "{off:e}");
        // The branch goes on, and comes back to the rise from behind.
        let next = continuation_of(&other.orbit, &make, other.parameter, (0.5, 1.2), &options);
        let next = next.expect("a branch");
        assert!(next.orbits.len() > 3 && next.parameter.last() > Some(&other.parameter));
    }
}

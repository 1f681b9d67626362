//! What the rules of contact say of the orbits of a branch, against samples of their gaps.

use crate::scenes::followed;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    BaseMotion, Constraint, ContinuationOptions, Guess, Harmonic, Heading, ImpactSide,
    LinearSystem, Motion, Parameter, PendulumChain, PeriodicOrbit, Scene, SegmentKind,
    SimulateOptions, SpecialKind, Stop, Virtual, Wall, WallSide, find_orbit, simulate,
};

#[test]
fn a_stop_that_is_passed_behind_a_release_is_seen() {
    // Two masses before a stop that takes all speed: along the branch the flight behind the release comes back to the stop, and passes it.
    let stiffness = dmatrix![
        3.920_111_074_504_845_3, -1.851_416_477_874_136_9;
        -1.851_416_477_874_136_9, 3.866_230_239_550_701
    ];
    let damping = dmatrix![0.151_939_312_383_485_46, 0.0; 0.0, 0.151_939_312_383_485_46];
    let system = LinearSystem::new(dvector![1.0, 1.0], damping, stiffness).expect("valid");
    let force = dvector![2.475_749_823_533_228_7.into(), 2.851_617_267_853_695.into()];
    let force = Harmonic::new(force, 0.763_525_880_667_199_8, 0.0).expect("valid");
    let clearance = 0.630_989_717_028_171_5;
    let stop = Stop::new(0, clearance, 0.0).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let (q, v) = (dvector![-0.6, -0.6], dvector![0.0, 0.0]);
    let until = 60.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let branch = followed(&orbit, Parameter::ForcingScale, (0.5, 1.6), &keep);
    let mut passed = 0;
    for (orbit, value) in branch.orbits.iter().zip(&branch.parameter) {
        let each = (0..4000).map(|k| orbit.period() * f64::from(k) / 4000.0);
        let gaps =
            each.map(|t| clearance - orbit.state(t, ImpactSide::After).expect("a time").0[0]);
        let least = gaps.fold(f64::INFINITY, f64::min);
        if least < -1e-9 {
            assert_eq!(orbit.is_admissible(), Some(false), "{value}: {least}");
            passed += 1;
        }
    }
    assert!(passed > 5, "{passed}");
}

/// The least gap of a stop at so many times of a period.
fn least_gap(orbit: &PeriodicOrbit, stop: usize, count: u32) -> f64 {
    let states = (0..count).map(|k| {
        orbit
            .state(
                orbit.period() * f64::from(k) / f64::from(count),
                ImpactSide::After,
            )
            .expect("a time")
    });
    let gaps = states.map(|(q, _)| orbit.scene().gaps(&q).expect("gaps")[stop]);
    gaps.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_long_flight_that_begins_and_ends_without_speed_is_no_low_bounce() {
    // Two links before an elastic stop, hit four times: at the end of the branch all impacts lose their speed together, three flights shrink to
    // nothing, and the fourth passes the stop.
    let (c1, c2) = (0.985_833_965_523_052_8, 0.625_803_418_639_427_5);
    let system = PendulumChain::with_damping_matrix(
        dvector![1.319_067_241_304_87, 1.105_675_405_855_024],
        dvector![1.047_809_871_156_683_7, 1.120_647_108_152_479_1],
        dmatrix![c1, -c2; -c2, c2],
        1.0,
    );
    let base = BaseMotion::new(
        0.061_295_000_568_112_525,
        1.631_291_264_557_182_9,
        2.443_908_170_507_003,
    );
    let stop = Stop::new(0, -0.046_061_344_972_267_26, 1.0).expect("valid");
    let scene = Scene::new(system.expect("valid"), base.expect("valid"), [stop]).expect("valid");
    let q = dvector![-0.046_061_344_972_267_26, 0.064_907_452_067_298_07];
    let v = dvector![-0.020_478_426_121_896_445, 0.071_866_038_404_826_89];
    let guess = Guess::State {
        q: &q,
        v: &v,
        period: None,
    };
    let mut orbit = find_orbit(&scene, guess, None).expect("an orbit");
    let mut passed = 0;
    for largest in [0.05, 1e-9, 1e-11] {
        let options = ContinuationOptions {
            beyond: Virtual::Keep,
            max_points: 30,
            steps: [1e-14, 1e-2 * largest, largest],
            ..Default::default()
        };
        let branch = followed(&orbit, Parameter::ForcingScale, (0.4, 2.0), &options);
        for own in branch.orbits.iter().take(10) {
            if least_gap(own, 0, 1000) < -1e-3 {
                assert_eq!(own.is_admissible(), Some(false));
                passed += 1;
            }
        }
        orbit = branch.orbits[0].clone();
    }
    assert!(passed > 5, "{passed}");
}

#[test]
fn a_short_stay_does_not_pull() {
    // A pendulum that rests a while on a wall, less and less towards the landing border: the force comes to zero with the stay.
    let stay = |orbit: &PeriodicOrbit| -> f64 {
        let segments = orbit.segments().expect("kept");
        let sticks = segments.iter().filter(|own| own.kind == SegmentKind::Stick);
        sticks.map(|own| own.end - own.start).sum()
    };
    let chain = PendulumChain::new(
        dvector![1.430_958_539_699_678_2],
        dvector![1.187_167_600_519_636_8],
        &dvector![0.175_716_385_615_511_4],
        1.0,
    );
    let base = BaseMotion::new(
        0.071_085_248_038_555_26,
        1.371_064_458_800_714_8,
        0.420_622_673_837_268_87,
    );
    let wall = Wall::new(0, -0.088_848_266_764_784_37, 0.0, WallSide::Left).expect("valid");
    let stop = Stop::new(0, 0.05, 0.5).expect("valid");
    let stops: [Constraint; 2] = [stop.into(), wall.into()];
    let scene = Scene::new(chain.expect("valid"), base.expect("valid"), stops).expect("valid");
    let (q, v) = (dvector![0.05], dvector![-0.077_403_115_277_947_06]);
    let guess = Guess::State {
        q: &q,
        v: &v,
        period: None,
    };
    let orbit = find_orbit(&scene, guess, None).expect("an orbit");
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let range = (1.028_298_344_100_536, 1.919_490_242_321_000_5);
    let branch = followed(&orbit, Parameter::Frequency, range, &keep);
    let near = branch
        .orbits
        .iter()
        .find(|own| stay(own) > 1e-3)
        .expect("a stay");
    let mut shortest = f64::INFINITY;
    for largest in [1e-4, 1e-6, 1e-7] {
        let options = ContinuationOptions {
            max_points: 200,
            heading: Heading::Down,
            steps: [1e-13, largest, largest],
            ..keep.clone()
        };
        let branch = followed(near, Parameter::Frequency, range, &options);
        for own in &branch.orbits {
            assert_eq!(
                own.is_admissible(),
                Some(true),
                "{:e} {:?}",
                stay(own),
                own.violation()
            );
            shortest = shortest.min(stay(own));
        }
    }
    assert!(shortest < 1e-4, "{shortest:e}");
}

#[test]
fn behind_an_impact_that_takes_all_speed_the_acceleration_decides() {
    // A pendulum between a wall that takes all speed, which it leaves at once, and another. The gap opens behind the first with an acceleration that
    // comes to zero at the landing border; beyond it the wall is passed.
    const LENGTH: f64 = 0.784_617_756_721_350_3;
    const SHAKE: f64 = 0.079_518_397_673_698;
    const FREQUENCY: f64 = 8.542_042_145_872_712;
    let opening = |orbit: &PeriodicOrbit, scale: f64| {
        let landing = orbit
            .impacts()
            .iter()
            .find(|own| own.stop == 0)
            .expect("it")
            .time;
        let q = orbit.state(landing, ImpactSide::After).expect("a time").0[0];
        let angle = FREQUENCY * landing + orbit.phase();
        let shaken = SHAKE * scale * FREQUENCY.powi(2) * angle.cos();
        shaken * q.cos() - 9.81 * q.sin()
    };
    let chain = PendulumChain::new(
        dvector![1.945_844_589_776_644_5],
        dvector![LENGTH],
        &dvector![0.383_216_945_784_654],
        9.81,
    );
    let base = BaseMotion::new(SHAKE, FREQUENCY, 0.0).expect("valid");
    let walls = [
        Wall::new(0, -0.132_108_510_938_766, 0.0, WallSide::Left),
        Wall::new(
            0,
            0.261_938_857_373_062_8,
            0.526_970_287_710_989_9,
            WallSide::Right,
        ),
    ];
    let walls = walls.map(|wall| wall.expect("valid"));
    let scene = Scene::new(chain.expect("valid"), base, walls).expect("valid");
    let span = (0.0, 60.0 * scene.period().expect("forced"));
    let run = simulate(
        &scene,
        &dvector![0.0],
        &dvector![0.1],
        span,
        &SimulateOptions::default(),
    );
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    for beyond in [Virtual::Keep, Virtual::Stop] {
        let options = ContinuationOptions {
            beyond,
            ..Default::default()
        };
        let branch = followed(&orbit, Parameter::ForcingScale, (0.4, 2.0), &options);
        let mut near = branch
            .special
            .iter()
            .filter(|own| (1.01..1.03).contains(&own.parameter));
        let border = near.next().expect("a border");
        assert_eq!(
            (border.kind, near.count()),
            (SpecialKind::LandingBorder, 0),
            "{beyond:?}"
        );
        let still = opening(&border.orbit, border.parameter);
        assert!(still.abs() < 1e-6, "{beyond:?}: {still:e}");
    }
    // On both sides, close to it.
    let fine = ContinuationOptions {
        beyond: Virtual::Keep,
        steps: [1e-8, 1e-2, 1e-2],
        max_points: 60,
        ..Default::default()
    };
    let branch = followed(&orbit, Parameter::ForcingScale, (0.99, 1.05), &fine);
    let mut seen = [0, 0];
    for (own, scale) in branch.orbits.iter().zip(&branch.parameter) {
        let speedup = opening(own, *scale);
        // The wall is passed by its third power, which has to be seen.
        if !(-1e-2..=1e-3).contains(&speedup) {
            assert_eq!(
                own.is_admissible(),
                Some(speedup > 0.0),
                "{scale}: {speedup:e}"
            );
            seen[usize::from(speedup > 0.0)] += 1;
        }
    }
    assert!(seen[0] > 3 && seen[1] > 3, "{seen:?}");
}

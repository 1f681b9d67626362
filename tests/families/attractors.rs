//! Attractors of scenes of which they are known.

use crate::scenes::{between_stops, double_well, grid, oscillator};
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    Attraction, AttractorKind, AttractorOptions, Attractors, Harmonic, ImpactSide, LinearSystem,
    LyapunovOptions, Motion, OrbitOptions, Pattern, Scene, Side, StateBox, Stop, find_attractors,
    lyapunov_exponents, periodic_orbits,
};

fn attractors(
    scene: &Scene,
    (around, seeds): &(StateBox, DMatrix<f64>),
    options: &AttractorOptions,
) -> Attractors {
    find_attractors(scene, around, seeds, options).expect("attractors")
}

#[test]
fn two_orbits_attract_all() {
    let scene = oscillator(9.0);
    let around = grid([-3.0, 2.0], [-5.0, 5.0], 5);
    let found = attractors(&scene, &around, &AttractorOptions::default());
    let counts = (found.n_inside, found.n_lost, found.n_undecided);
    assert_eq!((found.all.len(), counts), (2, (5, 0, 0)));
    let whole: f64 = found.all.iter().map(|one| one.fraction).sum();
    assert!((whole - 1.0).abs() < 1e-15);
    // That of one impact in each period, and one of three in three.
    for one in &found.all {
        let m = one.n_periods;
        assert!(one.kind == AttractorKind::Periodic && (m == 1 || m == 3));
        assert_eq!(one.pattern.instants(), vec![[0]; m]);
        assert_eq!(one.points.shape(), (m, 2));
        assert!(one.exponents.len() == 2 && one.exponents[0] < 0.0 && one.reason.is_empty());
        let orbit = one.orbit.as_ref().expect("an orbit");
        let options = OrbitOptions::default();
        if m == 1 {
            let known = periodic_orbits(&scene, &Pattern::single(0), &options).expect("solved");
            assert!((orbit.phase() - known[0].phase()).abs() < 1e-10);
        } else {
            assert_eq!(orbit.is_admissible(), Some(true));
        }
    }
    for (k, seed) in found.of_seed.iter().enumerate() {
        assert_eq!(seed.is_none(), around.1[(k, 0)] > 1.0);
    }
}

#[test]
fn chaos_is_a_set() {
    let around = grid([-3.0, 1.0], [-5.0, 5.0], 3);
    let options = AttractorOptions {
        max_periods: 500,
        ..AttractorOptions::default()
    };
    let found = attractors(&oscillator(5.0), &around, &options);
    assert_eq!(found.all.len(), 1);
    let only = &found.all[0];
    assert_eq!((only.kind, only.n_periods), (AttractorKind::Chaotic, 0));
    assert_eq!(only.points.shape(), (1000, 2));
    assert!(only.exponents[0] > 0.08 && only.orbit.is_none());
    assert_eq!(only.reason, "it has no period up to 32");
}

#[test]
fn what_sticks_is_periodic_however_long() {
    let around = grid([-1.0, 1.0], [-1.0, 1.0], 2);
    let found = attractors(&oscillator(6.0), &around, &AttractorOptions::default());
    assert!(
        found
            .all
            .iter()
            .all(|one| one.kind == AttractorKind::Periodic),
        "{found:?}"
    );
    assert!(
        found.all[0]
            .exponents
            .iter()
            .all(|la| *la == f64::NEG_INFINITY)
    );
}

#[test]
fn each_well_has_its_orbit() {
    let scene = double_well();
    let around = grid([-2.2, 2.2], [-2.2, 2.2], 5);
    let found = attractors(&scene, &around, &AttractorOptions::default());
    assert_eq!(found.all.len(), 2, "{found:?}");
    let whole: f64 = found.all.iter().map(|one| one.fraction).sum();
    assert!((whole - 1.0).abs() < 1e-15);
    assert!(
        found
            .all
            .iter()
            .all(|one| one.n_periods == 1 && one.orbit.is_some())
    );
    // Half a period later and mirrored, one is the other.
    let [a, b] = [0, 1].map(|k| found.all[k].orbit.as_ref().expect("an orbit"));
    let (q, v) = a
        .state(0.5 * a.period(), ImpactSide::After)
        .expect("a time");
    let late = (a.phase() - b.phase()).rem_euclid(TAU);
    let (p, u) = b.state(late, ImpactSide::After).expect("a time");
    assert!((q + p).amax() < 1e-8 && (v + u).amax() < 1e-8);
}

/// `x'' + c x' + x = cos w t` before a stop at -d, hardly damped: motions come to their orbits slowly.
fn hardly_damped(damping: f64, clearance: f64, frequency: f64) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![damping], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], frequency, 0.0).expect("valid");
    let stop = Stop::new(0, clearance, 0.8)
        .expect("valid")
        .on_side(Side::Lower);
    Scene::new(system, force, [stop]).expect("valid")
}

#[test]
fn what_comes_near_slowly_is_told_by_its_shortest_round() {
    let options = AttractorOptions {
        transient: 100,
        max_periods: 800,
        ..AttractorOptions::default()
    };
    for (damping, clearance, frequency) in [
        (0.05, 0.63, 6.2),
        (0.05, 0.3, 5.2),
        (0.01, 0.63, 5.2),
        (0.01, 0.3, 2.6),
    ] {
        let scene = hardly_damped(damping, clearance, frequency);
        let found = attractors(&scene, &grid([-clearance, 2.5], [-3.0, 3.0], 5), &options);
        assert!(found.n_lost == 0 && found.n_inside == 0);
        for one in &found.all {
            let orbit = one.orbit.as_ref().expect("an orbit");
            assert_eq!(
                (one.kind, one.n_periods),
                (AttractorKind::Periodic, orbit.n_periods())
            );
            let m = one.points.nrows();
            for (i, j) in (0..m).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let off = (one.points.row(i) - one.points.row(j)).amax();
                assert!(
                    off > 1e-4,
                    "{m} periods, points {i} and {j} are {off} apart"
                );
            }
            let impacts = orbit.impacts().len();
            assert_eq!(one.pattern.instants().len(), impacts);
            // A linear motion without an impact has the period of its forcing.
            assert!(impacts > 0 || m == 1);
        }
    }
}

#[test]
fn what_swings_undamped_without_an_impact_is_attracted_by_nothing() {
    let scene = hardly_damped(0.0, 0.63, 5.2);
    let options = AttractorOptions {
        max_periods: 500,
        ..AttractorOptions::default()
    };
    let found = attractors(&scene, &grid([-0.63, 1.5], [-2.0, 2.0], 6), &options);
    // Small motions about that of the force hit nothing, each an orbit of 26 periods.
    assert!(found.n_undecided > 0);
    assert_eq!(found.all.len(), 1);
    let one = &found.all[0];
    assert_eq!((one.n_periods, one.pattern.instants().len()), (4, 1));
    assert!(one.exponents[0] < -1e-3);
}

#[test]
fn a_mass_on_a_spring_has_no_torus() {
    // Here an orbit of five periods is about to lose its stability: deviations hardly die out.
    let scene = hardly_damped(0.01, 0.63, 6.2);
    let (q, v) = (dvector![0.426_016], dvector![0.777_086]);
    let span = (0.0, 1000.0 * scene.period().expect("forced"));
    let found =
        lyapunov_exponents(&scene, &q, &v, span, &LyapunovOptions::default()).expect("exponents");
    assert!(found.exponents[0].abs() < 3.0 * found.errors[0]);
    assert_eq!(found.verdict, Attraction::Undecided);
}

#[test]
fn mirrored_starts_lead_to_mirrored_attractors() {
    let scene = between_stops();
    let around = grid([-0.5, 0.5], [-2.0, 2.0], 4);
    let found = attractors(&scene, &around, &AttractorOptions::default());
    let mirrored = AttractorOptions {
        phase: std::f64::consts::PI,
        ..AttractorOptions::default()
    };
    let seeds: DMatrix<f64> = -&around.1;
    let mirror = attractors(&scene, &(around.0, seeds), &mirrored);
    assert_eq!(found.all.len(), mirror.all.len());
    assert_eq!(found.of_seed, mirror.of_seed);
    for (a, b) in found.all.iter().zip(&mirror.all) {
        assert_eq!(a.n_periods, b.n_periods);
        assert!((&a.points + &b.points).amax() < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn threads_change_no_bit_and_wrong_calls_are_refused() {
    let scene = oscillator(5.0);
    let around = grid([-3.0, 2.0], [-5.0, 5.0], 3);
    let of = |threads| {
        let options = AttractorOptions {
            max_periods: 300,
            sweep: vibroimpact::SweepOptions {
                threads: Some(threads),
            },
            ..AttractorOptions::default()
        };
        attractors(&scene, &around, &options)
    };
    let (one, many) = (of(1), of(3));
    assert_eq!(one.of_seed, many.of_seed);
    assert_eq!(one.all[0].points, many.all[0].points);
    let refused = |scene: &Scene, seeds: &DMatrix<f64>, options: &AttractorOptions| {
        let found = find_attractors(scene, &around.0, seeds, options);
        found.expect_err("refused").to_string()
    };
    let usual = AttractorOptions::default();
    assert!(refused(&scene, &dmatrix![0.0], &usual).contains("seeds"));
    assert!(refused(&scene, &dmatrix![0.0, f64::NAN], &usual).contains("seeds[0]"));
    let none = AttractorOptions {
        longest_period: 0,
        ..usual.clone()
    };
    assert!(refused(&scene, &around.1, &none).contains("longest_period"));
    let free = scene.replace(vibroimpact::Change::Forcing(vibroimpact::Forcing::Unforced));
    if let Ok(free) = free {
        assert!(refused(&free, &around.1, &usual).contains("forcing period"));
    }
    for (low, high) in [
        ([0.0, 1.0], [1.0, 0.0]),
        ([0.0, 0.0], [1.0, f64::NAN]),
        ([0.0, 0.0], [0.0, 1.0]),
    ] {
        let vector = |x: [f64; 2]| DVector::from_row_slice(&x);
        let error = StateBox::new(vector(low), vector(high)).expect_err("refused");
        assert!(error.to_string().contains("box"), "{error}");
    }
    assert_eq!(Attraction::Torus.name(), AttractorKind::Torus.name());
}

#[test]
fn weak_chaos_is_one_set_whichever_part_a_motion_has_seen() {
    // Its exponent is 0.0045: some motions alone are not long enough to tell it from zero.
    let around = grid([-3.0, 1.0], [-5.0, 5.0], 5);
    let found = attractors(&oscillator(8.5), &around, &AttractorOptions::default());
    let chaotic = |one: &&vibroimpact::Attractor| one.kind == AttractorKind::Chaotic;
    assert_eq!(found.all.iter().filter(chaotic).count(), 1, "{found:?}");
    assert_eq!(found.n_undecided, 0);
}

#[test]
fn a_list_does_not_depend_on_the_size_of_its_box() {
    let scene = double_well();
    let (_, seeds) = grid([-2.2, 2.2], [-2.2, 2.2], 3);
    let of = |side: f64| {
        let around = StateBox::new(dvector![-side, -side], dvector![side, side]).expect("a box");
        attractors(
            &scene,
            &(around, seeds.clone()),
            &AttractorOptions::default(),
        )
    };
    let (near, far) = (of(2.2), of(1e8));
    assert_eq!((near.all.len(), near.of_seed), (2, far.of_seed));
}

#[test]
fn longer_periods_than_are_gone_through_cost_nothing() {
    let around = grid([-3.0, 1.0], [-5.0, 5.0], 2);
    let of = |longest_period| {
        let options = AttractorOptions {
            longest_period,
            max_periods: 300,
            ..AttractorOptions::default()
        };
        attractors(&oscillator(5.0), &around, &options)
    };
    let (usual, endless) = (of(32), of(usize::MAX));
    assert_eq!(usual.of_seed, endless.of_seed);
    assert_eq!(endless.all[0].kind, AttractorKind::Chaotic);
}

/// A mass that nothing holds, `x'' + x' = 0.3 + cos t`: in each period it comes on by 0.6 pi.
fn drifting() -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![1.0], dmatrix![0.0]).expect("valid");
    let system = system.with_load(dvector![0.3]).expect("valid");
    let none: [Stop; 0] = [];
    let force = Harmonic::new(dvector![1.0.into()], 1.0, 0.0).expect("valid");
    Scene::new(system, force, none).expect("valid")
}

#[test]
fn a_drift_is_called_one() {
    let scene = drifting();
    let options = LyapunovOptions {
        skip: 100.0,
        ..LyapunovOptions::default()
    };
    let zero = dvector![0.0];
    let found = lyapunov_exponents(&scene, &zero, &zero, (0.0, 2000.0), &options);
    let found = found.expect("exponents");
    assert_eq!(found.verdict, Attraction::Drift);
    assert!(found.message.contains("(1.88496)"), "{}", found.message);
    let run = vibroimpact::SimulateOptions::default();
    let run = vibroimpact::simulate(&scene, &zero, &zero, (0.0, 200.0), &run).expect("a run");
    let refused = vibroimpact::find_orbit(&scene, &run, None).expect_err("no orbit");
    assert!(
        refused.to_string().contains("advances by (1.88496)"),
        "{refused}"
    );
    // From a box that it soon leaves, too.
    for side in [1.0, 1e-3] {
        let around = grid([-side, side], [-side, side], 2);
        let found = attractors(&scene, &around, &AttractorOptions::default());
        assert_eq!(
            (found.n_drifting, found.n_lost, found.n_undecided),
            (4, 0, 0)
        );
    }
}

#[test]
fn slow_decay_is_no_torus() {
    // One mass creeps back at the rate 1e-5, the other swings.
    let system = LinearSystem::new(
        dvector![1.0, 1.0],
        dmatrix![100.0, 0.0; 0.0, 0.1],
        dmatrix![1e-3, 0.0; 0.0, 1.0],
    );
    let none: [Stop; 0] = [];
    let force = Harmonic::new(dvector![0.0.into(), 1.0.into()], 0.7, 0.0).expect("valid");
    let scene = Scene::new(system.expect("valid"), force, none).expect("valid");
    let (q, v) = (dvector![1.0, 0.0], dvector![0.0, 0.0]);
    let span = (0.0, 5000.0);
    let found = lyapunov_exponents(&scene, &q, &v, span, &LyapunovOptions::default());
    let found = found.expect("exponents");
    assert_eq!(found.verdict, Attraction::Undecided, "{found:?}");
    assert!(found.message.contains("slow decay"), "{}", found.message);
}

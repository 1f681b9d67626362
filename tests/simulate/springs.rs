//! Stops that give way, in linear scenes: against closed forms, numbers of other methods, and rigid stops.

use nalgebra::{Complex, DVector, dmatrix, dvector};
use std::f64::consts::PI;
use vibroimpact::{
    ContactRelease, Forcing, Harmonic, ImpactSide, LinearSystem, Motion, Newton, Pattern, Scene,
    Side, SimulateOptions, Spring, Stop, Trajectory, periodic_orbits, simulate,
};

fn run(scene: &Scene, q: DVector<f64>, v: DVector<f64>, end: f64) -> Trajectory {
    simulate(scene, &q, &v, (0.0, end), &SimulateOptions::default()).expect("runs")
}

/// `x'' + 0.1 x' + x = cos 0.8 t` between a stop at 0.5 and one at -0.9, from x = 0, v = 0.3 to t = 20.
fn between_two(release: ContactRelease) -> Trajectory {
    let system = LinearSystem::new(dmatrix![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![Complex::new(1.0, 0.0)], 0.8, 0.0).expect("valid");
    let spring = |k| Spring::new(k, 0.5, Some(release)).expect("valid");
    let upper = Stop::new(0, 0.5, spring(20.0)).expect("valid");
    let lower = Stop::new(0, 0.9, spring(35.0)).expect("valid");
    let stops = [upper, lower.on_side(Side::Lower)];
    let scene = Scene::new(system, force, stops).expect("fits");
    run(&scene, dvector![0.0], dvector![0.3], 20.0)
}

#[test]
fn a_motion_between_two_stops_ends_where_the_references_say() {
    for (release, q, v, eighth) in [
        (
            ContactRelease::Gap,
            -0.813_048_690_801_954,
            0.849_060_223_008_812,
            12.475_918_622_107_7,
        ),
        (
            ContactRelease::Force,
            -0.811_734_034_490_746,
            0.855_229_864_438_667,
            12.464_044_715_638_3,
        ),
    ] {
        let run = between_two(release);
        let end = run.state(20.0, ImpactSide::After).expect("within");
        assert!((end.0[0] - q).abs() < 1e-12, "{release:?} {}", end.0);
        assert!((end.1[0] - v).abs() < 1e-12, "{release:?} {}", end.1);
        let contacts = run.contacts().expect("kept");
        assert_eq!((contacts.len(), run.stats().n_contacts), (7, 7));
        assert!((contacts[3].end - eighth).abs() < 1e-11, "{release:?}");
        let energy = run.energy().expect("kept");
        let most = energy.balance.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(most < 1e-13, "{release:?} {most:e}");
        let lost: f64 = contacts.iter().map(|own| own.loss).sum();
        let ledger = energy.contact_loss.last().expect("a last row");
        assert!((lost - ledger).abs() < 1e-12, "{release:?} {lost} {ledger}");
        let given: f64 = contacts
            .iter()
            .filter(|own| own.stop == 0)
            .map(|own| own.impulse)
            .sum();
        let whole = run.impulse(0, None).expect("kept");
        assert!((given - whole).abs() < 1e-12, "{release:?}");
    }
}

/// One contact of a free body of 2 kg at 0.8 m/s.
fn bounce(spring: Spring) -> Trajectory {
    // A stop from which the body does not come back is searched in steps of its own rate all along.
    let end = 0.625 + 30.0 / f64::sqrt(0.5 * spring.stiffness());
    let free = LinearSystem::new(dmatrix![2.0], dmatrix![0.0], dmatrix![0.0]).expect("valid");
    let stop = Stop::new(0, 0.5, spring).expect("valid");
    let scene = Scene::new(free, Forcing::Unforced, [stop]).expect("fits");
    run(&scene, dvector![0.0], dvector![0.8], end)
}

#[test]
fn a_free_body_is_given_back_what_each_law_says() {
    for release in [
        ContactRelease::Gap,
        ContactRelease::Force,
        ContactRelease::Clipped,
    ] {
        for stiffness in [1e-3, 50.0, 1e9] {
            for ratio in [0.0, 0.2, 0.9, 1.5] {
                let damping = 2.0 * ratio * f64::sqrt(2.0 * stiffness);
                let spring = Spring::new(stiffness, damping, Some(release)).expect("valid");
                let run = bounce(spring);
                let contacts = run.contacts().expect("kept");
                let own = contacts[0];
                assert_eq!(contacts.len(), 1);
                assert!((own.speed_before - 0.8).abs() < 1e-12);
                let back = spring.equivalent_restitution(2.0, None).expect("valid");
                if back == 0.0 {
                    // It comes back to the gap in an infinite time.
                    assert!(own.end.is_nan() && release == ContactRelease::Gap);
                    continue;
                }
                let rate = f64::sqrt(0.5 * stiffness);
                let damped = rate * f64::sqrt((1.0 - ratio * ratio).abs());
                let lasts = match (release, ratio) {
                    (_, 0.0) => PI / rate,
                    (ContactRelease::Gap, _) => PI / damped,
                    (_, 1.5) => 2.0 * ratio.acosh() / damped,
                    _ => 2.0 * ratio.acos() / damped,
                };
                let what = format!("{release:?} {stiffness:e} {ratio} {own:?}");
                // Of a stiff stop the rounding of the position is that of a speed, by the rate of the contact.
                assert!((own.speed_after - 0.8 * back).abs() < 1e-10, "{what}");
                // The time at which a contact ends is known to the rounding of the span.
                let known = 1e-9 * lasts + 1e-12;
                assert!((own.end - own.start - lasts).abs() < known, "{what}");
                assert!(
                    (own.impulse / (1.6 * (1.0 + back)) - 1.0).abs() < 1e-9,
                    "{what}"
                );
                let lost = 0.64 * (1.0 - back * back);
                assert!((own.loss - lost).abs() < 1e-9, "{what}");
                if ratio == 0.0 {
                    assert!(
                        (own.peak_approach * rate / 0.8 - 1.0).abs() < 1e-9,
                        "{what}"
                    );
                    assert!((own.peak_force / (1.6 * rate) - 1.0).abs() < 1e-9, "{what}");
                }
            }
        }
    }
}

#[test]
fn a_start_inside_is_pressed_and_two_bodies_push_each_other_apart() {
    // Two bodies that are free, with a bumper between them, in contact at the start.
    let free = LinearSystem::new(
        dmatrix![1.0, 0.0; 0.0, 3.0],
        dmatrix![0.0, 0.0; 0.0, 0.0],
        dmatrix![0.0, 0.0; 0.0, 0.0],
    );
    let bumper = Spring::new(12.0, 0.0, None).expect("valid");
    let stop = Stop::new(dvector![1.0, -1.0], 0.0, bumper).expect("valid");
    let scene = Scene::new(free.expect("valid"), Forcing::Unforced, [stop]).expect("fits");
    let run = run(&scene, dvector![0.2, -0.1], dvector![0.4, 0.4], 10.0);
    let own = run.contacts().expect("kept")[0];
    let rate = f64::sqrt(12.0 / 0.75);
    assert!(own.start == 0.0 && own.speed_before.is_nan());
    assert!((own.end - 0.5 * PI / rate).abs() < 1e-12);
    assert!((own.speed_after - 0.3 * rate).abs() < 1e-12);
    assert!((own.peak_approach - 0.3).abs() < 1e-15);
    // What was stored is motion now.
    let energy = run.energy().expect("kept");
    let stored = 0.5 * 12.0 * 0.09;
    assert!((energy.potential[0] - stored).abs() < 1e-14);
    assert!((own.loss).abs() < 1e-13);
    let (q, v) = run.state(10.0, ImpactSide::After).expect("within");
    let centre = (q[0] + 3.0 * q[1]) / 4.0;
    assert!((centre - (0.2 - 0.3) / 4.0 - 4.0).abs() < 1e-12);
    assert!((v[1] - v[0] - 0.3 * rate).abs() < 1e-12);
    let regimes = run.regimes().expect("kept");
    let states: Vec<_> = regimes.iter().map(|own| own.states[0]).collect();
    assert_eq!(states, ["pressed", "free"]);
}

#[test]
fn a_stiff_stop_is_a_rigid_one_with_an_error_like_one_over_the_root() {
    let system = || LinearSystem::new(dmatrix![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = || Harmonic::new(dvector![Complex::new(1.0, 0.0)], 0.8, 0.0).expect("valid");
    for release in [
        ContactRelease::Gap,
        ContactRelease::Force,
        ContactRelease::Clipped,
    ] {
        let end_of = |stop: Stop| {
            let scene = Scene::new(system(), force(), [stop]).expect("fits");
            let run = run(&scene, dvector![0.0], dvector![0.3], 17.0);
            run.state(17.0, ImpactSide::After).expect("within").0[0]
        };
        let rigid = Stop::new(0, 0.5, Newton::new(0.7).expect("valid")).expect("valid");
        let wanted = end_of(rigid);
        let scaled = [1e4, 1e6, 1e8].map(|k| {
            let spring = Spring::from_restitution(0.7, k, 1.0, release).expect("valid");
            let stop = Stop::new(0, 0.5, spring).expect("valid");
            (end_of(stop) - wanted).abs() * f64::sqrt(k)
        });
        for one in scaled {
            assert!(
                (one / scaled[2] - 1.0).abs() < 0.15,
                "{release:?} {scaled:?}"
            );
        }
    }
}

#[test]
fn patterns_other_than_one_contact_are_refused() {
    let run = between_two(ContactRelease::Gap);
    let together = Pattern::together(&[0, 1]).expect("valid");
    let options = vibroimpact::OrbitOptions::default();
    let error = periodic_orbits(run.scene(), &together, &options);
    let error = error.expect_err("refused").to_string();
    assert!(
        error.contains("pattern") && error.contains("find_orbit"),
        "{error}"
    );
}

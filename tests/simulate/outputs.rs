//! What is measured along a motion, against closed forms: components, accelerations, gaps, contact forces, impulses (theory 9).

use crate::scenes::{BOTH, ball, loaded, lower, run, scene, shaken_ball, unit_mass, with};
use nalgebra::dvector;
use vibroimpact::{
    Forcing, ImpactSide, Keep, Method, Motion, PeriodicOrbit, SegmentKind, SimulateOptions,
    find_orbit,
};

const AFTER: ImpactSide = ImpactSide::After;
const BEFORE: ImpactSide = ImpactSide::Before;

/// A ball of unit weight on a table that shakes: held for a while, then thrown off, in every period.
fn held_orbit(method: Method) -> PeriodicOrbit {
    let scene = shaken_ball(0.5, 1.3, 0.0);
    let period = scene.period().expect("forced");
    let motion = run(&scene, &[0.3], &[0.0], 12.0 * period, &with(method, 1e-10));
    find_orbit(&scene, &motion, None).expect("found")
}

#[test]
fn a_ball_is_measured_on_its_way_and_at_rest() {
    for method in BOTH {
        let motion = run(&ball(0.5), &[1.0], &[0.0], 12.0, &with(method, 1e-9));
        let hit = motion.impacts()[0].time;
        assert!((hit - 2f64.sqrt()).abs() < 1e-9);
        let times = [0.0, 0.5 * hit, 11.0];
        let gaps = motion.gap(0, Some(&times)).expect("kept");
        let heights = motion.along(0, Some(&times), 0, AFTER).expect("kept");
        assert_eq!(gaps, heights);
        assert!((gaps[1] - 0.75).abs() < 1e-9 && gaps[2].abs() < 1e-12);
        let forces = motion.contact_force(0, Some(&times)).expect("kept");
        assert_eq!(forces[..2], [0.0; 2]);
        assert!((forces[2] - 1.0).abs() < 1e-15);
        // Twice as much along twice the direction, both ways at an impact.
        for (side, speed) in [(BEFORE, -2.0 * hit), (AFTER, hit)] {
            let along = motion.along(dvector![2.0], Some(&[hit]), 1, side);
            assert!((along.expect("kept")[0] - speed).abs() < 1e-8);
        }
        let falling = motion.acceleration(0.5 * hit, AFTER).expect("kept");
        let resting = motion.acceleration(11.0, AFTER).expect("kept");
        assert!((falling[0] + 1.0).abs() < 1e-14 && resting[0].abs() < 1e-14);
    }
}

#[test]
fn a_table_gives_a_ball_what_its_weight_takes() {
    for (method, restitution) in [
        (Method::Exact, 0.5),
        (Method::Rk45, 0.5),
        (Method::Exact, 0.9),
    ] {
        let motion = run(
            &ball(restitution),
            &[1.0],
            &[0.0],
            60.0,
            &with(method, 1e-9),
        );
        assert!((motion.impulse(0, None).expect("kept") - 60.0).abs() < 1e-8);
        let segments = motion.segments().expect("kept");
        let chatter = segments.iter().find(|s| s.kind == SegmentKind::Chatter);
        let chatter = chatter.expect("it bounces without end");
        // The rest of the impacts: a geometric series.
        let speed = motion.impacts().last().expect("some").departure;
        let sum = (1.0 + restitution) * speed / (1.0 - restitution);
        assert!((chatter.impulse / sum - 1.0).abs() < 1e-6);
        let parts: f64 = segments.iter().map(|s| s.impulse).sum();
        let hits: f64 = motion.impacts().iter().map(|i| i.impulse).sum();
        assert!((parts + hits - 60.0).abs() < 1e-8);
        let halves = [(0.0, 2.3), (2.3, 60.0)].map(|span| motion.impulse(0, Some(span)));
        let halves: f64 = halves.map(|half| half.expect("kept")).iter().sum();
        assert!((halves - 60.0).abs() < 1e-8);
    }
}

#[test]
fn an_orbit_is_measured_at_any_time() {
    for method in BOTH {
        let orbit = held_orbit(method);
        let (period, phase) = (orbit.period(), orbit.phase());
        let impulse = orbit.impulse(0, None).expect("linear");
        assert!((impulse - period).abs() < 1e-9);
        let segments = orbit.segments().expect("linear");
        let held = segments.iter().find(|s| s.kind == SegmentKind::Stick);
        let middle = held.map(|s| 0.5 * (s.start + s.end)).expect("held");
        for t in [middle, middle - 4.0 * period] {
            let force = orbit.contact_force(0, Some(&[t])).expect("linear")[0];
            assert!((force - 1.0 + 1.3 * (t + phase).cos()).abs() < 1e-9);
            assert!(orbit.acceleration(t, AFTER).expect("linear")[0].abs() < 1e-13);
            assert!(orbit.gap(0, Some(&[t])).expect("linear")[0].abs() < 1e-12);
        }
        let early = 0.5 * segments[0].end;
        let along = orbit.along(0, Some(&[early]), 2, AFTER).expect("linear")[0];
        assert!((along + 1.0 - 1.3 * (early + phase).cos()).abs() < 1e-12);
        let window = Some((-2.5 * period, 1.5 * period));
        let four = orbit.impulse(0, window).expect("linear");
        assert!((four - 4.0 * impulse).abs() < 1e-9);
    }
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let scene = scene(
        loaded(unit_mass(0.0, 0.0), &[-1.0]),
        Forcing::Unforced,
        [lower(0, 0.0, 0.5)],
    );
    let motion = run(&scene, &[1.0], &[0.0], 3.0, &SimulateOptions::default());
    let says = |message: String, words: &str| assert!(message.contains(words), "{message}");
    let text = |result: vibroimpact::Result<Vec<f64>>| result.expect_err("refused").to_string();
    says(text(motion.along(1, None, 0, AFTER)), "direction is 1");
    says(
        text(motion.along(dvector![1.0, 2.0], None, 0, AFTER)),
        "direction has shape (2,)",
    );
    says(text(motion.along(0, None, 3, AFTER)), "derivative is 3");
    says(text(motion.gap(1, None)), "stop is 1");
    says(text(motion.contact_force(0, Some(&[3.5]))), "t is 3.5");
    for window in [(2.0, 1.0), (0.0, f64::NAN), (-1.0, 1.0), (0.0, 4.0)] {
        let refused = motion.impulse(0, Some(window)).expect_err("refused");
        says(refused.to_string(), "span is");
    }
    let options = SimulateOptions {
        keep: Keep::Impacts,
        ..Default::default()
    };
    let motion = run(&scene, &[1.0], &[0.0], 3.0, &options);
    says(text(motion.contact_force(0, None)), "keep is");
    assert!(motion.impulse(0, None).is_err() && motion.segments().is_err());
    let orbit = held_orbit(Method::Exact);
    says(
        text(orbit.along(0, Some(&[f64::NAN]), 0, AFTER)),
        "t is NaN",
    );
    says(text(orbit.gap(2, Some(&[0.0]))), "stop is 2");
    assert!(orbit.impulse(0, Some((1.0, 0.0))).is_err());
}

//! Orbits with two instants of impact, from outside: against a scan of flight times written independently of the library,
//! closed forms, and the laws every orbit obeys.

mod plain;

use crate::random::Cases;
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use plain::{Face, Plain, Sides, random_plain};
use std::f64::consts::{PI, TAU};
use vibroimpact::{
    Harmonic, ImpactSide, LinearSystem, Motion, OrbitOptions, Pattern, PeriodicOrbit, Scene, Side,
    Stop, Verdict, periodic_orbits,
};

fn flight_time(orbit: &PeriodicOrbit) -> f64 {
    orbit.impacts()[1].time
}

/// The laws of an orbit: it closes, its contacts are at the stops, its velocities turn.
fn check_orbit(plain: &Plain, orbit: &PeriodicOrbit, label: &str) {
    let t = orbit.period();
    let dt = flight_time(orbit);
    let speed = orbit.v0().amax()
        + orbit
            .state(0.0, ImpactSide::Before)
            .expect("a time")
            .1
            .amax();
    let size = orbit.q0().amax() + speed / plain.w;
    for (face, time) in plain.faces.iter().zip([0.0, dt]) {
        let ((q, before), (q_after, after)) = (
            orbit.state(time, ImpactSide::Before).expect("a time"),
            orbit.state(time, ImpactSide::After).expect("a time"),
        );
        assert!(
            (&q - &q_after).amax() < 1e-12 * size,
            "{label}: position jumps by {:e} at {time}",
            (&q - &q_after).amax()
        );
        assert!(
            (face.normal.dot(&q) - face.clearance).abs() < 1e-11 * size,
            "{label}: contact at {time}"
        );
        let turned = face.normal.dot(&after) + face.restitution * face.normal.dot(&before);
        assert!(
            turned.abs() < 1e-11 * speed,
            "{label}: restitution {turned:e} at {time}"
        );
    }
    // The flights by the exponential of the plain matrix, enlarged by the load and the forcing.
    let (n, big) = (plain.n(), plain.enlarged());
    for (start, end) in [(0.0, dt), (dt, t)] {
        let ((q, v), angle) = (
            orbit.state(start, ImpactSide::After).expect("a time"),
            orbit.phase() + plain.w * start,
        );
        let x = DVector::from_iterator(
            2 * n + 3,
            q.iter()
                .chain(v.iter())
                .copied()
                .chain([1.0, angle.cos(), angle.sin()]),
        );
        let arrived = (&big * (end - start)).exp() * x;
        let (q, v) = orbit.state(end, ImpactSide::Before).expect("a time");
        let miss = (arrived.rows(0, n) - q).amax() + (arrived.rows(n, n) - v).amax() / plain.w;
        assert!(
            miss < 1e-9 * size,
            "{label}: the flight from {start} to {end} misses by {miss:e}"
        );
    }
}

#[test]
fn random_scenes_have_the_orbits_that_a_scan_finds() {
    let cases = Cases::new(0x5EED, 40);
    let mut total = 0;
    for (case, mut random) in cases.each() {
        let sides = [Sides::One, Sides::Two, Sides::Symmetric][case % 3];
        let plain = random_plain(&mut random, sides);
        let label = format!(
            "case {case}, {sides:?}, n = {}, n_periods = {}",
            plain.n(),
            plain.n_periods
        );
        let (scene, pattern) = plain.scene();
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        let t = plain.period();
        let folded = |dt: f64| {
            if sides == Sides::One {
                dt.min(t - dt)
            } else {
                dt
            }
        };
        // At T/2 like instants have a shorter orbit, and symmetric scenes a double zero: tests of their own.
        let is_half = |dt: f64| sides != Sides::Two && (dt - 0.5 * t).abs() < 1e-5 * t;
        let mut expected: Vec<f64> = plain
            .scan(10_000)
            .into_iter()
            .filter(|&dt| !is_half(dt))
            .map(folded)
            .collect();
        expected.retain(|&dt| sides != Sides::One || (dt > 1e-6 * t && t - dt > 1e-6 * t));
        for &dt in &expected {
            let found = orbits
                .iter()
                .any(|o| (flight_time(o) - dt).abs() < 1e-6 * t);
            let all: Vec<f64> = orbits.iter().map(flight_time).collect();
            assert!(
                found,
                "{label}: dt = {dt} of T = {t} is missing from {all:?}: {}",
                orbits.reason()
            );
        }
        for orbit in orbits.iter() {
            check_orbit(&plain, orbit, &label);
            let dt = flight_time(orbit);
            if !is_half(dt) {
                let contact = plain.at(dt);
                let u = DVector::from_vec(vec![orbit.phase().cos(), orbit.phase().sin()]);
                let miss =
                    (&contact.l * u - &contact.d).amax() / (contact.d.amax() + contact.l.amax());
                assert!(miss < 1e-8, "{label}: dt = {dt} is invented, {miss:e}");
            }
            let twins = orbits.iter().filter(|o| {
                (flight_time(o) - dt).abs() < 1e-9 * t && (o.phase() - orbit.phase()).abs() < 1e-7
            });
            assert_eq!(twins.count(), 1, "{label}: dt = {dt} is there twice");
        }
        assert!(
            !orbits.reason().contains("could not"),
            "{label}: {}",
            orbits.reason()
        );
        total += orbits.len();
        println!(
            "{label}: {} expected {}; {}",
            orbits.len(),
            expected.len(),
            orbits.reason()
        );
    }
    assert!(
        cases.have(total, 50),
        "{total} orbits are too few to mean anything"
    );
}

fn oscillator(
    damping: f64,
    load: f64,
    restitution: f64,
    clearances: (f64, f64),
    (force, w): (f64, f64),
    n_periods: usize,
) -> Plain {
    let face = |normal: f64, clearance: f64| Face {
        normal: dvector![normal],
        clearance,
        restitution,
    };
    Plain {
        mass: dmatrix![1.0],
        damping: dmatrix![damping],
        stiffness: dmatrix![1.0],
        load: dvector![load],
        force: dvector![force],
        w,
        n_periods,
        faces: [face(1.0, clearances.0), face(-1.0, clearances.1)],
    }
}

#[test]
fn the_symmetric_orbit_of_a_two_sided_oscillator_has_its_closed_form() {
    // q(t + T/2) = -q(t) for odd n: with h = T/2 the impulse p obeys the half-period problem
    // x+ = z + s(0), z = -(I + e^{Ah})^-1 B p, v+ + e v- = 0, v- = v+ + p.
    for (n_periods, w, force, clearance, e) in [
        (1, 1.7, 1.0, 0.3, 0.8),
        (3, 3.3, 4.0, 0.2, 0.6),
        (1, 0.8, 0.5, 0.6, 1.0),
    ] {
        let plain = oscillator(0.1, 0.0, e, (clearance, clearance), (force, w), n_periods);
        let (scene, pattern) = plain.scene();
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        let (t, a) = (plain.period(), plain.state_matrix());
        let response = (DMatrix::identity(2, 2) + (&a * (0.5 * t)).exp())
            .try_inverse()
            .expect("damped")
            * dvector![0.0, -1.0];
        // v+ = s_v u + response_v p; v+ (1 + e) + e p = 0; q+ = s_q u + response_q p = clearance
        let s = plain.steady(0.0);
        let factor = -(1.0 + e) / ((1.0 + e) * response[1] + e);
        let alpha = [0, 1].map(|c| s[(0, c)] + response[0] * factor * s[(1, c)]);
        let (size, angle) = (alpha[0].hypot(alpha[1]), alpha[1].atan2(alpha[0]));
        let expected: Vec<f64> = if clearance > size {
            Vec::new()
        } else {
            [1.0, -1.0]
                .map(|sign| (angle + sign * (clearance / size).acos()).rem_euclid(TAU))
                .to_vec()
        };
        assert!(!expected.is_empty());
        let symmetric: Vec<&PeriodicOrbit> = orbits
            .iter()
            .filter(|o| (flight_time(o) / t - 0.5).abs() < 1e-9)
            .collect();
        assert_eq!(symmetric.len(), 2, "{n_periods}: {}", orbits.reason());
        for phase in expected {
            let orbit = symmetric
                .iter()
                .min_by(|a, b| {
                    (a.phase() - phase)
                        .abs()
                        .total_cmp(&(b.phase() - phase).abs())
                })
                .expect("two");
            assert!(
                (orbit.phase() - phase).abs() < 1e-12,
                "{} {phase}",
                orbit.phase()
            );
            assert!((flight_time(orbit) / t - 0.5).abs() < 1e-14);
            for i in 0..10 {
                let time = t * f64::from(i) / 20.0 + 0.01;
                assert!(
                    (orbit.state(time, ImpactSide::After).expect("a time").0
                        + orbit
                            .state(time + 0.5 * t, ImpactSide::After)
                            .expect("a time")
                            .0)
                        .amax()
                        < 1e-12
                );
            }
            check_orbit(&plain, orbit, "symmetric");
        }
    }
}

#[test]
fn asymmetric_orbits_of_a_symmetric_scene_come_in_pairs() {
    let (cases, mut pairs) = (Cases::new(77, 60), 0);
    for (case, mut random) in cases.each() {
        let plain = random_plain(&mut random, Sides::Symmetric);
        let (scene, pattern) = plain.scene();
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        let t = plain.period();
        for orbit in orbits.iter() {
            // The mirror image, started at its other impact.
            let dt = t - flight_time(orbit);
            let phase = orbit.phase() + plain.w * flight_time(orbit) + PI;
            let is_there = orbits.iter().any(|o| {
                (flight_time(o) - dt).abs() < 1e-9 * t
                    && (0.5 * (o.phase() - phase)).sin().abs() < 1e-7
            });
            assert!(
                is_there,
                "case {case}: dt = {} of {t} has no mirror image",
                flight_time(orbit)
            );
            pairs += usize::from((dt / t - 0.5).abs() > 1e-6);
        }
    }
    assert!(cases.have(pairs, 15), "{pairs}");
}

#[test]
fn a_shorter_orbit_gone_through_twice_is_not_an_orbit_of_two_impacts() {
    let mut found = 0;
    for force in [0.8, 1.0, 1.5, 3.0] {
        for (w, n_periods) in [(1.7, 2), (2.8, 2), (2.8, 4), (0.7, 2)] {
            let mut plain = oscillator(0.1, 0.0, 0.8, (0.3, 0.3), (force, w), n_periods);
            plain.faces[1] = plain.faces[0].clone();
            let (scene, pattern) = plain.scene();
            let half = OrbitOptions {
                n_periods: n_periods / 2,
                ..Default::default()
            };
            let short = periodic_orbits(&scene, &Pattern::single(0), &half).expect("solved");
            let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
            found += short.len();
            for orbit in orbits.iter() {
                let impacts = orbit.impacts();
                let is_repeated = (impacts[1].time / orbit.period() - 0.5).abs() < 1e-9
                    && (impacts[0].impulse - impacts[1].impulse).abs()
                        < 1e-9 * impacts[0].impulse.abs();
                assert!(!is_repeated, "force {force} w {w}: {}", orbits.reason());
            }
        }
    }
    assert!(found > 10);
}

#[test]
fn a_given_phase_gives_the_flight_time_and_the_clearance() {
    let (cases, mut total) = (Cases::new(4242, 40), 0);
    for (case, mut random) in cases.each() {
        let plain = random_plain(&mut random, Sides::One);
        let (scene, pattern) = plain.scene();
        // The phases of orbits at the given clearance give these orbits back.
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        for orbit in orbits.iter().take(2) {
            let options = OrbitOptions {
                phase: Some(orbit.phase()),
                ..plain.options()
            };
            let again = periodic_orbits(&scene, &pattern, &options).expect("solved");
            let same = again
                .iter()
                .find(|o| (flight_time(o) - flight_time(orbit)).abs() < 1e-8 * plain.period());
            let Some(same) = same else {
                panic!(
                    "case {case}: dt = {} is missing: {}",
                    flight_time(orbit),
                    again.reason()
                )
            };
            assert!(
                (same.v0() - orbit.v0()).amax() < 1e-6 * (1.0 + orbit.v0().amax()),
                "case {case}"
            );
            for other in again.iter() {
                let dt = flight_time(other);
                let n = &plain.faces[0].normal;
                let (here, there) = (
                    n.dot(&other.state(0.0, ImpactSide::After).expect("a time").0),
                    n.dot(&other.state(dt, ImpactSide::After).expect("a time").0),
                );
                assert!(
                    (here - there).abs() < 1e-10 * (1.0 + here.abs()),
                    "case {case}: {here} {there}"
                );
                let moved = Plain {
                    faces: [0, 1].map(|_| Face {
                        clearance: here,
                        ..plain.faces[0].clone()
                    }),
                    ..plain.clone()
                };
                check_orbit(&moved, other, &format!("case {case}, phase given"));
                assert!((other.phase() - orbit.phase()).abs() < 1e-14);
            }
            total += again.len();
        }
    }
    assert!(cases.have(total, 50), "{total}");
    let plain = oscillator(0.1, 0.0, 0.8, (0.3, 0.4), (1.0, 1.7), 1);
    let (scene, pattern) = plain.scene();
    let options = OrbitOptions {
        phase: Some(0.3),
        ..plain.options()
    };
    let message = periodic_orbits(&scene, &pattern, &options)
        .expect_err("refused")
        .to_string();
    assert!(message.starts_with("phase"), "{message}");
}

#[test]
fn an_impact_that_leaves_no_speed_leaves_nothing_undecided() {
    // e = 0: the contacts then agree to second order where the instants meet.
    for (case, mut random) in Cases::new(621, 300).each() {
        let mut plain = random_plain(&mut random, Sides::One);
        for face in &mut plain.faces {
            face.restitution = 0.0;
        }
        let (scene, pattern) = plain.scene();
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        assert!(
            !orbits.reason().contains("double zero"),
            "case {case}: {}",
            orbits.reason()
        );
        for orbit in orbits.iter() {
            check_orbit(&plain, orbit, &format!("case {case}, e = 0"));
        }
    }
}

#[test]
fn the_monodromy_matrix_is_the_derivative_of_the_return_map() {
    let (cases, mut checked) = (Cases::new(99, 30), 0);
    for (case, mut random) in cases.each() {
        let sides = if case % 2 == 0 {
            Sides::Two
        } else {
            Sides::One
        };
        let mut plain = random_plain(&mut random, sides);
        if sides == Sides::Two {
            plain.faces[1].restitution = 0.6;
        }
        let (scene, pattern) = plain.scene();
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        for orbit in orbits.iter() {
            let stability = orbit.stability().expect("converges");
            // Where an impact is slow beside the motion the return map is too curved for differences.
            let fast = orbit.v0().amax().max(plain.w * orbit.q0().amax());
            let slowest = orbit
                .impacts()
                .iter()
                .map(|i| i.approach.abs())
                .fold(f64::INFINITY, f64::min);
            let Some(order) = stability.orders.first().filter(|_| slowest > 0.1 * fast) else {
                continue;
            };
            let (n, dt) = (plain.n(), flight_time(orbit));
            let phases = [1.0, orbit.phase().cos(), orbit.phase().sin()];
            let start = orbit
                .q0()
                .iter()
                .chain(orbit.v0().iter())
                .copied()
                .chain(phases)
                .collect::<Vec<_>>();
            let start = DVector::from_vec(start);
            let home = plain.return_map(&start, dt);
            assert!((&home - &start).amax() < 1e-9 * start.amax(), "case {case}");
            let step = 1e-6 * orbit.q0().amax();
            for c in 0..2 * n {
                let moved = |sign: f64| {
                    let mut x = start.clone();
                    x[c] += sign * step;
                    plain.return_map(&x, dt)
                };
                let column = ((moved(1.0) - moved(-1.0)) / (2.0 * step))
                    .rows(0, 2 * n)
                    .into_owned();
                let miss = (column - order.monodromy.column(c)).amax();
                assert!(
                    miss < 1e-5 * (1.0 + order.monodromy.amax()),
                    "case {case}, column {c}: {miss:e}"
                );
            }
            checked += 1;
        }
    }
    assert!(cases.have(checked, 50), "{checked}");
}

#[test]
fn undamped_modes_in_step_with_the_period_keep_their_unknowns() {
    // w = w_1 exactly, no damping: no steady response; and a rigid body under a load (a ball between two plates).
    for (stiffness, load, w) in [(4.0, 0.0, 2.0), (0.0, 0.4, 1.3), (4.0, 0.1, 2.0)] {
        for sides in [Sides::One, Sides::Two] {
            let mut plain = oscillator(0.0, load, 0.7, (0.3, 0.5), (0.6, w), 2);
            plain.stiffness[(0, 0)] = stiffness;
            if sides == Sides::One {
                plain.faces[1] = plain.faces[0].clone();
            }
            let (scene, pattern) = plain.scene();
            let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
            println!(
                "{stiffness} {sides:?} {:?} {}",
                orbits.iter().map(flight_time).collect::<Vec<_>>(),
                orbits.reason()
            );
            for orbit in orbits.iter() {
                check_orbit(&plain, orbit, "retained");
            }
            // A little damping, off resonance by as little, must change little.
            let mut near = plain.clone();
            near.damping[(0, 0)] = 1e-3;
            near.stiffness[(0, 0)] += 1e-3;
            let (scene, pattern) = near.scene();
            let others = periodic_orbits(&scene, &pattern, &near.options()).expect("solved");
            assert_eq!(
                others.len(),
                orbits.len(),
                "{} against {}",
                orbits.reason(),
                others.reason()
            );
            for orbit in orbits.iter() {
                let t = orbit.period();
                assert!(
                    others
                        .iter()
                        .any(|o| (flight_time(o) - flight_time(orbit)).abs() < 0.02 * t),
                    "{}",
                    flight_time(orbit)
                );
            }
        }
    }
}

#[test]
fn nothing_is_found_where_the_forcing_is_too_weak() {
    let plain = oscillator(0.1, 0.0, 0.8, (5.0, 5.0), (0.1, 1.7), 1);
    let (scene, pattern) = plain.scene();
    let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
    assert_eq!((orbits.verdict(), orbits.len()), (Verdict::None, 0));
    assert!(
        orbits.reason().contains("excluded by bounds"),
        "{}",
        orbits.reason()
    );
    // The same on the lower side of one coordinate, given as a side.
    let system = LinearSystem::new(dvector![1.0], dvector![0.1], dvector![1.0]).expect("valid");
    let stops = [
        Stop::new(0, 0.3, 0.8).expect("valid"),
        Stop::new(0, 0.3, 0.8).expect("valid").on_side(Side::Lower),
    ];
    let forcing = Harmonic::new(dvector![1.0.into()], 1.7, 0.0).expect("valid");
    let scene = Scene::new(system, forcing, stops).expect("valid");
    assert!(
        periodic_orbits(&scene, &pattern, &plain.options())
            .expect("solved")
            .len()
            >= 2
    );
}

#[test]
fn stops_hit_together_meet_all_their_contacts_or_none() {
    // Two equal oscillators, uncoupled, between equal stops: what one does the other does.
    let single = oscillator(0.1, 0.0, 0.7, (0.3, 0.4), (1.0, 1.7), 1);
    let (scene, pattern) = single.scene();
    let alone = periodic_orbits(&scene, &pattern, &single.options()).expect("solved");
    let pair = |clearance: f64| {
        let two = |x: f64| dvector![x, x];
        let system = LinearSystem::new(two(1.0), two(0.1), two(1.0)).expect("valid");
        let stop = |i: usize, c: f64| Stop::new(i, c, 0.7).expect("valid");
        let lower = |i: usize, c: f64| stop(i, c).on_side(Side::Lower);
        let forcing = Harmonic::new(two(1.0).map(Into::into), 1.7, 0.0).expect("valid");
        let stops = [
            stop(0, 0.3),
            stop(1, clearance),
            lower(0, 0.4),
            lower(1, 0.4),
        ];
        let scene = Scene::new(system, forcing, stops).expect("valid");
        let pattern = Pattern::new(vec![vec![0, 1], vec![2, 3]]).expect("valid");
        periodic_orbits(&scene, &pattern, &single.options()).expect("solved")
    };
    assert!(!alone.is_empty());
    let both = pair(0.3);
    assert_eq!(
        both.len(),
        alone.len(),
        "{} against {}",
        both.reason(),
        alone.reason()
    );
    for orbit in both.iter() {
        assert_eq!(orbit.impacts().len(), 4);
        assert!((orbit.q0()[0] - orbit.q0()[1]).abs() < 1e-12);
        assert!(
            alone
                .iter()
                .any(|o| (flight_time(o) - orbit.impacts()[2].time).abs() < 1e-10)
        );
    }
    let none = pair(0.31);
    assert!(
        none.is_empty() && none.reason().contains("not those of all stops"),
        "{}",
        none.reason()
    );
}

#[test]
fn without_damping_and_loss_the_orbits_are_those_of_a_little_of_both() {
    let mut found = 0;
    for (sides, w, n_periods) in [
        (Sides::Two, 1.7, 1),
        (Sides::Two, 2.9, 2),
        (Sides::One, 1.7, 2),
        (Sides::One, 2.9, 3),
        (Sides::Symmetric, 1.7, 1),
    ] {
        let with = |loss: f64| {
            let mut plain = oscillator(loss, 0.0, 1.0 - loss, (0.3, 0.4), (1.0, w), n_periods);
            match sides {
                Sides::One => plain.faces[1] = plain.faces[0].clone(),
                Sides::Symmetric => plain.faces[1].clearance = 0.3,
                Sides::Two => {}
            }
            let (scene, pattern) = plain.scene();
            (
                periodic_orbits(&scene, &pattern, &plain.options()).expect("solved"),
                plain,
            )
        };
        let ((ideal, plain), (real, _)) = (with(0.0), with(1e-7));
        println!(
            "{sides:?} {w} {n_periods}: {} and {}; {}",
            ideal.len(),
            real.len(),
            ideal.reason()
        );
        for orbit in ideal.iter() {
            check_orbit(&plain, orbit, "conservative");
        }
        for orbit in real.iter() {
            let near = ideal
                .iter()
                .filter(|o| (flight_time(o) - flight_time(orbit)).abs() < 1e-4 * orbit.period());
            let miss = near
                .map(|o| (0.5 * (o.phase() - orbit.phase())).sin().abs())
                .fold(1.0, f64::min);
            println!(
                "   {} {} {miss:e}",
                flight_time(orbit) / orbit.period(),
                orbit.phase()
            );
            assert!(miss < 1e-3, "{sides:?} {w}: {}", flight_time(orbit));
        }
        found += real.len();
    }
    assert!(found > 5, "{found}");
}

#[test]
fn extreme_scenes_are_searched_in_reasonable_time() {
    let timed = |plain: &Plain, label: &str| {
        let (scene, pattern) = plain.scene();
        let start = std::time::Instant::now();
        let orbits = periodic_orbits(&scene, &pattern, &plain.options()).expect("solved");
        let spent = start.elapsed().as_secs_f64();
        println!(
            "{label}: {:.2} ms, {} orbits, {}",
            1e3 * spent,
            orbits.len(),
            orbits.reason()
        );
        for orbit in orbits.iter() {
            check_orbit(plain, orbit, label);
        }
        orbits.len()
    };
    timed(
        &oscillator(0.1, 0.0, 0.8, (0.3, 0.4), (0.0, 1.7), 1),
        "no force",
    );
    timed(
        &oscillator(0.1, 0.0, 0.0, (0.3, 0.3), (1.0, 1.7), 1),
        "plastic",
    );
    timed(
        &oscillator(0.1, 0.0, 1e-6, (0.3, 0.3), (1.0, 1.7), 2),
        "nearly plastic",
    );
    timed(
        &oscillator(50.0, 0.0, 0.8, (0.01, 0.02), (1.0, 1.7), 1),
        "overdamped",
    );
    timed(
        &oscillator(2.0, 0.0, 0.8, (0.1, 0.2), (1.0, 1.7), 2),
        "critical",
    );
    timed(
        &oscillator(0.01, 0.0, 0.8, (0.3, 0.4), (1.0, 0.05), 1),
        "slow forcing",
    );
    timed(
        &oscillator(0.01, 0.0, 0.8, (0.003, 0.004), (1.0, 20.0), 1),
        "fast forcing",
    );
    timed(
        &oscillator(0.1, 0.0, 0.8, (0.3, 0.4), (1.0, 1.7), 12),
        "twelve periods",
    );
    for n in [2, 3] {
        // One Jordan block of equal oscillators: nothing uncouples.
        let mut defective = oscillator(0.0, 0.0, 0.8, (0.3, 0.4), (1.0, 1.7), 1);
        defective.mass = DMatrix::identity(n, n);
        defective.damping = DMatrix::identity(n, n) * 0.2;
        defective.stiffness =
            DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j || j == i + 1)));
        defective.load = DVector::zeros(n);
        defective.force = DVector::from_element(n, 1.0);
        let normal = DVector::from_fn(n, |i, _| f64::from(u8::from(i == 0)));
        defective.faces[0].normal = normal.clone();
        defective.faces[1].normal = -normal;
        let found = timed(&defective, "defective");
        // A little apart, the oscillators have complex modes.
        for i in 0..n {
            defective.stiffness[(i, i)] += 1e-2 * (i + 1) as f64;
        }
        assert_eq!(timed(&defective, "nearly defective"), found);
    }
    let n = 30;
    let mut chain = oscillator(0.1, 0.0, 0.8, (0.3, 0.4), (1.0, 1.7), 1);
    chain.mass = DMatrix::identity(n, n);
    chain.stiffness = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => 2.0 * 9.0,
        1 => -9.0,
        _ => 0.0,
    });
    chain.damping = &chain.stiffness * 0.02;
    chain.load = DVector::zeros(n);
    chain.force = DVector::from_element(n, 0.2);
    let normal = DVector::from_fn(n, |i, _| f64::from(u8::from(i == n / 2)));
    chain.faces[0].normal = normal.clone();
    chain.faces[1].normal = -normal;
    timed(&chain, "chain of 30");
}

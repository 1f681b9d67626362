//! Exact flights from outside: orbits retraced, closed forms, random scenes against brute force, diagnoses.

use crate::scenes::{ball, harmonic, linear, loaded, oscillator, run, scene, unit_mass, upper};
use nalgebra::{DVector, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    Forcing, FreeParameter, ImpactSide, Keep, Kind, Motion, OrbitOptions, PaperOptions, Parameter,
    Pattern, Scene, SegmentKind, SimulateOptions, Solver, Status, Stop, paper_scene,
    periodic_orbits, simulate,
};

#[test]
fn stable_admissible_orbits_are_retraced_for_a_thousand_periods() {
    let first = {
        let scene = paper_scene(Kind::One, &PaperOptions::default()).expect("valid");
        let options = OrbitOptions {
            n_periods: 3,
            free: Some(FreeParameter::Clearance),
            ..Default::default()
        };
        periodic_orbits(
            &scene,
            &Pattern::together(&[0, 1]).expect("valid"),
            &options,
        )
        .expect("solved")
    };
    let one = |kind: Kind, stop: usize| {
        let scene = paper_scene(kind, &PaperOptions::default()).expect("valid");
        let options = OrbitOptions {
            n_periods: 2,
            ..Default::default()
        };
        periodic_orbits(&scene, &Pattern::single(stop), &options).expect("solved")
    };
    for orbits in [first, one(Kind::Two, 0), one(Kind::Three, 1)] {
        let orbit = &orbits[0];
        assert!(
            orbit.is_admissible() == Some(true)
                && orbit.stability().expect("converges").is_stable == Some(true)
        );
        let span = (0.0, 1000.0 * orbit.period());
        let options = SimulateOptions {
            keep: Keep::Impacts,
            ..Default::default()
        };
        let run = simulate(orbit.scene(), &orbit.q0(), &orbit.v0(), span, &options).expect("runs");
        assert_eq!(run.status(), Status::Finished, "{}", run.message());
        // The last impact may fall on either side of the end of the span by rounding.
        let per_period = orbit.impacts().len();
        assert!(
            run.impacts().len().abs_diff(1000 * per_period) <= per_period,
            "{}",
            run.impacts().len()
        );
        for (k, impact) in run.impacts().iter().enumerate() {
            let drift = impact.time - (k / per_period + 1) as f64 * orbit.period();
            assert!(drift.abs() < 1e-9, "{drift:e}");
            assert!((impact.approach - orbit.impacts()[k % per_period].approach).abs() < 1e-9);
        }
        let middle = simulate(
            orbit.scene(),
            &orbit.q0(),
            &orbit.v0(),
            (0.0, 999.5 * orbit.period()),
            &options,
        )
        .expect("runs");
        assert!(
            (middle.last().0
                - orbit
                    .state(0.5 * orbit.period(), ImpactSide::After)
                    .expect("a time")
                    .0)
                .amax()
                < 1e-9
        );
    }
}

#[test]
fn a_bouncing_ball_keeps_its_closed_form_until_its_impacts_are_completed() {
    for e in [0.5f64, 0.9] {
        let run = run(&ball(e), &[1.0], &[0.0], 100.0, &SimulateOptions::default());
        assert_eq!(run.status(), Status::Finished);
        let v = 2f64.sqrt();
        for (k, impact) in run.impacts().iter().enumerate() {
            let ek = e.powi(i32::try_from(k).expect("few"));
            // t_k = v (1 + 2 e (1 - e^k)/(1 - e)), speed v e^k
            let time = v * (1.0 + 2.0 * e * (1.0 - ek) / (1.0 - e));
            assert!(
                (impact.time - time).abs() < 1e-13 * (1.0 + k as f64),
                "{k} {:e}",
                impact.time - time
            );
            assert!(
                (impact.approach - v * ek).abs() < 1e-13
                    && (impact.departure - e * impact.approach).abs() < 1e-14
            );
        }
        assert!(run.impacts().len() > 10);
    }
}

#[test]
fn a_plastic_impact_ends_in_lasting_contact() {
    let run = run(&ball(0.0), &[1.0], &[0.0], 9.0, &SimulateOptions::default());
    assert_eq!((run.status(), run.impacts().len()), (Status::Finished, 1));
    let last = *run
        .segments()
        .expect("kept")
        .last()
        .expect("a flight and a contact");
    assert_eq!((last.kind, last.stop), (SegmentKind::Stick, Some(0)));
    assert!((last.start - 2f64.sqrt()).abs() < 1e-15 && last.end == 9.0);
    assert_eq!((run.last().0[0], run.last().1[0]), (0.0, 0.0));
}

#[test]
fn an_elastic_oscillator_bounces_for_ever_at_the_same_speed() {
    // q'' + q = 0 with a wall at c: period 2 (pi - arccos(c)) for unit energy... half a turn minus the part cut off.
    let scene = oscillator(0.0, Forcing::Unforced, [upper(0, 0.5, 1.0)]);
    let options = SimulateOptions {
        keep: Keep::Impacts,
        max_impacts: Some(100_000),
        ..Default::default()
    };
    let run = run(&scene, &[-1.0], &[0.0], 1e9, &options);
    assert_eq!(
        (run.status(), run.impacts().len()),
        (Status::MaxImpacts, 100_000)
    );
    let (first, last) = (run.impacts()[0], run.impacts()[99_999]);
    let period = TAU - 2.0 * 0.5f64.acos();
    assert!((first.time - period / 2.0).abs() < 1e-14);
    assert!((last.time - first.time - 99_999.0 * period).abs() < 1e-7);
    assert!((last.approach - 0.75f64.sqrt()).abs() < 1e-9);
}

fn forced(clearance: f64, w: f64) -> Scene {
    oscillator(0.1, harmonic(&[1.0], w, 0.0), [upper(0, clearance, 0.8)])
}

#[test]
fn shallow_contacts_are_never_missed() {
    // A resonant oscillator from rest, its peaks known by sampling the free flight: walls from 1e-6 to 1e-1 below.
    let w = (1.0f64 - 0.05 * 0.05).sqrt();
    let open = forced(100.0, w);
    let times: Vec<f64> = (0..200_000)
        .map(|i| f64::from(i) * 60.0 / 200_000.0)
        .collect();
    let options = SimulateOptions {
        t_eval: Some(times.clone()),
        ..Default::default()
    };
    let (_, q, _) = run(&open, &[0.0], &[0.0], 60.0, &options)
        .samples()
        .expect("kept");
    let peaks: Vec<(f64, f64)> = (1..times.len() - 1)
        .filter(|&i| q[i] > q[i - 1] && q[i] >= q[i + 1] && q[i] > 0.1)
        .map(|i| (times[i], q[i]))
        .collect();
    assert!(peaks.len() >= 8);
    for &(time, height) in &peaks[..8] {
        for step in 0..26 {
            let depth = 10f64.powf(-6.0 + 0.2 * f64::from(step));
            let run = run(
                &forced(height - depth, w),
                &[0.0],
                &[0.0],
                time + 1.0,
                &SimulateOptions {
                    max_impacts: Some(1),
                    ..Default::default()
                },
            );
            assert_eq!(run.impacts().len(), 1, "peak {time} depth {depth:e}");
            assert!((run.impacts()[0].time - time).abs() < (4.0 * depth).sqrt() + 1e-3);
        }
    }
}

#[test]
fn a_touch_within_rounding_is_a_graze_and_any_deeper_one_an_impact() {
    // q = -cos t reaches 1 exactly.
    let scene = |clearance: f64| {
        scene(
            unit_mass(0.0, 1.0),
            Forcing::Unforced,
            [upper(0, clearance, 0.9)],
        )
    };
    for (gap, grazes, impacts) in [
        (0.0, 3, 0),
        (f64::EPSILON, 3, 0),
        (-f64::EPSILON, 3, 0),
        (1e-13, 0, 0),
        (-1e-13, 0, 1),
        (1e-6, 0, 0),
        (-1e-6, 0, 1),
    ] {
        let options = SimulateOptions {
            max_impacts: Some(1),
            ..Default::default()
        };
        let run = run(&scene(1.0 + gap), &[-1.0], &[0.0], 6.0 * 3.0, &options);
        assert_eq!(
            (run.grazes().len(), run.impacts().len()),
            (grazes, impacts),
            "{gap:e} {}",
            run.message()
        );
        for graze in run.grazes() {
            assert!((graze.depth + gap).abs() < 2.0 * f64::EPSILON);
        }
    }
}

#[test]
fn touches_beside_a_stop_that_is_held_are_listed() {
    // The first body rests on its stop; q = -cos t of the second one reaches 1 exactly.
    let system = loaded(
        linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![0.0, 1.0]),
        &[1.0, 0.0],
    );
    let stop = |i: usize, clearance| upper(i, clearance, 0.5);
    let scene = scene(system, Forcing::Unforced, [stop(0, 0.0), stop(1, 1.0)]);
    let (q, v) = (dvector![0.0, -1.0], dvector![0.0, 0.0]);
    let run = simulate(&scene, &q, &v, (0.0, 15.0), &SimulateOptions::default()).expect("runs");
    assert!(run.impacts().is_empty());
    let grazes = run.grazes();
    assert_eq!(grazes.iter().map(|g| g.stop).collect::<Vec<_>>(), [1, 1]);
    for (graze, turns) in grazes.iter().zip([1.0, 3.0]) {
        let time = turns * std::f64::consts::PI;
        assert!((graze.time - time).abs() < 1e-7 && graze.depth.abs() < 4.0 * f64::EPSILON);
    }
}

#[test]
fn contacts_of_one_step_come_in_order_however_close_they_are() {
    // Two oscillators q_i = -cos(w_i t), each with its own stop, reached at known times that are all but the same.
    let apart = |times: [f64; 2]| {
        let w = dvector![1.0, 1.7];
        let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], w.component_mul(&w));
        let stops = [0, 1].map(|i| upper(i, -(w[i] * times[i]).cos(), 0.8));
        let scene = scene(system, Forcing::Unforced, stops);
        let (q, v) = (dvector![-1.0, -1.0], dvector![0.0, 0.0]);
        let options = SimulateOptions::default();
        simulate(&scene, &q, &v, (0.0, 1.7), &options).expect("runs")
    };
    for exponent in 4..13 {
        for sign in [-1.0, 1.0] {
            let delta = sign * 10f64.powi(-exponent);
            let times = [1.6, 1.6 + delta];
            let run = apart(times);
            let hit: Vec<usize> = run.impacts().iter().map(|impact| impact.stop).collect();
            assert_eq!(hit, if delta > 0.0 { [0, 1] } else { [1, 0] }, "{delta:e}");
            for impact in run.impacts() {
                let late = impact.time - times[impact.stop];
                assert!(late.abs() < 4e-15, "{delta:e}: late by {late:e}");
            }
        }
    }
}

#[test]
fn the_position_goes_on_at_an_impact_beside_a_very_slow_motion() {
    // Steps as long as the slow motion allows must not carry the fast one over the last bit of a flight.
    for slow in [1e-3, 1e-6, 1e-9] {
        let stiffness = dvector![1.0, slow * slow];
        let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], stiffness);
        let stop = upper(dvector![1.0, 0.1], 0.5, 1.0);
        let scene = scene(system, Forcing::Unforced, [stop]);
        let (q, v) = (dvector![-1.0, 0.0], dvector![0.0, -0.02]);
        let run = simulate(&scene, &q, &v, (0.0, 30.0), &SimulateOptions::default()).expect("runs");
        assert!(run.impacts().len() > 2, "{}", run.message());
        for impact in run.impacts() {
            let before = run.state(impact.time, ImpactSide::Before).expect("kept").0;
            let after = run.state(impact.time, ImpactSide::After).expect("kept").0;
            let jump = (before - after).amax();
            assert!(
                jump < 1e-14,
                "slow {slow:e}: the position jumps by {jump:e}"
            );
        }
    }
}

#[test]
fn a_contact_at_the_end_of_the_span_is_counted_if_it_is_not_later() {
    // q = -cos t reaches the stop at t = 1 + k 0.05; the span ends within rounding before, at or after.
    for k in 0..20 {
        let contact = 1.0 + 0.05 * f64::from(k);
        let stop = upper(0, -contact.cos(), 0.8);
        let scene = oscillator(0.0, Forcing::Unforced, [stop]);
        let go = |q: &DVector<f64>, v: &DVector<f64>, span: (f64, f64)| {
            simulate(&scene, q, v, span, &SimulateOptions::default()).expect("runs")
        };
        let (q, v) = (dvector![-1.0], dvector![0.0]);
        let end = contact + 1.0;
        let whole = go(&q, &v, (0.0, end));
        assert_eq!(whole.impacts().len(), 1);
        let found = whole.impacts()[0].time;
        assert!((found - contact).abs() < 4e-15);
        for exponent in 9..16 {
            for cut in [-1.0, 0.0, 1.0].map(|s| found * (1.0 + s * 10f64.powi(-exponent))) {
                let label = format!("contact {found}, cut {:e} later", cut - found);
                let first = go(&q, &v, (0.0, cut));
                assert_eq!(first.impacts().len(), usize::from(found <= cut), "{label}");
                let (q1, v1) = first.last();
                let rest = go(q1, v1, (cut, end));
                let count = first.impacts().len() + rest.impacts().len();
                assert_eq!(count, 1, "{label}");
                let impact = first.impacts().iter().chain(rest.impacts()).next();
                let late = impact.map(|i| i.time - found).expect("one");
                // A start whose gap is within rounding, 1e-13 of the size of its terms, is on the stop.
                assert!(late.abs() < 4e-13, "{label}: {late:e} late");
                assert!((rest.last().0 - whole.last().0).amax() < 1e-12, "{label}");
                assert!((rest.last().1 - whole.last().1).amax() < 1e-12, "{label}");
            }
        }
    }
}

#[test]
fn both_sides_of_an_impact_can_be_asked_for() {
    let run = run(&ball(0.5), &[1.0], &[0.0], 3.0, &SimulateOptions::default());
    let impact = run.impacts()[0];
    let (_, before) = run.state(impact.time, ImpactSide::Before).expect("kept");
    let (q, after) = run.state(impact.time, ImpactSide::After).expect("kept");
    assert!(
        (before[0] + impact.approach).abs() < 1e-14
            && (after[0] - impact.departure).abs() < 1e-14
            && q[0].abs() < 1e-15
    );
    assert!(run.state(3.1, ImpactSide::After).is_err());
    let sampled = SimulateOptions {
        t_eval: Some(vec![0.0, impact.time, 2.0]),
        keep: Keep::Final,
        ..Default::default()
    };
    let run = crate::scenes::run(&ball(0.5), &[1.0], &[0.0], 2.0, &sampled);
    let (times, _, v) = run.samples().expect("asked for");
    assert_eq!(times.len(), 3);
    assert!((v[1] - impact.departure).abs() < 1e-14);
    assert!(run.impacts().is_empty() && run.state(1.0, ImpactSide::After).is_err());
}

#[test]
fn starts_on_and_in_a_stop() {
    let scene = ball(0.5);
    let go = |q: f64, v: f64| {
        simulate(
            &scene,
            &dvector![q],
            &dvector![v],
            (0.0, 1.0),
            &SimulateOptions::default(),
        )
    };
    assert!(
        go(-0.1, 0.0)
            .expect_err("inside")
            .to_string()
            .contains("inside stop 0")
    );
    let run = go(0.0, -1.0).expect("an impact at the start");
    assert_eq!(run.impacts()[0].time, 0.0);
    assert!((run.impacts()[0].approach - 1.0).abs() < 1e-15);
    let run = go(0.0, 1.0).expect("leaves");
    assert!(run.impacts().is_empty() || run.impacts()[0].time > 0.9);
    let rest = go(0.0, 0.0).expect("rests");
    assert_eq!((rest.status(), rest.impacts().len()), (Status::Finished, 0));
    assert_eq!(rest.segments().expect("kept")[0].kind, SegmentKind::Stick);
}

#[test]
fn flights_do_not_depend_on_how_they_are_cut_nor_on_the_origin_of_time() {
    let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let (q, v) = (dvector![0.02, -0.1], dvector![0.0, 0.3]);
    let whole = simulate(&scene, &q, &v, (0.0, 40.0), &SimulateOptions::default()).expect("runs");
    let half = simulate(&scene, &q, &v, (0.0, 17.3), &SimulateOptions::default()).expect("runs");
    let (q1, v1): (DVector<f64>, DVector<f64>) = (half.last().0.clone(), half.last().1.clone());
    let rest = simulate(&scene, &q1, &v1, (17.3, 40.0), &SimulateOptions::default()).expect("runs");
    assert!((whole.last().0 - rest.last().0).amax() < 1e-11);
    assert_eq!(
        whole.impacts().len(),
        half.impacts().len() + rest.impacts().len()
    );
    // A billion periods later, with the phase that a time in doubles has there.
    let t = 1e9 * scene.period().expect("forced");
    let later = simulate(&scene, &q, &v, (t, t + 40.0), &SimulateOptions::default()).expect("runs");
    let phase = {
        let exact = vibroimpact::simulate(&scene, &q, &v, (t, t), &SimulateOptions::default())
            .expect("runs");
        assert_eq!(exact.stats().n_impacts, 0);
        (1.5 * t) % TAU
    };
    let same = simulate(
        &scene
            .replace(Parameter::Phase.change(phase))
            .expect("valid"),
        &q,
        &v,
        (0.0, 40.0),
        &SimulateOptions::default(),
    )
    .expect("runs");
    assert!((later.last().0 - same.last().0).amax() < 1e-5);
}

#[test]
fn every_touch_within_rounding_is_listed_wherever_the_steps_fall() {
    // cos(t - phase) below a stop within rounding of its amplitude: a touch at every peak, at phase + 2 pi k.
    let stop = upper(0, 1.0 + 4.0 * f64::EPSILON, 0.8);
    let scene = oscillator(0.0, Forcing::Unforced, [stop]);
    for k in 0..4000 {
        let phase = 0.3 + 1e-3 * f64::from(k);
        let options = SimulateOptions {
            solver: Solver {
                rtol: 1e-10 * (1.0 + f64::from(k % 10)),
                ..Solver::default()
            },
            keep: vibroimpact::Keep::Impacts,
            ..Default::default()
        };
        let (q, v) = (dvector![phase.cos()], dvector![phase.sin()]);
        let run = simulate(&scene, &q, &v, (0.0, 20.0), &options).expect("runs");
        let peaks = ((20.0 - phase) / std::f64::consts::TAU).floor() + 1.0;
        assert_eq!(run.grazes().len() as f64, peaks, "phase {phase}");
        for (i, graze) in run.grazes().iter().enumerate() {
            let time = phase + std::f64::consts::TAU * i as f64;
            assert!((graze.time - time).abs() < 1e-6 && graze.depth.abs() < 1e-14);
        }
    }
}

#[test]
fn a_load_on_what_grows_is_followed_to_the_largest_numbers() {
    // y'' - c y' + k y = 1 from rest: (e^(c t) - 1 - c t)/c^2 for k = 0, and next to that for the least k.
    let c = 0.57;
    for k in [0.0, 1e-30, -1e-30, 1e-200] {
        let scene = scene(
            loaded(unit_mass(-c, k), &[1.0]),
            Forcing::Unforced,
            [] as [Stop; 0],
        );
        for end in [1e-3, 1.0, 20.0, 64.0, 65.0, 100.0, 300.0, 600.0] {
            let (q, v) = (dvector![0.0], dvector![0.0]);
            let run = simulate(&scene, &q, &v, (0.0, end), &SimulateOptions::default());
            let run = run.expect("runs");
            let x = c * end;
            // Where the closed form cancels, its series.
            let series = 0.5 + x / 6.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0 * (1.0 + x / 6.0)));
            let closed = (x.exp_m1() - x) / (x * x);
            let wanted = end * end * if x < 1e-2 { series } else { closed };
            let off = (run.last().0[0] / wanted - 1.0).abs();
            assert!(
                off < 1e-12,
                "{k} {end}: {off:e} {:e} {wanted:e}",
                run.last().0[0]
            );
        }
    }
}

/// `x'' = x`: of 1e-200 at rest there is `1e-200 cosh 800 = 1e147` after 800, of nothing nothing, though `e^800` is no double.
#[test]
fn what_the_motion_does_not_hold_does_not_grow() {
    let run = |stops: Vec<Stop>, start: f64| {
        let scene = scene(unit_mass(0.0, -1.0), Forcing::Unforced, stops);
        let options = SimulateOptions::default();
        simulate(
            &scene,
            &dvector![start],
            &dvector![0.0],
            (0.0, 800.0),
            &options,
        )
    };
    let end = 1e-200 * (400.0_f64.exp() / 2.0) * 400.0_f64.exp();
    for stops in [vec![], vec![upper(0, 1e300, 0.5)]] {
        for (start, end) in [(0.0, 0.0), (1e-200, end)] {
            let found = run(stops.clone(), start).expect("fits").last().0[0];
            assert!((found - end).abs() <= 1e-12 * end, "{found:e} {end:e}");
        }
    }
    let grown = run(vec![], 1.0).expect_err("overflows").to_string();
    assert!(grown.contains("beyond the largest number"), "{grown}");
}

//! Impacts that accumulate and lasting contact, against closed forms, for exact and stepped flights (theory 9).

use crate::scenes::{
    BOTH, ball, harmonic, linear, loaded, lower, oscillator, run, scene, shaken_ball, upper, with,
};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use std::f64::consts::PI;
use vibroimpact::{
    DoublePendulum, Forcing, Harmonic, Method, Motion, Reaction, Scene, Segment, SegmentKind, Side,
    SimulateOptions, Solver, Status, Trajectory, Wall, WallSide, nalgebra, simulate,
};

fn of_kind(run: &Trajectory, kind: SegmentKind) -> Vec<Segment> {
    let segments = run.segments().expect("kept");
    segments.into_iter().filter(|s| s.kind == kind).collect()
}

#[test]
fn a_run_that_ends_among_accumulating_impacts_ends_at_its_time() {
    // Beside the ball another body goes on at unit speed.
    let system = loaded(
        linear(dvector![1.0, 1.0], DVector::zeros(2), DVector::zeros(2)),
        &[1.0, 0.0],
    );
    let stop = upper(dvector![1.0, 0.0], 0.0, 0.9);
    let scene = scene(system, Forcing::Unforced, [stop]);
    for method in [Method::Exact, Method::Rk45, Method::Dop853, Method::Radau] {
        let run = |end: f64| {
            let (q0, v0) = (dvector![-0.5, 0.0], dvector![0.0, 1.0]);
            simulate(&scene, &q0, &v0, (0.0, end), &with(method, 1e-9)).expect("runs")
        };
        let whole = of_kind(&run(60.0), SegmentKind::Chatter)[0];
        for part in (1..400).map(|k| f64::from(k) / 400.0) {
            let end = whole.start + part * (whole.end - whole.start);
            let cut = run(end);
            let (q, v) = cut.last();
            assert_eq!((cut.t_end(), cut.status()), (end, Status::Finished));
            assert!((q[1] - end).abs() < 1e-12 && (v[1] - 1.0).abs() < 1e-13);
            assert_eq!(of_kind(&cut, SegmentKind::Chatter)[0].end, end);
        }
    }
}

#[test]
fn a_bouncing_ball_comes_to_rest_at_its_closed_form_time() {
    for method in BOTH {
        for e in [0.5, 0.9, 0.99] {
            let fall = 2f64.sqrt();
            let end = fall * (1.0 + 2.0 * e / (1.0 - e));
            let run = run(&ball(e), &[1.0], &[0.0], 1.5 * end, &with(method, 1e-9));
            assert_eq!(run.status(), Status::Finished, "{}", run.message());
            let chatter = of_kind(&run, SegmentKind::Chatter);
            let stick = of_kind(&run, SegmentKind::Stick);
            assert_eq!((chatter.len(), stick.len()), (1, 1));
            assert!((chatter[0].end / end - 1.0).abs() < 1e-12, "{method:?} {e}");
            assert!((stick[0].start / end - 1.0).abs() < 1e-12);
            assert_eq!((run.last().0[0], run.last().1[0]), (0.0, 0.0));
            if e == 0.5 {
                assert!(
                    (12..=24).contains(&run.impacts().len()),
                    "{}",
                    run.impacts().len()
                );
            }
        }
    }
}

#[test]
fn flights_of_a_ball_are_found_at_once() {
    for rtol in [1e-3, 1e-9, 1e-12] {
        let options = with(Method::Exact, rtol);
        let (q0, v0) = (dvector![1.0], dvector![0.0]);
        let run = simulate(&ball(0.9), &q0, &v0, (0.0, 40.0), &options).expect("runs");
        let stats = run.stats();
        assert!(stats.n_gap_evaluations <= 4 * stats.n_flights, "{stats:?}");
    }
}

#[test]
fn the_impacts_recorded_before_rest_grow_as_the_logarithm_of_the_tolerance() {
    let count = |rtol: f64| {
        let options = SimulateOptions {
            solver: Solver {
                atol: Some(1e-3 * rtol),
                ..with(Method::Exact, rtol).solver
            },
            ..with(Method::Exact, rtol)
        };
        let run = run(&ball(0.7), &[1.0], &[0.0], 20.0, &options);
        run.impacts().len() as f64
    };
    // The speed at entry goes as the root of the tolerance: (1/2) ln(100)/ln(1/e) impacts more for two digits.
    let more = 0.5 * 100f64.ln() / -(0.7f64.ln());
    for rtol in [1e-4, 1e-6, 1e-8, 1e-10] {
        assert!((count(0.01 * rtol) - count(rtol) - more).abs() < 1.5);
    }
}

#[test]
fn a_plastic_ball_leaves_a_shaken_table_when_the_table_falls_away() {
    // Held while a cos(t) <= 1; let go when it exceeds 1, at t = 2 pi - arccos(1/a).
    for method in BOTH {
        let shake = 1.2f64;
        let run = run(
            &shaken_ball(0.0, shake, PI),
            &[0.0],
            &[0.0],
            12.0,
            &with(method, 1e-10),
        );
        let stick = of_kind(&run, SegmentKind::Stick);
        let release = PI - (1.0 / shake).acos();
        assert_eq!(stick[0].start, 0.0);
        assert!(
            (stick[0].end - release).abs() < 1e-9,
            "{method:?} {} {release}",
            stick[0].end
        );
        // Then it flies: q = -s^2/2 + a (cos-free motion), integrated in closed form from the release.
        let t = release + 0.5;
        let a = |t: f64| -shake * t.cos();
        let (q, v) = run.state(t, vibroimpact::ImpactSide::After).expect("kept");
        let s = t - release;
        let speed = -s - shake * (t.sin() - release.sin());
        let height = -0.5 * s * s + shake * (t.cos() - release.cos()) + shake * release.sin() * s;
        assert!((a(release) - 1.0).abs() < 1e-12);
        assert!((v[0] - speed).abs() < 1e-8 && (q[0] - height).abs() < 1e-8);
        assert!(
            run.impacts()
                .iter()
                .all(|i| i.departure == 0.0 || i.departure.abs() < 1e-12)
        );
    }
}

/// Two masses coupled by inertia and springs, soft forcing: chatter and lasting contact of one stop.
fn pair(reaction: &Reaction) -> Scene {
    let system = linear(
        dmatrix![2.0, 0.5; 0.5, 1.0],
        dmatrix![0.1, 0.0; 0.0, 0.2],
        dmatrix![3.0, -1.0; -1.0, 2.0],
    );
    let stop = upper(0, 0.1, 0.5)
        .with_reaction(reaction.clone())
        .expect("valid");
    scene(system, harmonic(&[1.0, 0.5], 0.3, 0.0), [stop])
}

#[test]
fn exact_and_stepped_flights_agree_through_chatter_and_contact() {
    for reaction in [Reaction::Inertia, Reaction::Coordinate] {
        let scene = pair(&reaction);
        let run = |method| run(&scene, &[0.0; 2], &[0.0; 2], 60.0, &with(method, 1e-10));
        let (exact, stepped) = (run(Method::Exact), run(Method::Rk45));
        assert_eq!(exact.status(), Status::Finished, "{}", exact.message());
        let (a, b) = (
            of_kind(&exact, SegmentKind::Stick),
            of_kind(&stepped, SegmentKind::Stick),
        );
        assert!(a.len() >= 2 && a.len() == b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!((a.start - b.start).abs() < 1e-6 && (a.end - b.end).abs() < 1e-6);
        }
        assert!((exact.last().0 - stepped.last().0).amax() < 1e-7);
        assert!((exact.last().1 - stepped.last().1).amax() < 1e-7);
    }
}

#[test]
fn while_held_the_gap_is_zero_and_the_force_follows_the_law() {
    let scene = pair(&Reaction::Inertia);
    for method in BOTH {
        let run = run(&scene, &[0.0; 2], &[0.0; 2], 30.0, &with(method, 1e-10));
        for held in of_kind(&run, SegmentKind::Stick) {
            for k in 0..=20 {
                let t = held.start + (held.end - held.start) * f64::from(k) / 20.0;
                let (q, v) = run.state(t, vibroimpact::ImpactSide::Before).expect("kept");
                if k > 0 {
                    assert!(
                        (q[0] - 0.1).abs() < 1e-12 && v[0].abs() < 1e-11,
                        "{method:?} {t}"
                    );
                }
                // The force that would hold it: L = n.a_free/(n.b), by hand, is compressive.
                let f = dvector![(0.3 * t).cos(), 0.5 * (0.3 * t).cos()];
                let mass = dmatrix![2.0, 0.5; 0.5, 1.0];
                let rest =
                    f - dmatrix![0.1, 0.0; 0.0, 0.2] * &v - dmatrix![3.0, -1.0; -1.0, 2.0] * &q;
                let inverse: DMatrix<f64> = mass.try_inverse().expect("regular");
                let free: DVector<f64> = &inverse * rest;
                assert!(free[0] / inverse[(0, 0)] > -1e-6, "{method:?} {t}");
            }
        }
    }
}

#[test]
fn halving_the_tolerance_of_entry_changes_nothing_beyond_it() {
    let scene = pair(&Reaction::Coordinate);
    let end = |rtol| {
        let run = run(
            &scene,
            &[0.0; 2],
            &[0.0; 2],
            60.0,
            &with(Method::Exact, rtol),
        );
        run.last().0.clone()
    };
    let best = end(1e-13);
    for rtol in [1e-5, 1e-7, 1e-9] {
        assert!((end(rtol) - &best).amax() < 30.0 * rtol, "{rtol}");
    }
}

#[test]
fn a_run_cut_inside_a_contact_goes_on_as_one() {
    let scene = shaken_ball(0.4, 1.2, 0.0);
    for method in BOTH {
        let options = with(method, 1e-10);
        let whole = run(&scene, &[0.3], &[0.0], 20.0, &options);
        let held = of_kind(&whole, SegmentKind::Stick)[0];
        let cut = 0.5 * (held.start + held.end);
        let first = run(&scene, &[0.3], &[0.0], cut, &options);
        let (q, v) = first.last();
        let rest = simulate(&scene, q, v, (cut, 20.0), &options).expect("runs");
        assert_eq!(of_kind(&rest, SegmentKind::Stick)[0].start, cut);
        assert!((rest.last().0 - whole.last().0).amax() < 1e-8);
    }
}

#[test]
fn what_is_pressed_late_is_held_in_complex_modes_too() {
    // Three bodies in a row that nothing holds; the third rests on a stop, and the first, on a dashpot, begins to move: the third is
    // pressed by the fifth derivative of its place.
    let springs = dmatrix![
        0.858_124_480_709_842_7, -0.858_124_480_709_842_7, 0.0;
        -0.858_124_480_709_842_7, 1.305_797_378_039_217, -0.447_672_897_329_374_1;
        0.0, -0.447_672_897_329_374_1, 0.447_672_897_329_374_1];
    let dashpot = dvector![1.071_526_612_363_991_5, 0.0, 0.0];
    let system = linear(DVector::from_element(3, 1.0), dashpot, springs);
    let force = dvector![(-0.170_613_178_837_506_15).into(), 0.0.into(), 0.0.into()];
    let force =
        Harmonic::new(force, 0.901_756_213_019_644_4, -0.309_393_093_218_078_2).expect("valid");
    let scene = scene(system, force, [upper(2, 0.0, 1.0)]);
    let (q0, v0) = (
        dvector![0.0, 0.0, 0.0],
        dvector![0.342_733_574_214_197_5, 0.0, 0.0],
    );
    for method in BOTH {
        let run = simulate(&scene, &q0, &v0, (0.0, 8.0), &with(method, 1e-12)).expect("valid");
        assert_eq!(run.impacts().len(), 0, "{method:?}");
        let held = of_kind(&run, SegmentKind::Stick);
        assert!(
            held[0].start == 0.0 && held[0].end == 8.0,
            "{method:?}: {held:?}"
        );
    }
}

#[test]
fn nothing_holds_what_has_no_force_and_nothing_lets_go_at_rest() {
    // An equilibrium exactly on the stop: no force, no acceleration; it stays for ever.
    let scene = oscillator(0.1, Forcing::Unforced, [upper(0, 0.0, 0.5)]);
    for method in BOTH {
        let run = run(&scene, &[0.0], &[0.0], 10.0, &with(method, 1e-9));
        assert_eq!(run.status(), Status::Finished, "{}", run.message());
        assert_eq!((run.last().0[0], run.last().1[0]), (0.0, 0.0));
        assert!(run.impacts().is_empty());
    }
}

#[test]
fn a_pendulum_comes_to_rest_against_a_wall_that_it_leans_on() {
    // The wall stands left of the hanging position's bob: the second bob leans on it with its weight.
    let pendulum = DoublePendulum::new(1.0, 1.0, (0.4, 0.4)).expect("valid");
    let wall = Wall::new(1, -0.3, 0.5, WallSide::Right).expect("valid");
    let scene = scene(pendulum, Forcing::Unforced, [wall]);
    let run = run(
        &scene,
        &[-0.5, -0.5],
        &[0.0; 2],
        200.0,
        &SimulateOptions::default(),
    );
    assert_eq!(run.status(), Status::Finished, "{}", run.message());
    let (q, v) = run.last();
    assert!((q[0].sin() + q[1].sin() + 0.3).abs() < 1e-10 && v.amax() < 1e-8);
    // Equilibrium with a horizontal force L on the second bob: tan q1 = -L/2, tan q2 = -L (unit weights).
    assert!((q[1].tan() - 2.0 * q[0].tan()).abs() < 1e-7);
    assert_eq!(
        of_kind(&run, SegmentKind::Stick).last().expect("held").end,
        200.0
    );
}

/// Two equal masses that a stiff spring couples, one of which bounces to rest on a stop: at a loose tolerance the margin of a
/// stop is wide, and a step may begin behind a stop that it leaves again.
#[test]
fn time_goes_forward_however_wide_the_margin() {
    let stiffness = dmatrix![10_001.0, -10_000.0; -10_000.0, 10_001.0];
    let system = linear(dvector![1.0, 1.0], &stiffness * 0.02, stiffness);
    let system = loaded(system, &[0.3, 0.0]);
    let force = harmonic(&[1.5, 0.0], 0.7, 0.0);
    let scene = scene(system, force, [upper(1, 0.3, 0.7)]);
    for rtol in [1e-2, 1e-3, 1e-4, 1e-5] {
        let (q0, v0) = (dvector![0.0, 0.0], dvector![0.3, 0.3]);
        let run = simulate(&scene, &q0, &v0, (0.0, 11.0), &with(Method::Rk45, rtol));
        let run = run.expect("runs");
        for segment in run.segments().expect("kept") {
            assert!(segment.end >= segment.start, "{rtol:e}: {segment:?}");
        }
        let times: Vec<f64> = run.impacts().iter().map(|impact| impact.time).collect();
        assert!(times.is_sorted(), "{rtol:e}: {times:?}");
    }
}

/// A mass that a damped one shakes through a spring lands on a stop without restitution. Its modes are complex: a speed summed
/// from them has terms other than the one that an impact takes away, and what rounding leaves of it is not another impact.
#[test]
fn an_impact_without_restitution_is_one_impact_in_complex_modes() {
    for (mass, k, damping) in [
        (0.01, 10.0, 0.1),
        (0.01, 1e3, 0.1),
        (0.01, 1e3, 1.0),
        (100.0, 1.0, 0.1),
        (100.0, 10.0, 0.1),
        (100.0, 10.0, 1.0),
    ] {
        let system = linear(
            dvector![1.0, mass],
            dmatrix![damping, 0.0; 0.0, 0.0],
            dmatrix![k + 1.0, -k; -k, k + 2.0],
        );
        let system = loaded(system, &[0.0, -1.0]);
        let force = harmonic(&[1.5, 0.0], 1.0, 0.0);
        let scene = scene(system, force, [lower(1, 0.0, 0.0)]);
        let label = format!("{mass} {k} {damping}");
        let (q0, v0) = (dvector![0.3, 0.3], dvector![0.0, 0.0]);
        let [exact, stepped] = BOTH.map(|method| {
            let run = simulate(&scene, &q0, &v0, (0.0, 25.0), &with(method, 1e-11));
            run.expect("runs")
        });
        assert_eq!(
            exact.status(),
            Status::Finished,
            "{label}: {}",
            exact.message()
        );
        let mut time = f64::NEG_INFINITY;
        for impact in exact.impacts() {
            assert!(
                impact.approach > 0.0 && impact.time > time,
                "{label}: {impact:?}"
            );
            time = impact.time;
        }
        assert_eq!(exact.impacts().len(), stepped.impacts().len(), "{label}");
        let error = (exact.last().0 - stepped.last().0).amax();
        assert!(error < 1e-7, "{label}: {error:e}");
    }
}

/// A light mass on a stiff spring that a shaken mass holds: on letting go of its stop it flies in waves, all of them within the
/// margin, and the contact is the zero before which the gap was last open.
#[test]
fn a_wavy_flight_within_the_margin_ends_at_a_contact() {
    let (mass, k) = (0.1, 1e6);
    let system = linear(
        dvector![1.0, mass],
        dmatrix![1.0, 0.0; 0.0, 0.0],
        dmatrix![k + 1.0, -k; -k, k + 2.0],
    );
    let system = loaded(system, &[0.0, -1.0]);
    let force = harmonic(&[1.5, 0.0], 1.0, 0.0);
    let scene = scene(system, force, [lower(1, 0.0, 0.7)]);
    let none = dvector![0.0, 0.0];
    let run = simulate(
        &scene,
        &none,
        &none,
        (0.0, 60.0),
        &SimulateOptions::default(),
    );
    let run = run.expect("runs");
    assert_eq!(run.status(), Status::Finished, "{}", run.message());
    for impact in run.impacts() {
        let depth = run
            .state(impact.time, vibroimpact::ImpactSide::Before)
            .expect("kept")
            .0[1];
        assert!(
            depth.abs() < 1e-13 && impact.approach > 0.0,
            "{impact:?}: {depth:e}"
        );
    }
}

#[test]
fn what_does_not_strike_moves_on_while_impacts_accumulate() {
    // Two oscillators of their own; the first one's impacts lose all but a thousandth of their speed, and accumulate over a time in
    // which the other goes a long way.
    let (growth, stiffness) = (0.003, 0.2f64);
    let system = linear(
        dvector![1.0, 1.0],
        dvector![-2.0 * growth, -2.0 * growth],
        dvector![2.0, stiffness],
    );
    let stop = upper(0, 0.0, 0.001);
    let stops = [stop.on_side(Side::Lower)];
    let scene = scene(system, Forcing::Unforced, stops);
    let w = (stiffness - growth * growth).sqrt();
    for method in BOTH {
        let start = (&dvector![0.4, 0.4], &dvector![-0.4, 0.4]);
        let run = simulate(&scene, start.0, start.1, (0.0, 20.0), &with(method, 1e-9));
        let run = run.expect("runs");
        let (q, _) = run.last();
        let (sin, cos) = (w * 20.0).sin_cos();
        let wanted = (growth * 20.0).exp() * (0.4 * cos + (0.4 - growth * 0.4) / w * sin);
        assert!((q[1] - wanted).abs() < 1e-6, "{method:?} {} {wanted}", q[1]);
    }
}

#[test]
fn impacts_beside_a_stop_that_is_held_come_to_rest_when_those_of_one_alone_do() {
    // A mass lies on the ground and a second one bounces on it: while the first is held the second is a ball on a floor, dropped from 1.
    for (e, method) in [
        (0.5, Method::Exact),
        (0.9, Method::Exact),
        (0.99, Method::Exact),
        (0.5, Method::Dop853),
    ] {
        let rest = 2f64.sqrt() * (1.0 + 2.0 * e / (1.0 - e));
        let masses = linear(dvector![1.0, 1.0], DVector::zeros(2), DVector::zeros(2));
        let floor = lower(0, 0.0, e);
        let on = lower(dvector![-1.0, 1.0], 0.0, e);
        let scene = scene(
            loaded(masses, &[-1.0, -1.0]),
            Forcing::Unforced,
            [floor, on],
        );
        let run = run(
            &scene,
            &[0.0, 1.0],
            &[0.0, 0.0],
            1.1 * rest,
            &with(method, 1e-9),
        );
        let [chatter] = of_kind(&run, SegmentKind::Chatter)[..] else {
            panic!("one stop bounces")
        };
        let allowed = if method == Method::Exact { 1e-10 } else { 1e-6 };
        assert!(
            (chatter.end / rest - 1.0).abs() < allowed,
            "{e}: {:e}",
            chatter.end - rest
        );
        assert!(chatter.stop == Some(1) && chatter.end > chatter.start);
        // Held before it, beside it and behind it: the ground carries both, all the time, in the mean.
        let held = of_kind(&run, SegmentKind::Stick);
        let ground = held
            .iter()
            .filter(|s| s.stop == Some(0) && s.start >= chatter.start);
        let carried: f64 = ground.clone().map(|s| s.impulse).sum();
        let left = run.span().1 - chatter.start;
        // What it gives at the instant at which the speed of the second is taken away is the segment's that begins there.
        let due = 2.0 * left + chatter.impulse - (chatter.end - chatter.start);
        assert!((carried - due).abs() < 1e-6 * left, "{e}: {carried} {due}");
        assert_eq!(
            ground.map(|s| s.start).fold(f64::INFINITY, f64::min),
            chatter.start
        );
    }
}

#[test]
fn what_lands_where_nothing_pulls_it_stays() {
    // A spring that is relaxed at the stop: behind an impact without restitution everything is rounding.
    for w in [1.0, 2.0, 2.0 * PI, 10.0, 50.0, 1e-3, 1e5] {
        for more in [0.0, 0.3] {
            // A second coordinate, coupled by masses, or not there.
            let mass = DMatrix::from_row_slice(2, 2, &[1.0, more, more, 1.0]);
            let system = linear(mass.clone(), DMatrix::zeros(2, 2), &mass * (w * w));
            let scene = scene(system, Forcing::Unforced, [upper(0, 0.0, 0.0)]);
            let options = SimulateOptions::default();
            let run = run(&scene, &[-1.0, 0.0], &[0.0, 0.0], 40.0 / w, &options);
            assert_eq!(run.impacts().len(), 1, "{w} {more}");
            let (q, v) = run.last();
            assert!(
                q[0].abs() < 1e-14 && v[0].abs() < 1e-14 * w,
                "{w} {more}: {q} {v}"
            );
            // Beside another motion whether it is held, by no force, is rounding.
            if more == 0.0 {
                let [landed] = of_kind(&run, SegmentKind::Stick)[..] else {
                    panic!("{w}: {:?}", run.segments())
                };
                let off = landed.start * w / (PI / 2.0) - 1.0;
                assert!(off.abs() < 1e-13, "{w}: {off:e}");
                assert_eq!(landed.end, 40.0 / w);
            }
        }
    }
}

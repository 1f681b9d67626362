//! The two sides of an impact, wherever in a run it falls: at its start, inside, at its last instant; asked for by
//! `Trajectory::state`, by `t_eval` and by the points for drawing; as run and as restored.

use crate::scenes::{BOTH, ball, harmonic, oscillator, scene, unit_mass, upper, with};
use nalgebra::{DVector, dvector};
use vibroimpact::{
    BaseMotion, DoublePendulum, Forcing, ImpactSide, Keep, Method, Motion, SegmentKind, Side,
    SimulateOptions, Status, Trajectory, Wall, WallSide, simulate,
};

const E: f64 = 0.5;

fn dropped(height: f64, speed: f64, end: f64, options: &SimulateOptions) -> Trajectory {
    let (q0, v0) = (dvector![height], dvector![speed]);
    simulate(&ball(E), &q0, &v0, (0.0, end), options).expect("runs")
}

/// The run and what becomes of it when it is saved and made again.
fn both(run: Trajectory) -> [Trajectory; 2] {
    let restored = Trajectory::restore(run.scene(), run.save()).expect("saved");
    [run, restored]
}

fn speed(run: &Trajectory, t: f64, side: ImpactSide) -> f64 {
    run.state(t, side).expect("kept").1[0]
}

/// Both sides of every impact are those of its record.
fn assert_sides(run: &Trajectory) {
    for impact in run.impacts() {
        let (before, after) = (
            speed(run, impact.time, ImpactSide::Before),
            speed(run, impact.time, ImpactSide::After),
        );
        assert!(before * after <= 0.0, "{impact:?}");
        assert!(
            (before.abs() - impact.approach).abs() < 1e-9,
            "{impact:?} {before}"
        );
        assert!(
            (after.abs() - impact.departure).abs() < 1e-9,
            "{impact:?} {after}"
        );
    }
}

#[test]
fn an_impact_that_ends_a_run_has_two_sides() {
    for method in BOTH {
        for max_impacts in [1, 2, 3] {
            let ended = SimulateOptions {
                max_impacts: Some(max_impacts),
                ..with(method, 1e-9)
            };
            for run in both(dropped(1.0, 0.0, 100.0, &ended)) {
                assert_eq!(run.status(), Status::MaxImpacts);
                assert_sides(&run);
                let (_, end) = run.span();
                assert_eq!(end, run.impacts()[max_impacts - 1].time);
                assert_eq!(speed(&run, end, ImpactSide::After), run.last().1[0]);
                let (times, _, v) = run.samples().expect("kept");
                let m = times.len();
                assert_eq!(times[m - 2..], [end, end]);
                assert_eq!(v[(m - 1, 0)], run.last().1[0]);
                assert!((v[(m - 1, 0)] + E * v[(m - 2, 0)]).abs() < 1e-9);
                // The ledger has the loss of the last impact: e^2 of the energy 1 is left after each.
                let left = E.powi(2).powi(i32::try_from(max_impacts).expect("few"));
                let energy = run.energy().expect("kept");
                assert!((energy.impact_loss[m - 1] - (1.0 - left)).abs() < 1e-8);
            }
        }
    }
}

#[test]
fn a_flight_of_no_length_is_a_side_and_no_segment() {
    for method in BOTH {
        let ended = SimulateOptions {
            max_impacts: Some(3),
            ..with(method, 1e-9)
        };
        let run = dropped(0.0, -1.0, 100.0, &ended);
        let segments = run.segments().expect("kept");
        assert_eq!(segments.len(), 2);
        assert!(
            segments
                .iter()
                .all(|s| s.kind == SegmentKind::Flight && s.end > s.start)
        );
        assert_eq!(segments[0].end, segments[1].start);
    }
}

#[test]
fn an_impact_at_the_start_has_two_sides() {
    for method in BOTH {
        for run in both(dropped(0.0, -1.0, 0.5, &with(method, 1e-9))) {
            assert_eq!(run.impacts()[0].time, 0.0);
            assert_sides(&run);
            let (times, _, v) = run.samples().expect("kept");
            // One point for each side.
            assert_eq!(times.iter().filter(|&&t| t == 0.0).count(), 2);
            assert_eq!(v.as_slice()[..2], [-1.0, E]);
        }
    }
}

#[test]
fn the_sides_at_the_ends_do_not_depend_on_the_rounding_of_a_time_in_periods() {
    let scene = oscillator(0.1, harmonic(&[0.3], 0.7, 0.0), [upper(0, 0.0, E)]);
    for method in BOTH {
        for k in 0..100 {
            let t0 = 0.1 * f64::from(k);
            let run = |end: f64, max_impacts: Option<usize>, t_eval: Option<Vec<f64>>| {
                let asked = SimulateOptions {
                    max_impacts,
                    t_eval,
                    ..with(method, 1e-9)
                };
                simulate(&scene, &dvector![0.0], &dvector![1.0], (t0, end), &asked).expect("runs")
            };
            let known = run(t0 + 100.0, Some(3), None);
            let end = known.span().1;
            let sampled = run(t0 + 100.0, Some(3), Some(vec![t0, end]));
            for run in both(known).into_iter().chain(both(sampled)) {
                assert_sides(&run);
                assert!(
                    (speed(&run, t0, ImpactSide::Before) - 1.0).abs() < 1e-15,
                    "{t0}"
                );
                assert!(
                    (speed(&run, t0, ImpactSide::After) + E).abs() < 1e-15,
                    "{t0}"
                );
                let (times, _, v) = run.samples().expect("kept");
                let m = times.len();
                assert!(
                    times.is_sorted() && times[0] == t0 && times[m - 1] == end,
                    "{t0}"
                );
                assert!((v[(m - 1, 0)] - run.last().1[0]).abs() < 1e-15, "{t0}");
                assert!(m > 2 || (v[(0, 0)] + E).abs() < 1e-15, "{t0}");
                assert_eq!(run.energy().expect("kept").balance.len(), m);
            }
            // A run that ends with the third impact has it, or, in steps, stops short of it by rounding.
            let cut = run(end, None, Some(vec![end]));
            let count = cut.stats().n_impacts;
            assert!(
                count == 3 || (count == 2 && method == Method::Rk45),
                "{t0}: {count}"
            );
            assert!(cut.impacts().iter().all(|i| i.time <= end));
            let (_, _, v) = cut.samples().expect("asked for");
            assert!((v[(0, 0)] - cut.last().1[0]).abs() < 1e-15, "{t0}");
        }
    }
}

#[test]
fn samples_are_after_an_impact_at_any_instant() {
    for method in BOTH {
        for keep in [Keep::Motion, Keep::Impacts, Keep::Final] {
            let known = dropped(0.0, -1.0, 1.2, &with(method, 1e-9));
            let times: Vec<f64> = known.impacts().iter().map(|i| i.time).collect();
            assert_eq!(times.len(), 2);
            let last = times[1];
            for (end, max_impacts) in [(1.2, None), (last, None), (1.2, Some(2))] {
                let sampled = SimulateOptions {
                    t_eval: Some(times.clone()),
                    keep,
                    max_impacts,
                    ..with(method, 1e-9)
                };
                let run = dropped(0.0, -1.0, end, &sampled);
                let (t, q, v) = run.samples().expect("asked for");
                let case = format!("{method:?} {keep:?} {end} {max_impacts:?}");
                // A step that ends at the impact may find the gap open by rounding; an exact flight does not.
                let is_struck = run.stats().n_impacts == 2;
                assert!(
                    is_struck || (method == Method::Rk45 && end == last),
                    "{case}"
                );
                let second = if is_struck { E * E } else { -E };
                assert_eq!(t, times, "{case}");
                assert!(q.amax() < 1e-12, "{case}");
                assert!((v[(0, 0)] - E).abs() < 1e-12, "{case}");
                assert!((v[(1, 0)] - second).abs() < 1e-9, "{case}: {v}");
                let is_cut = run.span().1 == last;
                assert!(!is_cut || v[(1, 0)] == run.last().1[0], "{case}");
            }
        }
    }
}

#[test]
fn a_run_that_ends_before_it_flies_has_its_state() {
    for method in BOTH {
        let none = SimulateOptions {
            max_impacts: Some(0),
            t_eval: Some(vec![0.0]),
            ..with(method, 1e-9)
        };
        for (height, before, after) in [(1.0, -1.0, -1.0), (0.0, -1.0, E)] {
            for run in both(dropped(height, -1.0, 1.0, &none)) {
                assert_eq!(run.span(), (0.0, 0.0));
                assert_eq!(speed(&run, 0.0, ImpactSide::Before), before);
                assert_eq!(speed(&run, 0.0, ImpactSide::After), after);
                assert_eq!(run.samples().expect("asked for").2.as_slice(), [after]);
                assert_eq!(run.segments().expect("kept").len(), 1);
            }
        }
    }
}

#[test]
fn a_jam_keeps_the_state_it_ends_in() {
    // A stop on both sides and no room: nothing that pushes keeps both closed.
    let system = unit_mass(0.0, 1.0);
    let stop = || upper(0, 0.0, E);
    let scene = scene(
        system,
        Forcing::Unforced,
        [stop(), stop().on_side(Side::Lower)],
    );
    for method in BOTH {
        let sampled = SimulateOptions {
            t_eval: Some(vec![0.0]),
            ..with(method, 1e-9)
        };
        let run = simulate(&scene, &dvector![0.0], &dvector![1.0], (0.0, 1.0), &sampled);
        for run in both(run.expect("runs")) {
            let (_, end) = run.span();
            let state: (DVector<f64>, DVector<f64>) =
                run.state(end, ImpactSide::After).expect("kept");
            assert_eq!((&state.0, &state.1), run.last());
            assert_eq!(run.samples().expect("asked for").0, [0.0]);
        }
    }
}

#[test]
fn steps_of_a_pendulum_have_both_sides_at_the_ends() {
    let pendulum = DoublePendulum::new(1.0, 2.0, (0.05, 0.02)).expect("valid");
    let base = BaseMotion::new(0.3, 1.2, 0.0).expect("valid");
    let wall = Wall::new(1, 0.0, 0.7, WallSide::Right).expect("valid");
    let scene = scene(pendulum, base, [wall]);
    for method in [Method::Taylor, Method::Rk45] {
        let run = |max_impacts, t_eval| {
            let asked = SimulateOptions {
                max_impacts,
                t_eval,
                ..with(method, 1e-9)
            };
            let (q0, v0) = (dvector![0.0, 0.0], dvector![0.2, 0.5]);
            simulate(&scene, &q0, &v0, (1.3, 50.0), &asked).expect("runs")
        };
        for run in both(run(Some(3), None)) {
            let (start, end) = run.span();
            assert!((run.impacts()[0].time - start).abs() < 1e-15);
            assert_eq!(run.impacts()[2].time, end);
            for impact in run.impacts() {
                let at = |side| {
                    let (q, v) = run.state(impact.time, side).expect("kept");
                    (0..2)
                        .map(|i| q[i].cos() * v[i] * [1.0, 0.5][i])
                        .sum::<f64>()
                };
                assert!((at(ImpactSide::Before) - impact.approach).abs() < 1e-12);
                assert!((at(ImpactSide::After) + impact.departure).abs() < 1e-12);
            }
            let (_, last) = run.state(end, ImpactSide::After).expect("kept");
            assert!((last - run.last().1).amax() < 1e-15);
        }
        let end = run(Some(3), None).span().1;
        let sampled = run(Some(3), Some(vec![1.3, end]));
        let v = sampled.samples().expect("asked for").2;
        assert!((v.row(1).transpose() - sampled.last().1).amax() < 1e-15);
        assert!(v[(0, 0)].is_finite() && v[(0, 1)] < 0.0);
    }
}

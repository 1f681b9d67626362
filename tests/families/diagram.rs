//! Sections and bifurcation diagrams against orbits in closed form, and laws that any diagram obeys.

use crate::scenes::oscillator_at;
use std::f64::consts::TAU;
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Axis, BifurcationDiagram, DiagramOptions, Direction, Forcing, Harmonic, Kind, LinearSystem,
    Method, Motion, OrbitOptions, PaperOptions, Parameter, Pattern, Scene, Section, Side,
    SimulateOptions, Status, Stop, SweepOptions, bifurcation_diagram, paper_scene, periodic_orbits,
    poincare_points, simulate,
};

fn diagram(
    scene: &Scene,
    (parameter, values): (Parameter, &[f64]),
    options: &DiagramOptions,
) -> BifurcationDiagram {
    let axis = Axis::new(parameter, values.iter().copied());
    bifurcation_diagram(scene, &axis, options).expect("a diagram")
}

fn refused(scene: &Scene, values: &[f64], options: &DiagramOptions) -> String {
    let axis = Axis::new(Parameter::ForcingScale, values.iter().copied());
    let error = bifurcation_diagram(scene, &axis, options).expect_err("refused");
    error.to_string()
}

#[test]
fn a_diagram_settles_on_the_orbits_of_the_closed_form() {
    // One impact in each period is stable from the doubling at F = 7.73325782164 on; below the graze at 4.766046580 nothing is hit.
    let (values, after) = ([1.0, 3.0, 7.8, 9.0, 12.0], Section::Impacts(vec![0]));
    let options = DiagramOptions {
        transient: 1500,
        section: after,
        ..DiagramOptions::default()
    };
    let found = diagram(
        &oscillator_at(1.0, 2.4, 1.0),
        (Parameter::ForcingScale, &values),
        &options,
    );
    assert_eq!(found.n_periods, [1; 5]);
    assert_eq!(found.n_impacts, [0, 0, 50, 50, 50]);
    for (k, &force) in values.iter().enumerate() {
        let rows: Vec<usize> = (0..found.index.len())
            .filter(|&i| found.index[i] == k)
            .collect();
        assert_eq!(rows.len(), found.n_impacts[k]);
        if rows.is_empty() {
            assert_eq!(found.pattern[k], Pattern::none());
            continue;
        }
        assert_eq!(found.pattern[k], Pattern::single(0));
        let scene = oscillator_at(force, 2.4, 1.0);
        let orbits =
            periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default()).expect("solved");
        let impact = orbits[0].impacts()[0];
        for i in rows {
            assert!(
                (found.points.speed_before[i] - impact.approach).abs() < 1e-6 * impact.approach
            );
            let apart = (found.points.phase[i] - impact.phase + 3.0).rem_euclid(TAU) - 3.0;
            assert!(apart.abs() < 1e-6, "{apart:e}");
            assert!((found.points.q[(i, 0)] - 1.0).abs() < 1e-9);
        }
    }
    // Beyond the doubling two impacts in two periods; between them chaos.
    let (values, options) = (
        [7.6, 5.0],
        DiagramOptions {
            transient: 3000,
            ..DiagramOptions::default()
        },
    );
    let found = diagram(
        &oscillator_at(1.0, 2.4, 1.0),
        (Parameter::ForcingScale, &values),
        &options,
    );
    assert_eq!(found.parameter, [5.0, 7.6]);
    assert_eq!(found.n_periods, [0, 2]);
    assert_eq!(found.index.len(), 2 * 50);
    assert_eq!(found.pattern[1].instants(), [[0], [0]]);
}

#[test]
fn a_diagram_is_one_run_after_another() {
    let scene = oscillator_at(5.0, 2.4, 1.0);
    let values = [0.9, 1.0, 1.1];
    let phase = Section::Phase(1.3);
    let start = Some((dvector![0.2], dvector![-0.1]));
    let options = DiagramOptions {
        transient: 20,
        periods: 7,
        section: phase,
        start,
        ..DiagramOptions::default()
    };
    let found = diagram(&scene, (Parameter::ForcingScale, &values), &options);
    let (mut q, mut v) = (dvector![0.2], dvector![-0.1]);
    for (k, &factor) in values.iter().enumerate() {
        let scene = scene
            .replace(vibroimpact::Parameter::ForcingScale.change(factor))
            .expect("valid");
        let period = scene.period().expect("forced");
        let run = |q: &DVector<f64>, v: &DVector<f64>, start: f64, end: f64| {
            simulate(
                &scene,
                q,
                v,
                (start * period, end * period),
                &SimulateOptions::default(),
            )
            .expect("a run")
        };
        let transient = run(&q, &v, 0.0, 20.0);
        let seen = run(transient.last().0, transient.last().1, 20.0, 27.0);
        for j in 0..7 {
            let i = 7 * k + j;
            assert_eq!(found.index[i], k);
            let time = (20.0 + 1.3 / TAU + j as f64) * period;
            assert!((found.points.t[i] - time).abs() < 1e-12);
            let (q, _) = seen
                .state(time, vibroimpact::ImpactSide::After)
                .expect("inside");
            assert!((found.points.q[(i, 0)] - q[0]).abs() < 1e-9);
        }
        (q, v) = (seen.last().0.clone(), seen.last().1.clone());
    }
}

#[test]
fn directions_and_threads_change_no_bit() {
    let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let values = [0.9, 0.7, 1.2, 1.0];
    for carry in [true, false] {
        let with = |direction, threads| {
            let sweep = SweepOptions {
                threads: Some(threads),
            };
            let options = DiagramOptions {
                direction,
                carry,
                transient: 30,
                periods: 10,
                sweep,
                ..DiagramOptions::default()
            };
            diagram(&scene, (Parameter::ForcingScale, &values), &options)
        };
        let both = with(Direction::Both, 1);
        assert_eq!(both.parameter, [0.7, 0.9, 1.0, 1.2, 1.2, 1.0, 0.9, 0.7]);
        assert_eq!(
            both.is_up,
            [true, true, true, true, false, false, false, false]
        );
        let bits = |d: &BifurcationDiagram| {
            d.points
                .q
                .iter()
                .chain(&d.points.v)
                .map(|x| x.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&both), bits(&with(Direction::Both, 2)));
        let (up, down) = (with(Direction::Up, 2), with(Direction::Down, 1));
        let parts = [&up, &down].map(|d| d.points.q.column(0).iter().copied().collect::<Vec<_>>());
        assert_eq!(
            both.points.q.column(0).iter().copied().collect::<Vec<_>>(),
            parts.concat()
        );
    }
}

#[test]
fn a_stop_that_moves_over_the_state_takes_it_along() {
    let scene = oscillator_at(0.5, 0.7, 1.0);
    let values = [0.9, 0.2, -0.3, -1.5];
    let options = DiagramOptions {
        direction: Direction::Down,
        ..DiagramOptions::default()
    };
    let found = diagram(&scene, (Parameter::CLEARANCE, &values), &options);
    assert!(
        found
            .status
            .iter()
            .all(|status| *status == Status::Finished)
    );
    for (k, &i) in found.index.iter().enumerate() {
        assert!(found.points.q[(k, 0)] <= found.parameter[i] + 1e-9);
    }
    // At rest at zero, from behind the stop.
    let alone = diagram(
        &scene,
        (Parameter::CLEARANCE, &[-1.5]),
        &DiagramOptions::default(),
    );
    assert_eq!(alone.status, [Status::Finished]);
}

#[test]
fn impacts_that_accumulate_are_one_point() {
    // At rest on the stop for 0.18 of a period; released where the force draws at a quarter turn.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.3, 0.0).expect("valid");
    let scene = Scene::new(system, force, [Stop::new(0, 0.0, 0.8).expect("valid")]).expect("valid");
    let options = DiagramOptions {
        transient: 40,
        periods: 10,
        section: Section::Impacts(vec![]),
        ..DiagramOptions::default()
    };
    let found = diagram(&scene, (Parameter::ForcingScale, &[1.0]), &options);
    assert_eq!(found.n_periods, [1]);
    let at_rest: Vec<usize> = (0..found.index.len())
        .filter(|&i| found.points.speed_before[i] == 0.0)
        .collect();
    assert_eq!(at_rest.len(), 10);
    let released = TAU / 4.0;
    for i in at_rest {
        assert_eq!((found.points.q[(i, 0)], found.points.v[(i, 0)]), (0.0, 0.0));
        let stuck = (released - found.points.phase[i]).rem_euclid(TAU) / TAU;
        assert!((stuck - 0.183_411_669_2).abs() < 1e-6, "{stuck}");
    }
}

#[test]
fn sections_of_an_orbit_and_of_its_motion_are_the_same() {
    let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let options = OrbitOptions {
        n_periods: 2,
        ..OrbitOptions::default()
    };
    let orbit = &periodic_orbits(&scene, &Pattern::single(1), &options).expect("solved")[0];
    let end = 3.0 * orbit.period();
    let run = simulate(
        orbit.scene(),
        &orbit.q0(),
        &orbit.v0(),
        (0.0, end),
        &SimulateOptions::default(),
    )
    .expect("a run");
    for (section, of_orbit, of_run) in [
        (Section::Phase(2.0), 2, 6),
        (Section::Impacts(vec![1]), 1, 3),
    ] {
        let [one, three] = [
            poincare_points(orbit, &section),
            poincare_points(&run, &section),
        ]
        .map(|p| p.expect("looked at"));
        assert_eq!((one.t.len(), three.t.len()), (of_orbit, of_run));
        for i in 0..of_run {
            let off = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
            // The run begins right after the impact with which the orbit begins.
            let k = i % of_orbit;
            (0..2).for_each(|j| off(three.q[(i, j)], one.q[(k, j)]));
            (0..2).for_each(|j| off(three.v[(i, j)], one.v[(k, j)]));
            off(three.phase[i], one.phase[k]);
        }
    }
}

#[test]
fn what_is_asked_wrongly_is_refused_by_name() {
    let scene = oscillator_at(5.0, 2.4, 1.0);
    let usual = DiagramOptions::default();
    assert!(refused(&scene, &[], &usual).contains("axis is without values"));
    assert!(refused(&scene, &[1.0, f64::NAN], &usual).contains("axis[1]: forcing_scale is NaN"));
    let never = DiagramOptions {
        periods: 0,
        ..usual.clone()
    };
    assert!(refused(&scene, &[1.0], &never).contains("periods is 0"));
    let other = DiagramOptions {
        section: Section::Impacts(vec![1]),
        ..usual.clone()
    };
    assert!(refused(&scene, &[1.0], &other).contains("stops is 1"));
    let start = Some((dvector![0.0, 0.0], dvector![0.0]));
    let long = DiagramOptions {
        start,
        ..usual.clone()
    };
    assert!(refused(&scene, &[1.0], &long).contains("q0"));
    let run = simulate(
        &scene,
        &dvector![0.0],
        &dvector![0.0],
        (0.0, 9.0),
        &SimulateOptions::default(),
    )
    .expect("a run");
    assert!(poincare_points(&run, &Section::Phase(f64::INFINITY)).is_err());
    assert!(poincare_points(&run, &Section::Impacts(vec![3])).is_err());
    let free = Scene::new(
        scene.system().clone(),
        vibroimpact::Forcing::Unforced,
        scene.stops().to_vec(),
    )
    .expect("valid");
    let run = simulate(
        &free,
        &dvector![0.3],
        &dvector![0.0],
        (0.0, 9.0),
        &SimulateOptions::default(),
    )
    .expect("a run");
    let error = poincare_points(&run, &Section::Phase(0.0)).expect_err("no period");
    assert!(
        error.to_string().contains("forcing with a period"),
        "{error}"
    );
}

/// Where a plane is passed by dense looks: between which times.
fn by_looks(
    run: &vibroimpact::Trajectory,
    row: &DVector<f64>,
    value: f64,
    looks: usize,
) -> Vec<(f64, f64)> {
    let (start, end) = run.span();
    let at = |t: f64| {
        let (q, v) = run
            .state(t, vibroimpact::ImpactSide::After)
            .expect("inside");
        let x = DVector::from_iterator(row.len(), q.iter().chain(v.iter()).copied());
        row.dot(&x) - value
    };
    let time = |k: usize| start + (end - start) * k as f64 / looks as f64;
    let above: Vec<bool> = (0..=looks).map(|k| at(time(k)) > 0.0).collect();
    let rises = (0..looks).filter(|&k| !above[k] && above[k + 1]);
    rises.map(|k| (time(k), time(k + 1))).collect()
}

#[test]
fn a_plane_is_passed_where_dense_looks_see_it() {
    let pair = LinearSystem::new(
        dmatrix![1.0, 0.2; 0.2, 0.7],
        dmatrix![0.02, 0.0; 0.0, 0.05],
        dmatrix![3.0, -1.0; -1.0, 60.0],
    );
    let force = Harmonic::new(dvector![1.0.into(), 2.0.into()], 1.3, 0.4).expect("valid");
    let stop = Stop::new(0, 0.4, 0.8).expect("valid");
    let scene = Scene::new(pair.expect("valid"), force, [stop]).expect("valid");
    let pendulum = PaperOptions {
        linear: false,
        ..PaperOptions::default()
    };
    let pendulum = paper_scene(Kind::Three, &pendulum).expect("valid");
    for (scene, method) in [
        (&scene, Method::Exact),
        (&scene, Method::Dop853),
        (&scene, Method::Rk45),
        (&pendulum, Method::Taylor),
    ] {
        let options = SimulateOptions {
            solver: method.into(),
            ..SimulateOptions::default()
        };
        let start = (dvector![0.1, -0.2], dvector![0.3, 0.1]);
        let run = simulate(scene, &start.0, &start.1, (0.0, 60.0), &options).expect("a run");
        assert!(run.impacts().len() > 5);
        for (row, value) in [
            (dvector![0.0, 1.0, 0.0, 0.0], 0.01),
            (dvector![0.0, 0.0, 1.0, 0.0], 0.0),
            (dvector![0.3, -1.0, 0.2, 0.05], -0.02),
        ] {
            let plane = Section::Plane {
                row: row.clone(),
                value,
            };
            let found = poincare_points(&run, &plane).expect("a section");
            let seen = by_looks(&run, &row, value, 20_000);
            assert!(seen.len() > 5);
            // Those between two looks too, which they do not see.
            let passed = |&(from, to): &(f64, f64)| found.t.iter().any(|t| (from..=to).contains(t));
            assert!(seen.iter().all(passed), "{seen:?} {:?}", found.t);
            let hits: Vec<f64> = run.impacts().iter().map(|impact| impact.time).collect();
            for (k, &t) in found.t.iter().enumerate() {
                let x = dvector![
                    found.q[(k, 0)],
                    found.q[(k, 1)],
                    found.v[(k, 0)],
                    found.v[(k, 1)]
                ];
                let off = row.dot(&x) - value;
                // At an impact the state is the one behind it.
                assert!(
                    off.abs() < 1e-10 || (off > 0.0 && hits.contains(&t)),
                    "{t}: {off:e}"
                );
            }
            let by_one = found.t.windows(2).all(|pair| pair[0] < pair[1]);
            assert!(
                by_one && found.t.len() - seen.len() <= 2,
                "{} {}",
                found.t.len(),
                seen.len()
            );
        }
    }
}

#[test]
fn a_plane_between_pieces_is_passed_once() {
    // Flights between two stops about zero pass zero in their middle, where the pieces of a polynomial meet.
    for (stiffness, restitution) in [(1.0, 1.0), (1.0, 0.5), (2.3, 1.0), (0.7, 0.9)] {
        let system =
            LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![stiffness]).expect("valid");
        let stop = || Stop::new(0, 0.5, restitution).expect("valid");
        let scene = Scene::new(
            system,
            Forcing::Unforced,
            [stop(), stop().on_side(Side::Lower)],
        )
        .expect("valid");
        for (q, v) in [(-0.5, 3.0), (0.0, 3.0), (0.5, -2.0)] {
            let run = simulate(
                &scene,
                &dvector![q],
                &dvector![v],
                (0.0, 8.0),
                &SimulateOptions::default(),
            )
            .expect("a run");
            let plane = Section::Plane {
                row: dvector![1.0, 0.0],
                value: 0.0,
            };
            let found = poincare_points(&run, &plane).expect("points");
            assert!(found.v.iter().all(|v| *v > 0.0), "{:?}", found.v);
            assert!(
                found.t.windows(2).all(|pair| pair[1] - pair[0] > 1e-3),
                "{:?}",
                found.t
            );
            // Once between an impact below and the next one above, and at the start.
            let below = run
                .impacts()
                .iter()
                .filter(|impact| impact.stop == 1)
                .count();
            let begins = usize::from(v > 0.0);
            assert!(found.t.len().abs_diff(below + begins) <= 1);
        }
    }
}

#[test]
fn a_plane_of_a_motion_of_parts_that_cancel_is_passed() {
    // Near resonance a motion of 0.3 is the difference of two of 50: it is known to less than its own rounding.
    let system =
        LinearSystem::new(dvector![1.026_452_23], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.469_359_04.into()], 1.0, 0.0).expect("valid");
    let scene = Scene::new(system, force, [Stop::new(0, 0.3, 1.0).expect("valid")]).expect("valid");
    let run = simulate(
        &scene,
        &dvector![-0.119_510_98],
        &dvector![0.0],
        (0.0, 30.0),
        &SimulateOptions::default(),
    )
    .expect("a run");
    let passed = |row: [f64; 2], value: f64| {
        let plane = Section::Plane {
            row: DVector::from_row_slice(&row),
            value,
        };
        poincare_points(&run, &plane).expect("points")
    };
    let found = passed([1.0, 0.0], 0.2);
    assert!(!found.t.is_empty() && found.q.iter().all(|q| (q - 0.2).abs() < 1e-12));
    assert_eq!(
        found.t.len(),
        by_looks(&run, &dvector![1.0, 0.0], 0.2, 20_000).len()
    );
    // In any unit.
    for unit in [1e-310, 1e-30, 1e30, 1e300] {
        assert_eq!(passed([unit, 0.0], 0.2 * unit).t.len(), found.t.len());
    }
    assert!(passed([1.0, 0.0], 1e308).t.is_empty() && passed([1e-310, 0.0], 1.0).t.is_empty());
}

#[test]
fn a_plane_of_a_free_motion_has_its_closed_form() {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let none: [Stop; 0] = [];
    let scene = Scene::new(system, vibroimpact::Forcing::Unforced, none).expect("valid");
    let run = simulate(
        &scene,
        &dvector![1.0],
        &dvector![0.0],
        (0.0, 1000.0),
        &SimulateOptions::default(),
    );
    let run = run.expect("a run");
    let plane = |row: DVector<f64>, value: f64| {
        let found = poincare_points(&run, &Section::Plane { row, value });
        found.expect("a section")
    };
    // cos t rises through a half at 5 pi/3, its speed through zero at pi; a hair below its crest twice as near to it as the root says.
    let found = plane(dvector![1.0, 0.0], 0.5);
    assert_eq!(found.t.len(), 159);
    for (k, t) in found.t.iter().enumerate() {
        assert!(
            (t - (5.0 / 6.0 + k as f64) * TAU).abs() < 1e-12 * (1.0 + t),
            "{t}"
        );
    }
    let found = plane(dvector![0.0, 1.0], 0.0);
    assert_eq!(found.t.len(), 159);
    for (k, t) in found.t.iter().enumerate() {
        assert!(
            (t - (0.5 + k as f64) * TAU).abs() < 1e-12 * (1.0 + t),
            "{t}"
        );
    }
    let found = plane(dvector![1.0, 0.0], 1.0 - 1e-8);
    assert_eq!(found.t.len(), 159);
    assert!((found.t[0] - (TAU - 2e-8f64.sqrt())).abs() < 1e-7);
    assert!(plane(dvector![1.0, 0.0], 1.1).t.is_empty());
    // A start on it counts.
    let found = plane(dvector![0.0, -1.0], 0.0);
    assert_eq!((found.t[0], found.t.len()), (0.0, 160));
    // Rest in the plane is no passage.
    let rest = simulate(
        &scene,
        &dvector![0.0],
        &dvector![0.0],
        (0.0, 10.0),
        &SimulateOptions::default(),
    );
    let section = Section::Plane {
        row: dvector![1.0, 1.0],
        value: 0.0,
    };
    let found = poincare_points(&rest.expect("a run"), &section).expect("a section");
    assert!(found.t.is_empty());
}

#[test]
fn a_plane_of_an_orbit_is_passed_once_in_a_round() {
    let scene = oscillator_at(9.0, 2.4, 1.0);
    let orbits =
        periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default()).expect("solved");
    let orbit = &orbits[0];
    // The impact makes the speed negative, and it rises through zero once; backwards it does so by the impact.
    for (row, at_impact) in [(dvector![0.0, 1.0], false), (dvector![0.0, -1.0], true)] {
        let found = poincare_points(orbit, &Section::Plane { row, value: 0.0 }).expect("a section");
        assert_eq!(found.t.len(), 1);
        assert_eq!(found.v[(0, 0)].abs() > 0.1, at_impact, "{found:?}");
    }
    for (row, word) in [
        (dvector![1.0], "(1,)"),
        (dvector![0.0, 0.0], "zeros"),
        (dvector![f64::NAN, 0.0], "finite"),
    ] {
        let error =
            poincare_points(orbit, &Section::Plane { row, value: 0.0 }).expect_err("refused");
        assert!(
            error.to_string().contains("plane") && error.to_string().contains(word),
            "{error}"
        );
    }
}

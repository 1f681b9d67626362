//! Basins against motions that are followed to their end, and laws that any basins obey.

use crate::scenes::{between_stops, double_well, grid, oscillator};
use std::f64::consts::PI;
use vibroimpact::nalgebra::{DMatrix, dmatrix, dvector};
use vibroimpact::{
    Attractor, AttractorKind, AttractorOptions, BasinCells, BasinOptions, Harmonic, Kind, Label,
    LinearSystem, Method, Motion, PaperOptions, Scene, SimulateOptions, StateBox, Stop,
    SweepOptions, basin_cells, find_attractors, paper_scene, simulate,
};

fn attractors(
    scene: &Scene,
    around: &StateBox,
    seeds: &DMatrix<f64>,
    phase: f64,
) -> Vec<Attractor> {
    let options = AttractorOptions {
        phase,
        ..AttractorOptions::default()
    };
    find_attractors(scene, around, seeds, &options)
        .expect("attractors")
        .all
}

fn cells(
    scene: &Scene,
    known: &[Attractor],
    (around, states): (&StateBox, &DMatrix<f64>),
    options: &BasinOptions,
) -> BasinCells {
    let phases = vec![options.phase; states.nrows()];
    basin_cells(scene, known, around, (states, &phases), options).expect("cells")
}

#[test]
fn a_label_is_where_the_motion_ends() {
    let scene = oscillator(9.0);
    let (around, states) = grid([-3.0, 1.5], [-5.0, 5.0], 10);
    let known = attractors(&scene, &around, &states, 0.0);
    assert_eq!(known.len(), 2);
    let found = cells(&scene, &known, (&around, &states), &BasinOptions::default());
    let period = scene.period().expect("forced");
    let mut counts = [0; 2];
    for (k, label) in found.labels.iter().enumerate() {
        let row = states.row(k);
        if row[0] > 1.0 {
            assert_eq!((*label, found.iterations[k]), (Label::Inside, 0));
            continue;
        }
        let part = |j: usize| row.columns(j, 1).transpose();
        let run = simulate(
            &scene,
            &part(0),
            &part(1),
            (0.0, 900.0 * period),
            &SimulateOptions::default(),
        );
        let run = run.expect("a run");
        let (q, v) = run.last();
        let near = |one: &Attractor| {
            let mut points = one.points.row_iter();
            points.any(|point| (point[0] - q[0]).abs().max((point[1] - v[0]).abs()) < 1e-6)
        };
        let place = known.iter().position(near).expect("on one of them");
        assert_eq!(*label, Label::Attractor(place), "{row}");
        assert!(found.iterations[k] >= 3);
        counts[place] += 1;
    }
    assert!(counts[0] > 5 && counts[1] > 5, "{counts:?}");
    // Elsewhere in the period the same states lead elsewhere; their motions a while later do not.
    let later = simulate(
        &scene,
        &states.row(3).columns(0, 1).transpose(),
        &states.row(3).columns(1, 1).transpose(),
        (0.0, 0.3 * period),
        &SimulateOptions::default(),
    );
    let later = later.expect("a run");
    let state = dmatrix![later.last().0[0], later.last().1[0]];
    let phases = [0.3 * 2.0 * PI];
    let moved = basin_cells(
        &scene,
        &known,
        &around,
        (&state, &phases),
        &BasinOptions::default(),
    );
    assert_eq!(moved.expect("cells").labels[0], found.labels[3]);
}

#[test]
fn mirrored_states_have_mirrored_labels() {
    let scene = between_stops();
    let (around, states) = grid([-0.5, 0.5], [-2.0, 2.0], 8);
    let known = attractors(&scene, &around, &states, 0.0);
    let found = cells(&scene, &known, (&around, &states), &BasinOptions::default());
    let mirrored: DMatrix<f64> = -&states;
    let others = attractors(&scene, &around, &mirrored, PI);
    let options = BasinOptions {
        phase: PI,
        ..BasinOptions::default()
    };
    let mirror = cells(&scene, &others, (&around, &mirrored), &options);
    assert_eq!(found.labels, mirror.labels);
    assert!(
        found
            .labels
            .iter()
            .all(|label| matches!(label, Label::Attractor(_)))
    );
    // Of wells too, half of the box each but for the force.
    let scene = double_well();
    let (around, states) = grid([-2.2, 2.2], [-2.2, 2.2], 12);
    let known = attractors(&scene, &around, &states, 0.0);
    assert_eq!(known.len(), 2);
    let found = cells(&scene, &known, (&around, &states), &BasinOptions::default());
    let count = |k: usize| {
        found
            .labels
            .iter()
            .filter(|label| **label == Label::Attractor(k))
            .count()
    };
    assert_eq!(count(0) + count(1), 144);
    assert!(
        count(0).abs_diff(count(1)) < 30,
        "{} {}",
        count(0),
        count(1)
    );
}

#[test]
fn chaos_is_told_from_what_leaves_and_from_nothing() {
    let scene = oscillator(5.0);
    let (around, states) = grid([-3.0, 1.0], [-5.0, 5.0], 4);
    let known = attractors(&scene, &around, &states, 0.0);
    assert_eq!((known.len(), known[0].kind), (1, AttractorKind::Chaotic));
    let found = cells(&scene, &known, (&around, &states), &BasinOptions::default());
    assert!(
        found
            .labels
            .iter()
            .all(|label| *label == Label::Attractor(0)),
        "{found:?}"
    );
    let none = cells(
        &scene,
        &[],
        (&around, &states),
        &BasinOptions {
            max_periods: 40,
            ..BasinOptions::default()
        },
    );
    assert!(none.labels.iter().all(|label| *label == Label::Undecided));
    assert!(none.iterations.iter().all(|count| *count == 40));
    let none = cells(
        &scene,
        &known,
        (&around, &states),
        &BasinOptions {
            max_periods: 0,
            ..BasinOptions::default()
        },
    );
    assert!(none.labels.iter().all(|label| *label == Label::Undecided));
    let inside = dmatrix![1.5, 0.0];
    let none = cells(
        &scene,
        &known,
        (&around, &inside),
        &BasinOptions {
            max_periods: 0,
            ..BasinOptions::default()
        },
    );
    assert_eq!(none.labels, [Label::Inside]);
    let growing = {
        use vibroimpact::nalgebra::dvector;
        use vibroimpact::{Harmonic, LinearSystem, Stop};
        let system =
            LinearSystem::new(dvector![1.0], dmatrix![-0.2], dmatrix![1.0]).expect("valid");
        let force = Harmonic::new(dvector![1.0.into()], 2.4, 0.0).expect("valid");
        let none: [Stop; 0] = [];
        Scene::new(system, force, none).expect("valid")
    };
    let lost = cells(&growing, &[], (&around, &states), &BasinOptions::default());
    assert!(
        lost.labels.iter().all(|label| *label == Label::Lost),
        "{lost:?}"
    );
}

#[test]
fn threads_change_no_label_and_wrong_calls_are_refused() {
    let scene = oscillator(9.0);
    let (around, states) = grid([-3.0, 1.5], [-5.0, 5.0], 9);
    let known = attractors(&scene, &around, &states, 0.0);
    let of = |threads| {
        let sweep = SweepOptions {
            threads: Some(threads),
        };
        cells(
            &scene,
            &known,
            (&around, &states),
            &BasinOptions {
                sweep,
                ..BasinOptions::default()
            },
        )
    };
    assert_eq!(of(1), of(7));
    let refused = |states: &DMatrix<f64>, phases: &[f64]| {
        let found = basin_cells(
            &scene,
            &known,
            &around,
            (states, phases),
            &BasinOptions::default(),
        );
        found.expect_err("refused").to_string()
    };
    assert!(refused(&dmatrix![0.0], &[0.0]).contains("states"));
    assert!(refused(&dmatrix![0.0, 0.0], &[]).contains("phases"));
    assert!(refused(&dmatrix![0.0, f64::NAN], &[0.0]).contains("states[0]"));
    assert!(refused(&dmatrix![0.0, 0.0], &[f64::NAN]).contains("phases[0]"));
}

#[test]
fn pendulums_side_by_side_have_the_labels_of_single_motions() {
    // Two orbits attract: one that hits the wall of the lower mass, one that swings below it.
    let scene = paper_scene(
        Kind::Three,
        &PaperOptions {
            linear: false,
            ..PaperOptions::default()
        },
    )
    .expect("a scene");
    let states = DMatrix::from_fn(36, 4, |k, j| match j {
        0 => -0.12 + 0.04 * (k % 6) as f64,
        1 => -0.2 + 0.1 * (k / 6) as f64,
        _ => 0.0,
    });
    let sides = (
        dvector![-0.2, -0.2, -0.3, -0.3],
        dvector![0.1, 0.2, 0.3, 0.3],
    );
    let around = StateBox::new(sides.0, sides.1).expect("a box");
    let known = attractors(&scene, &around, &states, 0.0);
    assert!(known.len() >= 2);
    let with = |method: Method, threads: usize| {
        let options = BasinOptions {
            solver: method.into(),
            sweep: SweepOptions {
                threads: Some(threads),
            },
            ..BasinOptions::default()
        };
        cells(&scene, &known, (&around, &states), &options)
    };
    let found = with(Method::Taylor, 1);
    assert_eq!(with(Method::Taylor, 2), found);
    let single = with(Method::Dop853, 1);
    assert_eq!(single.labels, found.labels);
    // As many periods, but where a state is as near as it has to be to rounding.
    let pairs = single.iterations.iter().zip(&found.iterations);
    assert!(pairs.into_iter().all(|(a, b)| a.abs_diff(*b) <= 1));
    assert!(found.labels.contains(&Label::Inside));
    let end = 1000.0 * scene.period().expect("forced");
    for (k, label) in found.labels.iter().enumerate() {
        let Label::Attractor(place) = *label else {
            assert_eq!((*label, found.iterations[k]), (Label::Inside, 0));
            continue;
        };
        let part = |first: usize| states.row(k).columns(first, 2).transpose();
        let run = simulate(
            &scene,
            &part(0),
            &part(2),
            (0.0, end),
            &SimulateOptions::default(),
        )
        .expect("a run");
        let (q, v) = run.last();
        let near = |one: &Attractor| {
            let off = |i: usize| {
                let point = one.points.row(i);
                (0..2)
                    .map(|j| (point[j] - q[j]).abs().max((point[j + 2] - v[j]).abs()))
                    .fold(0.0, f64::max)
            };
            (0..one.points.nrows())
                .map(off)
                .fold(f64::INFINITY, f64::min)
        };
        assert!(near(&known[place]) < 1e-4, "cell {k}");
    }
}

#[test]
fn a_motion_that_hits_nothing_is_looked_at_once_in_each_period() {
    // A stop out of reach: deviations from the one orbit decay in closed form.
    let (damping, w, width) = (0.1f64, 2.4, 20.0);
    let system = LinearSystem::new(dvector![1.0], dmatrix![damping], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], w, 0.0).expect("valid");
    let stop = Stop::new(0, 1e3, 0.8).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let sides = [-1.0, 1.0].map(|side| dvector![0.5 * side * width, 0.5 * side * width]);
    let [low, high] = sides;
    let around = StateBox::new(low, high).expect("a box");
    let states = dmatrix![5.0, 0.0; -7.0, 3.0; 0.5, -0.5];
    let known = attractors(&scene, &around, &states, 0.0);
    assert_eq!(known.len(), 1);
    let found = cells(&scene, &known, (&around, &states), &BasinOptions::default());
    let (h, c) = (0.5 * damping, (1.0 - 0.25 * damping * damping).sqrt());
    let orbit = known[0].points.row(0);
    for k in 0..states.nrows() {
        let (x, v) = (states[(k, 0)] - orbit[0], states[(k, 1)] - orbit[1]);
        let is_near = |look: usize| {
            let t = (look - 1) as f64 * std::f64::consts::TAU / w;
            let (cos, sin, decay) = ((c * t).cos(), (c * t).sin() / c, (-h * t).exp());
            let q = decay * (x * (cos + h * sin) + v * sin);
            let u = decay * (v * (cos - h * sin) - x * sin);
            q.abs().max(u.abs()) <= 1e-2 * width
        };
        let first = (3..1000)
            .find(|&look| (look - 2..=look).all(is_near))
            .expect("it decays");
        assert_eq!(found.labels[k], Label::Attractor(0));
        assert_eq!(found.iterations[k], first);
    }
}

#[test]
fn an_attractor_that_is_listed_twice_keeps_its_cells() {
    for force in [9.0, 5.0] {
        let scene = oscillator(force);
        let (around, states) = grid([-3.0, 1.0], [-5.0, 5.0], 4);
        let once = attractors(&scene, &around, &states, 0.0);
        // The same again: orbits going round twice and from another of their points, sets from other times.
        let again = |one: &Attractor| {
            let rows = one.points.nrows();
            let turned = DMatrix::from_fn(rows, 2, |k, j| one.points[((k + 1) % rows, j)]);
            if one.n_periods == 0 {
                let later = SimulateOptions {
                    t_eval: Some(
                        (1..=rows)
                            .map(|k| k as f64 * scene.period().expect("forced"))
                            .collect(),
                    ),
                    ..SimulateOptions::default()
                };
                let last = one.points.row(rows - 1).transpose();
                let (q, v) = (last.rows(0, 1).into_owned(), last.rows(1, 1).into_owned());
                let end = (rows + 1) as f64 * scene.period().expect("forced");
                let run = simulate(&scene, &q, &v, (0.0, end), &later).expect("a run");
                let (_, q, v) = run.samples().expect("samples");
                let points = DMatrix::from_fn(rows, 2, |k, j| if j == 0 { q[k] } else { v[k] });
                return Attractor {
                    points,
                    ..one.clone()
                };
            }
            Attractor {
                n_periods: 2 * rows,
                points: DMatrix::from_fn(2 * rows, 2, |k, j| turned[(k % rows, j)]),
                orbit: None,
                ..one.clone()
            }
        };
        let twice: Vec<Attractor> = once.iter().cloned().chain(once.iter().map(again)).collect();
        let options = BasinOptions::default();
        let [one, two] =
            [&once, &twice].map(|known| cells(&scene, known, (&around, &states), &options));
        assert!(
            one.labels
                .iter()
                .all(|label| matches!(label, Label::Attractor(_)))
        );
        assert_eq!(one.labels, two.labels);
    }
}

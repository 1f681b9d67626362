//! Existence maps from outside: the fold line in closed form, cells against `periodic_orbits`, the same bits on any number
//! of threads and in any pieces, bad input refused by name.

use crate::random::Random;
use crate::scenes::{harmonic, scene, unit_mass, upper};
use nalgebra::{Complex, DMatrix, dvector};
use std::cell::Cell;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::rc::Rc;
use vibroimpact::{
    Axis, BaseMotion, Error, ExistenceMap, ExistencePoint, Kind, LinearSystem, OrbitOptions,
    OrderMultipliers, PaperOptions, Parameter, Pattern, PeriodicOrbit, Scene, SweepOptions,
    existence_at, existence_map, existence_tile, paper_scene, paper_system, periodic_orbits,
    with_observer,
};

fn grid(low: f64, high: f64, n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |i| low + (high - low) * (i as f64 + 0.5) / n as f64)
}

fn axis(name: &str, values: impl IntoIterator<Item = f64>) -> Axis {
    Axis::new(name.parse().expect("a name of Scene::replace"), values)
}

fn map(
    scene: &Scene,
    stop: usize,
    x: &Axis,
    y: &Axis,
    n_periods: usize,
    threads: usize,
) -> ExistenceMap {
    let options = SweepOptions {
        threads: Some(threads),
    };
    existence_map(scene, &Pattern::single(stop), (x, y), n_periods, options).expect("solved")
}

fn third_kind() -> Scene {
    paper_scene(Kind::Three, &PaperOptions::default()).expect("valid")
}

/// Bits, so that nan equals nan.
fn bits(cells: &[ExistencePoint]) -> Vec<(u32, bool, bool, u64)> {
    cells
        .iter()
        .map(|c| {
            (
                c.n_orbits,
                c.is_admissible,
                c.is_stable,
                c.multiplier.to_bits(),
            )
        })
        .collect()
}

fn cells(map: &ExistenceMap) -> Vec<ExistencePoint> {
    (0..map.y.len())
        .flat_map(|j| (0..map.x.len()).map(move |i| map.point(i, j)))
        .collect()
}

/// The least force with which a mass 1, damping 2 eta, stiffness k^2 can hit a stop at clearance c once in n periods of
/// `f cos(w t + phase)`, from the general solution and the three conditions of the orbit, with no help from the library.
///
/// `x = e^{-eta t} (a cos + b sin)(wd t) + Re(Y e^{i(w t + phase)})`: for f = 1 the conditions x(0) = x(T) and
/// v(0) = -e v(T) are linear in (a, b) for each of phase = 0 and pi/2, and x(0) = alpha . (cos phase, sin phase) reaches
/// |alpha| at most.
fn least_force(k: f64, eta: f64, e: f64, clearance: f64, w: f64, n: usize) -> f64 {
    let wd = (k * k - eta * eta).sqrt();
    let t = TAU * n as f64 / w;
    let (decay, sin, cos) = ((-eta * t).exp(), (wd * t).sin(), (wd * t).cos());
    let y = Complex::new(1.0, 0.0) / Complex::new(k * k - w * w, 2.0 * eta * w);
    let alpha = [y, y * Complex::new(0.0, 1.0)].map(|y| {
        let (place, speed) = (y.re, -w * y.im);
        // a (1 - decay cos) - b decay sin = 0
        let ratio = (1.0 - decay * cos) / (decay * sin); // b = ratio a
        // v(0) + e v(T) = 0: free velocity of (a, b) is (-eta a + wd b) at 0, and the same of the turned pair at T.
        let (a_t, b_t) = (decay * (cos + ratio * sin), decay * (-sin + ratio * cos));
        let free = (-eta + wd * ratio) + e * (-eta * a_t + wd * b_t);
        let a = -(1.0 + e) * speed / free;
        a + place
    });
    clearance / alpha[0].hypot(alpha[1])
}

#[test]
fn the_fold_line_is_where_its_closed_form_puts_it() {
    let (k, eta, e, clearance, n) = (1.0, 0.05, 0.8, 1.0, 1);
    let force = harmonic(&[1.0], 2.0, 0.0);
    let scene = scene(unit_mass(2.0 * eta, k * k), force, [upper(0, clearance, e)]);
    let frequency = axis("frequency", grid(1.6, 4.0, 37));
    for &w in &frequency.values {
        let fold = least_force(k, eta, e, clearance, w, n);
        let column = axis("frequency", [w]);
        let close = axis(
            "forcing_scale",
            [0.5, 1.0 - 1e-11, 1.0 + 1e-11, 2.0].map(|x| x * fold),
        );
        assert_eq!(
            map(&scene, 0, &column, &close, n, 1).n_orbits,
            [0, 0, 2, 2],
            "{w}"
        );
    }
    // The boundary of a whole map, cell by cell.
    let scale = axis("forcing_scale", grid(0.01, 3.0, 83));
    let whole = map(&scene, 0, &frequency, &scale, n, 1);
    for (i, &w) in whole.x.iter().enumerate() {
        let fold = least_force(k, eta, e, clearance, w, n);
        for (j, &s) in whole.y.iter().enumerate() {
            assert_eq!(
                whole.point(i, j).n_orbits,
                if s < fold { 0 } else { 2 },
                "{w} {s} {fold}"
            );
        }
    }
    assert!(whole.n_orbits.contains(&0) && whole.n_orbits.contains(&2));
}

#[test]
fn a_force_that_grows_with_the_frequency_moves_the_fold_line_with_it() {
    // Base motion a cos(w t) of a unit mass with influence -1 is the force a w^2 cos(w t).
    let system = LinearSystem::new(dvector![1.0], dvector![0.1], dvector![1.0])
        .and_then(|s| s.with_influence(dvector![1.0]))
        .expect("valid");
    let base = BaseMotion::new(0.5, 2.0, 0.0).expect("valid");
    let scene = scene(system, base, [upper(0, 1.0, 0.8)]);
    for w in [1.7, 2.3, 3.1] {
        let fold = least_force(1.0, 0.05, 0.8, 1.0, w, 1) / (0.5 * w * w);
        let y = axis(
            "forcing_scale",
            [1.0 - 1e-11, 1.0 + 1e-11].map(|x| x * fold),
        );
        assert_eq!(
            map(&scene, 0, &axis("frequency", [w]), &y, 1, 1).n_orbits,
            [0, 2],
            "{w}"
        );
    }
}

/// Compares random cells of a map with the orbits of the scene made for each.
fn compare(
    scene: &Scene,
    pattern: &Pattern,
    (x, y): (&Axis, &Axis),
    n_periods: usize,
) -> [usize; 3] {
    let mut seen = [0; 3];
    let options = SweepOptions { threads: Some(1) };
    let found = existence_map(scene, pattern, (x, y), n_periods, options).expect("solved");
    let mut random = Random::new(1);
    for _ in 0..10 {
        let (i, j) = (random.below(x.values.len()), random.below(y.values.len()));
        let changed = scene
            .replace(x.parameter.change(x.values[i]))
            .and_then(|s| s.replace(y.parameter.change(y.values[j])))
            .expect("valid");
        let options = OrbitOptions {
            n_periods,
            ..Default::default()
        };
        let orbits = periodic_orbits(&changed, pattern, &options).expect("solved");
        let cell = found.point(i, j);
        assert_eq!(cell.n_orbits as usize, orbits.len());
        assert_eq!(
            cell.is_admissible,
            orbits.iter().any(|o| o.is_admissible() == Some(true))
        );
        let stable = |o: &PeriodicOrbit| o.stability().expect("converges").is_stable == Some(true);
        assert_eq!(
            cell.is_stable,
            orbits
                .iter()
                .any(|o| o.is_admissible() == Some(true) && stable(o))
        );
        let first = orbits.first().map(|o| o.stability().expect("converges"));
        match first.and_then(|s| s.orders.first().map(OrderMultipliers::spectral_radius)) {
            Some(radius) => assert!(
                (cell.multiplier / radius - 1.0).abs() < 1e-9,
                "{} {radius}",
                cell.multiplier
            ),
            None => assert!(cell.multiplier.is_nan()),
        }
        let alone = existence_at(&changed, pattern, n_periods).expect("solved");
        assert_eq!(
            (alone.n_orbits, alone.is_admissible, alone.is_stable),
            (cell.n_orbits, cell.is_admissible, cell.is_stable)
        );
        seen[0] += orbits.len();
        seen[1] += usize::from(cell.is_admissible);
        seen[2] += usize::from(cell.is_stable);
    }
    seen
}

#[test]
fn cells_are_what_periodic_orbits_finds() {
    let lone = Pattern::single(1);
    let axes = [
        axis("frequency", grid(1.3, 1.7, 23)),
        axis("forcing_scale", grid(0.3, 2.0, 19)),
        axis("restitution", grid(0.5, 1.0, 17)),
        axis("restitution[1]", grid(0.5, 1.0, 17)),
        axis("clearance[1]", grid(0.08, 0.3, 21)),
        axis("damping_scale", grid(0.1, 2.0, 29)),
    ];
    let mut seen = [0; 3];
    for (k, x) in axes.iter().enumerate() {
        for y in axes
            .iter()
            .skip(k + 1)
            .filter(|y| (k, y.parameter) != (2, Parameter::RESTITUTION.of(1)))
        {
            let found = compare(&third_kind(), &lone, (x, y), 2);
            seen = [0, 1, 2].map(|i| seen[i] + found[i]);
        }
    }
    assert!(
        seen.iter().all(|&count| count > 30),
        "every kind of cell is among the samples: {seen:?}"
    );
}

#[test]
fn cells_of_other_forms_are_what_periodic_orbits_finds() {
    // Complex modes: damping that the modes do not share.
    let stops = || [0usize, 1].map(|i| upper(i, 0.15, 0.8));
    let paper = paper_system(1.0, 3.2, 0.0).expect("valid");
    let damping = DMatrix::from_row_slice(2, 2, &[0.02, -0.01, -0.01, 0.05]);
    let system = LinearSystem::new(paper.mass().clone(), damping, paper.stiffness().clone())
        .and_then(|s| s.with_influence(dvector![1.0, 0.0]))
        .expect("valid");
    let scene = scene(
        system,
        BaseMotion::new(0.05, 1.5, 0.0).expect("valid"),
        stops(),
    );
    let (x, y) = (
        axis("damping_scale", [0.0, 0.3, 1.0, 2.0]),
        axis("frequency", grid(1.2, 1.8, 7)),
    );
    let seen = compare(&scene, &Pattern::single(1), (&x, &y), 2);
    assert!(seen[0] > 0, "{seen:?}");
    compare(&scene, &Pattern::single(1), (&y, &x), 1);
    // Two stops together: an orbit only where the clearances fit; and none hit at all.
    compare(
        &third_kind(),
        &Pattern::together(&[0, 1]).expect("valid"),
        (&x, &y),
        3,
    );
    compare(
        &third_kind(),
        &Pattern::none(),
        (&axis("clearance", grid(0.1, 1.0, 9)), &y),
        1,
    );
    let first = paper_scene(Kind::One, &PaperOptions::default()).expect("valid");
    let theta0 = 0.806_286_029_398_939_5;
    let (x, y) = (
        axis("clearance", [theta0, 0.5]),
        axis("forcing_scale", [1.0]),
    );
    let found = existence_map(
        &first,
        &Pattern::together(&[0, 1]).expect("valid"),
        (&x, &y),
        3,
        SweepOptions::default(),
    )
    .expect("solved");
    assert_eq!(
        (found.n_orbits.as_slice(), found.is_stable.as_slice()),
        ([1, 0].as_slice(), [true, false].as_slice())
    );
    assert!((found.multiplier[0] - 0.79341).abs() < 5e-6 && found.multiplier[1].is_nan());
}

#[test]
fn cells_of_two_instants_are_what_periodic_orbits_finds() {
    let twice = Pattern::new(vec![vec![1], vec![1]]).expect("valid");
    let (x, y) = (
        axis("frequency", [1.4, 1.5]),
        axis("clearance[1]", [0.02, 0.15]),
    );
    assert!(compare(&third_kind(), &twice, (&x, &y), 3)[0] > 0);
}

#[test]
fn resonance_and_no_damping_are_cells_like_others() {
    let force = harmonic(&[0.3], 1.0, 0.0);
    let scene = scene(unit_mass(0.0, 4.0), force, [upper(0, 0.5, 0.7)]);
    let (x, y) = (
        axis("frequency", [2.0, 2.0 + 1e-12, 1.9, 1.0, 4.0]),
        axis("restitution", [0.0, 0.7, 1.0]),
    );
    compare(&scene, &Pattern::single(0), (&x, &y), 1);
}

#[test]
fn threads_and_pieces_make_no_difference() {
    let scene = third_kind();
    let (x, y) = (
        axis("frequency", grid(1.3, 1.7, 61)),
        axis("clearance[1]", grid(0.05, 0.3, 47)),
    );
    let alone = cells(&map(&scene, 1, &x, &y, 2, 1));
    assert!(alone.iter().any(|c| c.is_stable) && alone.iter().any(|c| c.n_orbits == 0));
    for threads in [2, 3, 7] {
        assert_eq!(
            bits(&cells(&map(&scene, 1, &x, &y, 2, threads))),
            bits(&alone),
            "{threads} threads"
        );
    }
    let total = alone.len();
    let mut pieces = Vec::new();
    for range in [0..1000, 1000..1001, 1001..1001, 1001..total] {
        pieces.extend(
            existence_tile(&scene, &Pattern::single(1), (&x, &y), 2, range).expect("solved"),
        );
    }
    assert_eq!(bits(&pieces), bits(&alone));
    assert!(existence_tile(&scene, &Pattern::single(1), (&x, &y), 2, 0..total + 1).is_err());
}

#[test]
fn one_value_is_an_axis_and_rows_are_of_equal_y() {
    let scene = third_kind();
    let (x, y) = (
        axis("frequency", [1.4, 1.5]),
        axis("clearance[1]", [10.0, 0.15, 20.0]),
    );
    let both = map(&scene, 1, &x, &y, 2, 1);
    assert_eq!(both.n_orbits, [0, 0, 2, 2, 0, 0]);
    assert_eq!(
        (both.x_name.as_deref(), both.y_name.as_deref()),
        (Some("frequency"), Some("clearance[1]"))
    );
    let one = map(
        &scene,
        1,
        &axis("frequency", [1.5]),
        &axis("clearance[1]", [0.15]),
        2,
        1,
    );
    assert_eq!(bits(&cells(&one)), bits(&[both.point(1, 1)]));
    assert!(one.is_stable[0] && one.multiplier[0] < 1.0);
    let again =
        ExistenceMap::from_cells((None, vec![1.4, 1.5]), (None, vec![0.0; 3]), &cells(&both))
            .expect("6 cells");
    assert_eq!(again.n_orbits, both.n_orbits);
    assert!(
        ExistenceMap::from_cells((None, vec![1.4]), (None, vec![0.0; 3]), &cells(&both)).is_err()
    );
}

#[test]
fn an_observer_hears_of_progress_and_may_stop() {
    let scene = third_kind();
    let (x, y) = (
        axis("frequency", grid(1.3, 1.7, 40)),
        axis("clearance[1]", grid(0.05, 0.3, 30)),
    );
    for threads in [1, 2] {
        let options = SweepOptions {
            threads: Some(threads),
        };
        let last = Rc::new(Cell::new(0.0));
        let told = Rc::clone(&last);
        let watch = move |part: f64| {
            assert!(part >= told.replace(part), "it goes back");
            ControlFlow::Continue(())
        };
        let map = || existence_map(&scene, &Pattern::single(1), (&x, &y), 2, options);
        with_observer(watch, map).expect("solved");
        assert_eq!(last.get(), 1.0);
        let broken = with_observer(|_| ControlFlow::Break(()), map);
        assert_eq!(broken, Err(Error::Interrupted));
    }
}

#[test]
fn wrong_questions_are_refused_by_name() {
    let scene = third_kind();
    let refusal = |x: &Axis, y: &Axis, stop: usize, n_periods: usize| {
        let options = SweepOptions::default();
        let map = || existence_map(&scene, &Pattern::single(stop), (x, y), n_periods, options);
        with_observer(|_| panic!("refused before anything is computed"), map)
            .expect_err("refused")
            .to_string()
    };
    let w = axis("frequency", [1.5]);
    for (name, values, start) in [
        ("restitution", vec![0.5, 1.2], "restitution is 1.2"),
        ("restitution[1]", vec![f64::NAN], "restitution is NaN"),
        ("clearance", vec![0.1, f64::INFINITY], "clearance is inf"),
        ("forcing_scale", vec![f64::NAN], "forcing_scale is NaN"),
        ("damping_scale", vec![1.0, f64::NAN], "damping_scale is NaN"),
        ("clearance[2]", vec![0.1], "clearance[2]"),
        ("clearance", vec![], "y has shape (0,)"),
        ("frequency", vec![1.5], "y is frequency"),
    ] {
        let message = refusal(&w, &axis(name, values), 1, 2);
        assert!(message.starts_with(start), "{message}");
    }
    let c = axis("clearance", [0.1]);
    assert!(refusal(&axis("frequency", [1.5, 0.0]), &c, 1, 2).starts_with("frequency is 0"));
    assert!(refusal(&axis("clearance[1]", [0.1]), &c, 1, 2).starts_with("y is clearance"));
    assert!(refusal(&w, &c, 2, 2).starts_with("pattern[0]"));
    assert!(refusal(&w, &c, 1, 0).starts_with("n_periods"));
    for name in ["period", "clearance[-1]", "clearance[]", "frequency[0]", ""] {
        assert!(name.parse::<Parameter>().is_err(), "{name}");
    }
    for name in [
        "frequency",
        "phase",
        "forcing_scale",
        "damping_scale",
        "clearance",
        "restitution[3]",
        "clearance[0]",
    ] {
        assert_eq!(name.parse::<Parameter>().expect("a name").to_string(), name);
    }
    let unforced = crate::scenes::scene(
        scene.system().clone(),
        vibroimpact::Forcing::Unforced,
        scene.stops().to_vec(),
    );
    assert!(existence_at(&unforced, &Pattern::single(1), 1).is_err());
    let changed = scene
        .replace(Parameter::Frequency.change(1.4))
        .expect("valid");
    assert!(existence_at(&changed, &Pattern::single(1), 2).is_ok());
}

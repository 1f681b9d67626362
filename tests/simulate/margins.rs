//! What counts as a contact in exact flights: no tolerance has a say in it but at the start, and completion of chatter goes on as
//! the tolerance says (theory 8, 9).

use crate::random::{Cases, Random};
use crate::scenes::{linear, oscillator, run, scene, upper, with};
use nalgebra::{Complex, DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, Forcing, Harmonic, Impact, ImpactSide, LinearSystem, Load, Method, Motion,
    OrbitOptions, Pattern, Scene, SegmentKind, Side, Signal, SimulateOptions, Solver, Stop,
    StopMotion, Trajectory, periodic_orbits, simulate,
};

/// An oscillator of frequency and amplitude 1 from the middle, `q = sin t`, and a stop below its peak by a depth.
fn swing(depth: f64, options: &SimulateOptions) -> Trajectory {
    let scene = oscillator(0.0, Forcing::Unforced, [upper(0, 1.0 - depth, 0.8)]);
    run(&scene, &[0.0], &[1.0], 3.0, options)
}

fn tolerances() -> impl Iterator<Item = f64> {
    (3..=12).map(|digits| 0.1f64.powi(digits))
}

#[test]
fn shallow_contacts_are_impacts_at_every_tolerance() {
    for digits in 3..=13 {
        let depth = 0.1f64.powi(digits);
        // sin t = 1 - depth, where the speed is cos t.
        let clearance = 1.0 - depth;
        let depth = 1.0 - clearance;
        let speed = (depth * (2.0 - depth)).sqrt();
        let time = speed.acos();
        let usual = swing(depth, &with(Method::Exact, 1e-9));
        for rtol in tolerances() {
            let run = swing(depth, &with(Method::Exact, rtol));
            assert_eq!(run.impacts().len(), 1, "depth {depth:e}, rtol {rtol:e}");
            let found = run.impacts()[0];
            // The rounding of the clearance and of the gap move the speed by as much over itself, and the time with it.
            let rounding = 4.0 * f64::EPSILON / speed;
            assert!(
                (found.time - time).abs() < rounding && (found.approach - speed).abs() < rounding
            );
            if rtol >= 1e-9 {
                assert_eq!(found, usual.impacts()[0]);
                assert_eq!(run.last(), usual.last());
            }
        }
    }
}

#[test]
fn a_start_is_judged_by_the_margin_of_its_flight() {
    let stop = upper(0, 1.0, 0.8);
    let scene = oscillator(0.0, Forcing::Unforced, [stop]);
    let from = |depth: f64, options: &SimulateOptions| {
        simulate(
            &scene,
            &dvector![1.0 + depth],
            &dvector![1.0],
            (0.0, 0.1),
            options,
        )
    };
    for rtol in [1e-3, 1e-6, 1e-9] {
        let run = from(1e-8, &with(Method::Exact, rtol)).expect("in contact");
        assert_eq!(run.impacts()[0].time, 0.0);
        let error = from(1e-7, &with(Method::Exact, rtol))
            .expect_err("inside the stop")
            .to_string();
        assert!(
            error.contains("q0") && error.contains("margin, -2"),
            "{error}"
        );
    }
    // Steps that err by their tolerance judge a start by it.
    let steps = with(Method::Rk45, 1e-3);
    assert_eq!(
        from(1e-3, &steps).expect("in contact").impacts()[0].time,
        0.0
    );
}

/// One to three coupled coordinates at rest between stops, forced or not, with a velocity.
fn random_scene(random: &mut Random) -> (Scene, DVector<f64>) {
    let n = 1 + random.below(3);
    let square = |random: &mut Random, least: f64| {
        let root = random.matrix(n);
        root.tr_mul(&root) + DMatrix::from_diagonal_element(n, n, least)
    };
    let (mass, stiffness) = (square(random, 0.3), square(random, 0.3));
    let damping = square(random, 0.0) * random.between(0.0, 0.1);
    let forcing: Forcing = if random.unit() < 0.5 {
        Forcing::Unforced
    } else {
        let force = random.vector(n).map(Into::into);
        Harmonic::new(force, random.between(0.5, 2.0), 0.0)
            .expect("valid")
            .into()
    };
    let stops: Vec<Stop> = (0..=random.below(3))
        .map(|k| {
            let (clearance, e) = (random.between(0.05, 0.5), random.between(0.3, 1.0));
            let stop = upper(random.vector(n), clearance, e);
            stop.on_side(if k % 2 == 0 { Side::Upper } else { Side::Lower })
        })
        .collect();
    let system = linear(mass, damping, stiffness);
    let scene = scene(system, forcing, stops);
    (scene, random.vector(n))
}

/// The impacts before those of some stop are completed, at most so many.
fn before_rest(run: &Trajectory, most: usize) -> &[Impact] {
    let segments = run.segments().expect("kept");
    let rest = segments
        .iter()
        .filter(|s| s.kind != SegmentKind::Flight)
        .map(|s| s.start)
        .fold(f64::INFINITY, f64::min);
    let count = run.impacts().iter().take_while(|i| i.time < rest).count();
    &run.impacts()[..count.min(most)]
}

#[test]
fn random_scenes_have_the_same_impacts_at_every_tolerance() {
    let (cases, mut compared) = (Cases::new(5, 300), 0);
    for (case, mut random) in cases.each() {
        let (scene, v0) = random_scene(&mut random);
        let q0 = DVector::zeros(v0.len());
        let run = |rtol: f64| {
            simulate(&scene, &q0, &v0, (0.0, 30.0), &with(Method::Exact, rtol)).expect("runs")
        };
        let (loose, usual, strict) = (run(1e-3), run(1e-9), run(1e-12));
        // The looser a tolerance, the earlier chatter is completed; up to there nothing tells the runs apart.
        let known = before_rest(&loose, 20);
        assert_eq!(
            known,
            &before_rest(&usual, 20)[..known.len()],
            "case {case}"
        );
        for (a, b) in known.iter().zip(before_rest(&strict, 20)) {
            let error = (a.time - b.time).abs().max((a.approach - b.approach).abs());
            assert!(a.stop == b.stop && error < 1e-7, "case {case}: {error:e}");
            compared += 1;
        }
    }
    assert!(cases.have(compared, 300), "{compared}");
}

#[test]
fn a_start_on_two_stops_hits_both_however_far_the_modes_are_off() {
    // Near resonance the modes start from large numbers that cancel, and at this tolerance the margin is below their rounding.
    let system = linear(
        dvector![1.0, 1.0],
        dmatrix![0.02, -1.6; 1.6, 0.02],
        dmatrix![3.0, -3.0; -3.0, 3.0],
    );
    let stops = [
        upper(dvector![1.0, -1.0], 0.0, 0.5),
        upper(dvector![1.0, 0.0], 0.0, 0.5),
    ];
    for k in 0..40 {
        let force = dvector![Complex::from(-0.7), Complex::from(-0.5)];
        let (frequency, phase) = (6f64.sqrt() - 2.4e-6, 0.05 * f64::from(k));
        let force = Harmonic::new(force, frequency, phase).expect("valid");
        let scene = scene(system.clone(), force, stops.clone());
        let (q0, v0) = (dvector![0.0, 0.0], dvector![0.4, -0.4]);
        let run = simulate(
            &scene,
            &q0,
            &v0,
            (-67.66, -60.0),
            &with(Method::Exact, 1e-13),
        )
        .expect("runs");
        // The first stop alone pushes: its impulse leaves the second at the speed that restitution asks for.
        let first = &run.impacts()[0];
        assert_eq!((first.stop, first.time), (0, -67.66), "{k}");
        assert!((first.approach - 0.8).abs() < 1e-9 && (first.departure - 0.4).abs() < 1e-9);
    }
}

#[test]
fn a_flight_whose_last_step_rounds_short_is_not_searched_beyond_its_end() {
    // Whether the time of the last step and its length make the span is a matter of rounding: of a hundred dampings next to each other.
    let force = Harmonic::new(dvector![1.4.into()], 1.65, 0.0).expect("valid");
    let stops = [
        Stop::new(0, 0.92, 0.5).expect("valid"),
        Stop::new(0, 1.07, 0.5).expect("valid").on_side(Side::Lower),
    ];
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    for k in -50..=50 {
        let damping = 0.02 * (1.0 + 2e-8 * f64::from(k));
        let system = LinearSystem::new(dvector![1.0], dvector![damping], dvector![0.74]);
        let scene = Scene::new(system.expect("valid"), force.clone(), stops.clone());
        let found = periodic_orbits(&scene.expect("valid"), &pattern, &OrbitOptions::default());
        let found = found.expect("a search");
        for orbit in found.iter() {
            let passes = (0..=400).any(|part| {
                let (q, _) = orbit
                    .state(orbit.period() * f64::from(part) / 400.0, ImpactSide::After)
                    .expect("a time");
                q[0] > 0.92 + 1e-9 || q[0] < -1.07 - 1e-9
            });
            assert_eq!(orbit.is_admissible(), Some(!passes), "{k}");
        }
    }
}

/// A stop's motion `amplitude cos w t`.
fn shaken(amplitude: f64, w: f64) -> StopMotion {
    let motion = Harmonic::new(dvector![amplitude.into()], w, 0.0);
    motion.and_then(StopMotion::harmonic).expect("valid")
}

/// Coordinates that everything acts on: weights, forces, a base and a record, before stops at rest and in motion, with and without
/// anything that holds them; all lengths, and what has a length in it, times a factor.
fn in_unit(case: &mut Random, length: f64) -> (Scene, DVector<f64>, DVector<f64>) {
    let n = 1 + case.below(3);
    let root = case.matrix(n);
    let mass = root.tr_mul(&root) + DMatrix::identity(n, n);
    let root = case.matrix(n);
    let is_held = case.chance(80);
    let held = root.tr_mul(&root) + DMatrix::from_diagonal_element(n, n, 0.2);
    let stiffness = held * if is_held { 4.0 } else { 0.0 };
    let root = case.matrix(n);
    let damping = root.tr_mul(&root) * case.of(&[0.0, 0.05, 0.5]);
    let load = case.vector(n) * (case.of(&[0.0, 3.0]) * length);
    let system = linear(mass, damping, stiffness)
        .with_load(load)
        .and_then(|system| system.with_influence(DVector::from_element(n, 1.0)))
        .expect("valid");
    let frequency = case.between(0.8, 2.5);
    let force = (case.vector(n) * length).map(Complex::from);
    let force = Harmonic::new(force, frequency, 0.4).expect("valid");
    let base = BaseMotion::new(0.3 * length, 2.1, 0.1).expect("valid");
    let record = [0.0, 1.0, -1.0, 0.5, 0.0].map(|x: f64| x * length);
    let record = Signal::samples(&[0.0, 1.0, 2.5, 6.0, 20.0], &record).expect("valid");
    let record = Load::new(case.vector(n), record).expect("valid");
    let forcings: Vec<Forcing> = vec![force.into(), base.into(), record.into()];
    let acting: Vec<Forcing> = (forcings.into_iter()).filter(|_| case.chance(50)).collect();
    let stops: Vec<Stop> = (0..=case.below(3))
        .map(|k| {
            let clearance = case.of(&[0.0, 0.1, 0.3]) * length;
            let motion = shaken(0.05 * length, frequency);
            let motion = case.chance(30).then_some(motion);
            let stop = upper(case.vector(n), clearance, case.of(&[0.0, 0.5, 0.8]));
            let side = if k % 2 == 0 { Side::Upper } else { Side::Lower };
            stop.on_side(side).with_motion(motion)
        })
        .collect();
    let v0 = case.vector(n) * case.of(&[0.0, 1.0]) * length;
    (
        scene(system, Forcing::Several(acting), stops),
        DVector::zeros(n),
        v0,
    )
}

/// A run in a unit of length: its end and its impacts, in units of one; none where the start lies inside a stop.
fn run_in_unit(number: usize, method: Method, length: f64) -> Option<Vec<f64>> {
    let mut case = Random::of_case(11, number as u64);
    let (scene, q0, v0) = in_unit(&mut case, length);
    let options = SimulateOptions {
        solver: method.into(),
        max_impacts: Some(300),
        ..Default::default()
    };
    let run = match simulate(&scene, &q0, &v0, (0.0, 12.0), &options) {
        Err(error) => {
            assert!(error.to_string().contains("q0"), "{number}: {error}");
            return None;
        }
        Ok(run) => run,
    };
    let impact = |i: &Impact| [i.time, i.approach / length, i.departure / length];
    let (q, v) = run.last();
    let state = q.iter().chain(v.iter()).map(|x| x / length);
    let impacts = run.impacts().iter().flat_map(impact);
    Some(state.chain(impacts).collect())
}

#[test]
fn a_run_in_another_unit_of_length_has_the_same_bits() {
    let (cases, mut compared) = (Cases::new(11, 150), 0);
    for (number, _) in cases.each() {
        for method in [Method::Exact, Method::Rk45, Method::Dop853] {
            let Some(known) = run_in_unit(number, method, 1.0) else {
                continue;
            };
            for exponent in [-80, -40, -10, 20] {
                let found = run_in_unit(number, method, 2f64.powi(exponent));
                assert_eq!(
                    found.as_ref(),
                    Some(&known),
                    "case {number}, {method:?}, {exponent}"
                );
            }
            compared += known.len() / 3;
        }
    }
    assert!(cases.have(compared, 3000), "{compared}");
}

#[test]
fn an_absolute_tolerance_is_that_of_a_length() {
    // The clearance, the motion of the stop, the start and its speed, the response 3/(4 + 1) off its resonance, each the largest of one.
    let of = |clearance: f64, moved: f64, q0: f64, v0: f64, force: f64| {
        let stop = upper(0, clearance, 0.5).with_motion(Some(shaken(moved, 1.0)));
        let force = Harmonic::new(dvector![force.into()], 1.0, 0.0).expect("valid");
        let scene = scene(
            linear(dvector![1.0], dvector![0.0], dvector![4.0]),
            force,
            [stop],
        );
        let options = SimulateOptions::default();
        run(&scene, &[q0], &[v0], 1.0, &options).stats().atol
    };
    for (atol, length) in [
        (of(7.0, 1.0, 2.0, 1.0, 3.0), 7.0),
        (of(1.0, 5.0, -2.0, 1.0, 3.0), 5.0),
        (of(1.0, 0.5, -4.0, 1.0, 3.0), 4.0),
        // The fastest rate is 2, that of the force 1 over a turn.
        (of(1.0, 0.5, -1.0, -12.0, 3.0), 6.0),
        (of(0.1, 0.05, -0.1, -0.1, 15.0), 3.0),
    ] {
        assert!(
            (atol / (1e-12 * length) - 1.0).abs() < 1e-14,
            "{atol:e} {length}"
        );
    }
    // At resonance the response has no size of its own; a number that is given is that number.
    let resonant = |atol: Option<f64>| {
        let force = Harmonic::new(dvector![1.0.into()], 2.0, 0.0).expect("valid");
        let system = linear(dvector![1.0], dvector![0.0], dvector![4.0]);
        let scene = scene(system, force, [upper(0, 0.5, 0.5)]);
        let options = SimulateOptions {
            solver: Solver {
                atol,
                ..Solver::default()
            },
            ..Default::default()
        };
        run(&scene, &[0.0], &[0.0], 1.0, &options).stats().atol
    };
    assert_eq!(resonant(None), 0.5e-12);
    assert_eq!(resonant(Some(3e-7)), 3e-7);
}

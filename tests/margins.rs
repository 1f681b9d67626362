//! What counts as a contact in exact flights: no tolerance has a say in it but at the start, and completion of chatter goes on as
//! the tolerance says (theory 8, 9).

#[path = "common/random.rs"]
mod random;
#[path = "common/scenes.rs"]
mod scenes;

use nalgebra::{Complex, DMatrix, DVector, dmatrix, dvector};
use random::{Cases, Random};
use scenes::{linear, oscillator, run, scene, upper, with};
use vibroimpact::{
    Forcing, Harmonic, Impact, LinearSystem, Method, OrbitOptions, Pattern, Scene, SegmentKind,
    Side, SimulateOptions, Stop, Trajectory, periodic_orbits, simulate,
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
    let steps = SimulateOptions {
        method: Method::Rk45,
        ..with(Method::Exact, 1e-3)
    };
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
                let (q, _) = orbit.state(orbit.period() * f64::from(part) / 400.0, false);
                q[0] > 0.92 + 1e-9 || q[0] < -1.07 - 1e-9
            });
            assert_eq!(orbit.is_admissible(), Some(!passes), "{k}");
        }
    }
}

//! Laws of motions along Taylor series (theory 8): against closed forms, against Runge-Kutta steps of the same scene, and
//! against what cannot change.

use crate::random::{Cases, Random};
use crate::scenes::{run, scene, upper, with};
use nalgebra::{Complex, DMatrix, DVector, dvector};
use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;
use vibroimpact::{
    BaseMotion, Constraint, DoublePendulum, Error, Forcing, Harmonic, ImpactSide, Keep, Kind,
    Method, Motion, NonlinearStop, PaperOptions, PendulumChain, Scene, Side, SimulateOptions,
    SweepOptions, Trajectory, Wall, WallSide, paper_scene, plan, simulate, simulate_many,
    with_observer,
};

fn taylor(rtol: f64) -> SimulateOptions {
    with(Method::Taylor, rtol)
}

fn end(run: &Trajectory) -> Vec<f64> {
    let (q, v) = run.last();
    q.iter().chain(v.iter()).copied().collect()
}

fn apart(a: &Trajectory, b: &Trajectory) -> f64 {
    let both = end(a).into_iter().zip(end(b));
    both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The third of the paper's pendulums with large motions.
fn large_motions() -> Scene {
    let options = PaperOptions {
        linear: false,
        ..Default::default()
    };
    paper_scene(Kind::Three, &options).expect("valid")
}

/// A start of it that hits its stop.
fn start() -> (DVector<f64>, DVector<f64>) {
    (dvector![0.02, -0.1], dvector![0.0, 0.3])
}

/// One link of length one under gravity one, with stops.
fn link(stops: Vec<Constraint>) -> Scene {
    let chain = PendulumChain::new(dvector![1.0], dvector![1.0], &dvector![0.0], 1.0);
    scene(chain.expect("valid"), Forcing::Unforced, stops)
}

/// The quarter of the period of a link that swings to an angle: `K(sin(angle/2)) = pi/(2 agm(1, cos(angle/2)))`.
fn quarter_period(angle: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * angle).cos());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_PI_2 / a
}

#[test]
fn a_link_swings_in_the_time_of_the_elliptic_integral() {
    let scene = link(vec![]);
    for angle in [1e-3, 0.5, 2.0, 3.1] {
        let quarter = quarter_period(angle);
        for (turns, q, v) in [
            (1.0, 0.0, None),
            (2.0, -angle, Some(0.0)),
            (40.0, angle, Some(0.0)),
        ] {
            let span = (0.0, turns * quarter);
            let run = simulate(
                &scene,
                &dvector![angle],
                &dvector![0.0],
                span,
                &taylor(1e-14),
            )
            .expect("runs");
            let speed = v.unwrap_or(-2.0 * (0.5 * angle).sin());
            let state = end(&run);
            // Near the top the link lingers: an error in its start grows as the exponential of the time.
            let slack = 2e-13 * turns * if angle > 3.0 { 100.0 } else { angle };
            assert!(
                (state[0] - q).abs() < slack && (state[1] - speed).abs() < slack,
                "{angle} {turns} {state:?}"
            );
        }
    }
}

#[test]
fn a_wall_halves_the_swing_and_takes_no_energy() {
    // Elastic, at the lowest point: every contact after half a period, at the same speed.
    let scene = link(vec![
        Wall::new(0, 0.0, 1.0, WallSide::Right)
            .expect("valid")
            .into(),
    ]);
    let angle = 1.2;
    let half = 2.0 * quarter_period(angle);
    let (q0, v0) = (dvector![-angle], dvector![0.0]);
    let run = simulate(&scene, &q0, &v0, (0.0, 1000.25 * half), &taylor(1e-13)).expect("runs");
    assert_eq!(run.impacts().len(), 1000);
    let speed = 2.0 * (0.5 * angle).sin();
    for (k, impact) in run.impacts().iter().enumerate() {
        let time = (k as f64 + 0.5) * half;
        // An error of the speed, the same at each flight, grows as the number of flights; that of the time as its square.
        let slack = 1e-13 * (k + 1) as f64;
        assert!(
            (impact.time - time).abs() < slack * time,
            "{k} {:e}",
            impact.time - time
        );
        assert!((impact.approach - speed).abs() < slack, "{k}");
    }
}

#[test]
fn the_error_follows_the_tolerance_through_impacts() {
    let scene = large_motions();
    let (q0, v0) = start();
    let run = |rtol| simulate(&scene, &q0, &v0, (0.0, 60.0), &taylor(rtol)).expect("runs");
    let truth = run(1e-15);
    for digits in 3..14 {
        let rtol = 0.1f64.powi(digits);
        let found = run(rtol);
        assert_eq!(found.impacts().len(), truth.impacts().len());
        assert!(
            apart(&found, &truth) < 3.0 * rtol,
            "{rtol:e} {:e}",
            apart(&found, &truth)
        );
        // A step has no more error than asked for, but is no shorter than it must be: one part in a thousand is waste.
        assert!(
            apart(&found, &truth) > 1e-3 * rtol || digits > 11,
            "{rtol:e} {:e}",
            apart(&found, &truth)
        );
    }
}

/// A wall below the peak of a swing by a depth: hit, wherever that exceeds the error of the motion, one and a half tolerances.
#[test]
fn no_contact_deeper_than_the_error_of_the_motion_is_missed() {
    let angle = 0.3f64;
    let mut missed = Vec::new();
    let mut impacts = 0;
    for k in 0..26 {
        let depth = 10f64.powf(-6.0 + 5.0 * f64::from(k) / 25.0) * angle.sin();
        let wall = Wall::new(0, angle.sin() - depth, 0.5, WallSide::Right).expect("valid");
        let scene = link(vec![wall.into()]);
        for digits in 3..13 {
            let rtol = 0.1f64.powi(digits);
            for start in [0.0, 0.07, 0.13, 0.21] {
                // The same swing from anywhere: v^2 = 2 (cos q - cos angle).
                let q0 = -start;
                let v0 = (2.0 * (f64::cos(q0) - angle.cos())).sqrt();
                let run = run(&scene, &[q0], &[v0], 3.0, &taylor(rtol));
                let tolerance = 1e-3 * rtol + rtol * 2.0 * angle.sin();
                let is_found = !run.impacts().is_empty() || depth < 1.5 * tolerance;
                impacts += usize::from(!run.impacts().is_empty());
                if !is_found {
                    missed.push((depth, rtol, start));
                }
            }
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
    assert!(impacts > 800, "{impacts}");
}

/// A random pendulum with forcing and stops, and a start clear of them.
fn random_case(random: &mut Random) -> (Scene, DVector<f64>, DVector<f64>) {
    let n = 1 + random.below(5);
    let vector = |random: &mut Random, low: f64, high: f64| {
        DVector::from_fn(n, |_, _| random.between(low, high))
    };
    let (masses, lengths) = (vector(random, 0.3, 2.0), vector(random, 0.4, 1.2));
    let dampers = vector(random, 0.0, 0.3);
    let forcing: Forcing = match random.below(3) {
        0 => Forcing::Unforced,
        1 => BaseMotion::new(
            random.between(0.01, 0.1),
            random.between(1.0, 5.0),
            random.between(0.0, 6.0),
        )
        .expect("valid")
        .into(),
        _ => {
            let amplitude = DVector::from_fn(n, |_, _| {
                Complex::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0))
            });
            Harmonic::new(
                amplitude,
                random.between(1.0, 5.0),
                random.between(0.0, 6.0),
            )
            .expect("valid")
            .into()
        }
    };
    let reach: f64 = lengths.iter().sum();
    let e = random.between(0.3, 1.0);
    let mut stops: Vec<Constraint> = Vec::new();
    if random.below(2) == 0 {
        let side = if random.below(2) == 0 {
            WallSide::Right
        } else {
            WallSide::Left
        };
        let position = if side == WallSide::Right {
            0.25 * reach
        } else {
            -0.25 * reach
        };
        stops.push(Wall::new(n - 1, position, e, side).expect("valid").into());
    }
    let side = if random.below(2) == 0 {
        Side::Lower
    } else {
        Side::Upper
    };
    let stop = upper(random.below(n), random.between(0.2, 0.4), e);
    stops.push(stop.on_side(side).into());
    let system: vibroimpact::System = if n == 2 && random.below(2) == 0 {
        DoublePendulum::with_damping_matrix(
            0.7,
            1.3,
            DMatrix::from_row_slice(2, 2, &[0.1, -0.04, -0.06, 0.05]),
        )
        .expect("valid")
        .into()
    } else {
        PendulumChain::new(masses, lengths, &dampers, 9.81)
            .expect("valid")
            .into()
    };
    let (q0, v0) = (vector(random, -0.1, 0.1), vector(random, -1.0, 1.0));
    (scene(system, forcing, stops), q0, v0)
}

#[test]
fn series_and_runge_kutta_steps_agree_impact_by_impact() {
    let (cases, mut impacts) = (Cases::new(7, 200), 0);
    for (case, mut random) in cases.each() {
        let (scene, q0, v0) = random_case(&mut random);
        let run =
            |method| simulate(&scene, &q0, &v0, (0.0, 2.0), &with(method, 1e-11)).expect("runs");
        let (series, steps) = (run(Method::Taylor), run(Method::Rk45));
        let (a, b) = (series.impacts(), steps.impacts());
        assert_eq!(a.len(), b.len(), "{case}");
        for (a, b) in a.iter().zip(b) {
            assert_eq!(a.stop, b.stop, "{case}");
            assert!(
                (a.time - b.time).abs() < 1e-7 && (a.approach - b.approach).abs() < 1e-6,
                "{case} {a:?} {b:?}"
            );
        }
        impacts += a.len();
        assert!(
            apart(&series, &steps) < 1e-6,
            "{case} {:e}",
            apart(&series, &steps)
        );
        assert!(series.stats().n_steps < steps.stats().n_steps, "{case}");
    }
    assert!(cases.have(impacts, 25), "{impacts}");
}

#[test]
fn a_motion_taken_apart_is_the_same_motion() {
    let scene = large_motions();
    let (q0, v0) = start();
    let whole = simulate(&scene, &q0, &v0, (0.0, 50.0), &taylor(1e-12)).expect("runs");
    let first = simulate(&scene, &q0, &v0, (0.0, 23.4), &taylor(1e-12)).expect("runs");
    let (q, v) = first.last();
    let second = simulate(&scene, q, v, (23.4, 50.0), &taylor(1e-12)).expect("runs");
    assert!(apart(&whole, &second) < 1e-10);
    assert_eq!(
        whole.impacts().len(),
        first.impacts().len() + second.impacts().len()
    );
    for k in 0..=500 {
        let t = 0.1 * f64::from(k);
        let (q, v) = whole.state(t, ImpactSide::default()).expect("kept");
        let part = if t <= 23.4 { &first } else { &second };
        let (p, u) = part.state(t, ImpactSide::default()).expect("kept");
        assert!((q - p).amax() < 1e-10 && (v - u).amax() < 1e-10, "{t}");
    }
}

/// Many runs of a scene, and each by itself: the same bits of all that is kept.
fn assert_many_are_each(scene: &Scene, starts: &[DVector<f64>; 2], options: &SimulateOptions) {
    let n = scene.n_dof();
    let [q0, v0] = starts
        .each_ref()
        .map(|x| DMatrix::from_row_slice(x.len() / n, n, x.as_slice()));
    let sweep = SweepOptions::default();
    let many = simulate_many(scene, (&q0, &v0), SPAN, options, sweep).expect("runs");
    for i in 0..q0.nrows() {
        let (q, v) = (q0.row(i).transpose(), v0.row(i).transpose());
        let one = simulate(scene, &q, &v, SPAN, options).expect("runs");
        assert_eq!(many.q.row(i).transpose(), *one.last().0, "{i}");
        assert_eq!(many.v.row(i).transpose(), *one.last().1, "{i}");
        assert_eq!(many.n_impacts[i], one.stats().n_impacts, "{i}");
        assert_eq!(many.status[i], one.status(), "{i}");
    }
}

const SPAN: (f64, f64) = (0.3, 12.0);

/// Restitutions from none to full: runs side by side end at once, chatter, rest on the wall and leave it, or fly on.
#[test]
fn runs_abreast_are_those_one_by_one() {
    let mut random = Random::new(5);
    let final_state = |rtol: f64, max_impacts: Option<usize>| SimulateOptions {
        keep: Keep::Final,
        max_impacts,
        ..taylor(rtol)
    };
    for (n, restitution) in [(1, 0.3), (2, 0.0), (2, 0.8), (3, 0.5), (5, 1.0)] {
        let masses = DVector::from_fn(n, |i, _| 1.0 + 0.2 * i as f64);
        let dampers = DVector::from_element(n, 0.05);
        let lengths = DVector::from_element(n, 0.7);
        let chain = PendulumChain::new(masses, lengths, &dampers, 9.81).expect("valid");
        let base = BaseMotion::new(0.1, 3.0, 0.4).expect("valid");
        let wall = Wall::new(n - 1, 0.15, restitution, WallSide::Right).expect("valid");
        let scene = scene(chain, base, [wall]);
        // More than a tile, and no multiple of those side by side.
        let starts = [-0.4, 0.5].map(|low| {
            DVector::from_fn(n * 37, |_, _| 0.5 * low + 0.5 * random.between(-0.4, 0.1))
        });
        for most in [None, Some(2)] {
            assert_many_are_each(&scene, &starts, &final_state(1e-8, most));
        }
    }
    let starts =
        [0.1, 0.02].map(|scale| DVector::from_fn(18, |i, _| scale * (0.2 * i as f64).sin()));
    assert_many_are_each(&large_motions(), &starts, &final_state(1e-9, None));
}

#[test]
fn an_observer_stops_runs_abreast() {
    let start = DMatrix::from_element(3, 2, 0.01);
    let hours = (0.0, 1e9);
    let options = SimulateOptions {
        keep: Keep::Final,
        ..taylor(1e-9)
    };
    let (scene, sweep) = (large_motions(), SweepOptions::default());
    let runs = || simulate_many(&scene, (&start, &start), hours, &options, sweep);
    let stopped = with_observer(|_| ControlFlow::Break(()), runs);
    assert_eq!(stopped, Err(Error::Interrupted));
}

/// `2 - q_0`
struct Plane;

impl vibroimpact::GapFunction for Plane {
    fn gap(&self, q: &[f64]) -> vibroimpact::Result<f64> {
        Ok(2.0 - q[0])
    }
    fn gradient(&self, _q: &[f64], gradient: &mut [f64]) -> vibroimpact::Result<()> {
        gradient[0] = -1.0;
        Ok(())
    }
}

#[test]
fn what_has_no_series_is_refused_by_name_and_gets_steps_by_default() {
    let linear = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let given = link(vec![NonlinearStop::new(Plane, 0.5).expect("valid").into()]);
    for (scene, n, counts_steps) in [(&linear, 2, false), (&given, 1, true)] {
        let zero = DVector::zeros(n);
        let refused =
            simulate(scene, &zero, &zero, (0.0, 1.0), &taylor(1e-9)).expect_err("no series");
        assert!(refused.to_string().contains("method"), "{refused}");
        let run =
            simulate(scene, &zero, &zero, (0.0, 1.0), &SimulateOptions::default()).expect("runs");
        assert_eq!(run.stats().n_steps > 0, counts_steps);
        assert!(!plan(scene).expect("a plan").contains("Taylor"));
    }
    let free = link(vec![]);
    assert!(plan(&free).expect("a plan").contains("Taylor series"));
    let run = run(&free, &[0.1], &[0.0], 10.0, &SimulateOptions::default());
    assert!(run.stats().n_steps > 1 && run.stats().n_gap_evaluations == 0);
}

#[test]
fn speeds_beyond_the_doubles_end_the_run() {
    let run = run(&link(vec![]), &[0.3], &[1e60], 1.0, &taylor(1e-9));
    assert_eq!(run.status(), vibroimpact::Status::StepUnderflow);
    assert_eq!(run.last().0[0], 0.3);
}

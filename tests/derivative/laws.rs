//! Derivatives of runs in closed form.

use crate::own::Own;
use crate::scenes::{linear, loaded, oscillator, scene, upper};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    BaseMotion, Forcing, Harmonic, Load, Motion, NonlinearSystem, Parameter, PendulumChain, Scene,
    SegmentKind, Signal, SimulateOptions, Solver, StopMotion, System, Trajectory, Wall, WallSide,
    derivatives_of_run, simulate,
};

fn run(scene: &Scene, q: &[f64], v: &[f64], span: (f64, f64)) -> Trajectory {
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-14),
            ..Solver::default()
        },
        ..SimulateOptions::default()
    };
    let [q, v] = [q, v].map(DVector::from_row_slice);
    simulate(scene, &q, &v, span, &options).expect("a run")
}

/// Masses `((2, 1), (1, 2))`, of which a constant force f pushes the first onto a stop at c, where it stays: with f t1^2/3 + t1 = c and
/// `v+ = (0, v1 + v0/2)`, q1 = -f t1^2/6 + (v1 + v0/2)(T - t1), so that `dq1/dc = (v1- - v1+)/v0- = -1/2` and `dv1/dc = 0`.
#[test]
fn a_mass_that_lands_takes_the_other_along() {
    let mass = dmatrix![2.0, 1.0; 1.0, 2.0];
    let zero = DMatrix::zeros(2, 2);
    let exact: System = loaded(
        linear(mass.clone(), zero.clone(), zero.clone()),
        &[0.6, 0.0],
    )
    .into();
    let own = Own {
        mass,
        damping: zero.clone(),
        stiffness: zero,
        load: dvector![0.6, 0.0],
    };
    let integrated: System = NonlinearSystem::new(own).expect("valid").into();
    for system in [exact, integrated] {
        let all = scene(system, Forcing::Unforced, [upper(0, 0.5, 0.0)]);
        let run = run(&all, &[0.0, 0.0], &[1.0, 0.0], (0.0, 3.0));
        let found = derivatives_of_run(&run, &[Parameter::CLEARANCE], &[1.0, 3.0]);
        let found = found.expect("an answer");
        for row in found.by[0].row_iter() {
            let off = row - dvector![1.0, -0.5, 0.0, 0.0].transpose();
            assert!(off.amax() < 1e-9, "{found:?}");
        }
    }
}

/// The same on a stop that moves, which carries what lies on it, `q0 = c + A cos(w t + phase)`. Nothing acts on the second row, `q0'' + 2 q1'' = 0`,
/// so that `q1 + q0/2` does not know of the stop, wherever it is and however it moves.
#[test]
fn a_mass_that_lands_on_a_moving_stop_takes_the_other_along() {
    let zero = DMatrix::zeros(2, 2);
    let system = loaded(
        linear(dmatrix![2.0, 1.0; 1.0, 2.0], zero.clone(), zero),
        &[6.0, 0.0],
    );
    let motion = Harmonic::new(dvector![0.1.into()], 1.3, 0.4).expect("valid");
    let stop = upper(0, 0.5, 0.0).with_motion(Some(StopMotion::harmonic(motion).expect("valid")));
    let all = scene(system, Forcing::Unforced, [stop]);
    let run = run(&all, &[0.0, 0.0], &[1.0, 0.0], (0.0, 2.0));
    let found = derivatives_of_run(&run, &[Parameter::CLEARANCE, Parameter::Frequency], &[2.0]);
    let found = found.expect("an answer");
    for by in &found.by {
        assert!((by[(0, 1)] + 0.5 * by[(0, 0)]).abs() < 1e-9, "{found:?}");
        assert!((by[(0, 3)] + 0.5 * by[(0, 2)]).abs() < 1e-9, "{found:?}");
    }
    assert!((found.by[0][(0, 0)] - 1.0).abs() < 1e-12);
    let (t, w) = (2.0f64, 1.3f64);
    let [position, speed] = [
        -0.1 * t * (w * t + 0.4).sin(),
        -0.1 * (w * t + 0.4).sin() - 0.1 * w * t * (w * t + 0.4).cos(),
    ];
    assert!((found.by[1][(0, 0)] - position).abs() < 1e-9, "{found:?}");
    assert!((found.by[1][(0, 2)] - speed).abs() < 1e-9, "{found:?}");
}

/// A coordinate that no stop touches does not know where the stops are, nor how elastic.
#[test]
fn a_coordinate_by_itself_has_no_derivatives_by_what_another_hits() {
    let t: Vec<f64> = (0..40).map(|k| 0.25 * f64::from(k)).collect();
    let values: Vec<f64> = t.iter().map(|t| (2.9 * t * t).cos()).collect();
    let signal = Signal::samples(&t, &values).expect("valid");
    let load: Forcing = Load::new(dvector![1.0, 1.0], signal).expect("valid").into();
    let tone: Forcing = Harmonic::new(dvector![1.0.into(), 0.7.into()], 2.3, 0.1)
        .expect("valid")
        .into();
    let two = dvector![1.0, 1.0];
    for forcing in [Forcing::Unforced, tone, load] {
        for restitution in [0.0, 0.3, 0.6, 0.8] {
            let system = linear(two.clone(), dvector![0.1, 0.05], dvector![1.0, 3.0]);
            let all = scene(
                loaded(system, &[5.0, 0.3]),
                forcing.clone(),
                [upper(0, 0.4, restitution)],
            );
            let run = run(&all, &[0.0, 0.2], &[1.0, 0.5], (0.0, 9.0));
            let segments = run.segments().expect("kept");
            assert!(segments.iter().any(|own| own.kind == SegmentKind::Stick));
            let numbers = [Parameter::CLEARANCE, Parameter::RESTITUTION];
            let found = derivatives_of_run(&run, &numbers, &[8.1, 9.0]).expect("an answer");
            assert_eq!(found.reason, None);
            for by in &found.by {
                for coordinate in [1, 3] {
                    let own = by.column(coordinate).amax();
                    // Rounding of one, 2e-16, over the shortest step of a difference, 1e-6 of 1 - e = 0.2.
                    assert!(own < 1e-9, "{restitution} {own:e}");
                }
            }
        }
    }
}

/// A free mass under `F cos(w t + phase)`, from some time on.
#[test]
fn a_frequency_is_felt_by_the_angle_that_has_turned() {
    let (force, w, phase) = (1.5, 7.0f64, 0.4);
    let zero = dvector![0.0];
    for start in [0.0f64, 1000.0, -1000.0] {
        for is_integrated in [false, true] {
            let t = 4.0f64;
            let harmonic = || Harmonic::new(dvector![force.into()], w, phase).expect("valid");
            let free = scene(
                linear(dvector![1.0], zero.clone(), zero.clone()),
                harmonic(),
                [upper(0, 50.0, 0.5)],
            );
            let all = if is_integrated {
                let own = Own {
                    mass: dmatrix![1.0],
                    damping: dmatrix![0.0],
                    stiffness: dmatrix![0.0],
                    load: dvector![0.0],
                };
                let system = NonlinearSystem::new(own).expect("valid");
                scene(system, harmonic(), [upper(0, 50.0, 0.5)])
            } else {
                free
            };
            let run = run(&all, &[0.3], &[1.0], (start, start + t));
            let end = run.span().1;
            let found = derivatives_of_run(&run, &[Parameter::Frequency], &[end]);
            let found = found.expect("an answer");
            let (a, b) = (w * start + phase, w * end + phase);
            // v = v0 + F (sin b - sin a)/w, q = q0 + v0 t - F (cos b - cos a)/w^2 - F t sin(a)/w
            let v = force * ((end * b.cos() - start * a.cos()) / w - (b.sin() - a.sin()) / (w * w));
            let q = force
                * ((end * b.sin() - start * a.sin()) / (w * w)
                    + 2.0 * (b.cos() - a.cos()) / w.powi(3)
                    - t * start * a.cos() / w
                    + t * a.sin() / (w * w));
            let off = (found.by[0][(0, 0)] - q)
                .abs()
                .max((found.by[0][(0, 1)] - v).abs());
            let size = start.abs().max(1.0);
            // An angle far off is known to its rounding, of which the step is a thousandth.
            assert!(
                off < 1e-8 * size,
                "{start} {is_integrated}: {off:e} of {q:e} {v:e}"
            );
        }
    }
}

/// Tones of which one is ten times as fast, and one has no common period with them.
#[test]
fn two_tones_far_from_zero() {
    let tone = |force: f64, w: f64| Harmonic::new(dvector![force.into()], w, 0.2).expect("valid");
    let two = |ratio: f64| {
        Forcing::Several(vec![
            tone(2.0, 1.3 * ratio).into(),
            tone(1.0, 13.0 * ratio).into(),
            tone(0.5, 4.7 * ratio).into(),
        ])
    };
    let own = oscillator(0.1, two(1.0), [upper(0, 40.0, 0.8)]);
    let (start, end) = (1000.0, 1003.0);
    let run_of = |own: &Scene| run(own, &[0.1], &[0.2], (start, end));
    let found = derivatives_of_run(&run_of(&own), &[Parameter::Frequency], &[end]);
    let found = found.expect("an answer");
    // Fourth order over 1e-3 of the fastest angle.
    let h = 1e-3 / (10.0 * end);
    let at = |steps: f64| {
        let beside = oscillator(0.1, two(1.0 + steps * h), [upper(0, 40.0, 0.8)]);
        let run = run_of(&beside);
        let (q, v) = run.last();
        dvector![q[0], v[0]]
    };
    let wanted = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h * 1.3);
    let off = (found.by[0].row(0).transpose() - &wanted).amax();
    assert!(off < 1e-7 * wanted.amax(), "{off:e} of {wanted}");
}

/// Whole periods later a motion is the same, and its derivative by the frequency is larger by as many periods times that by the phase: it goes in a
/// straight line with their number.
#[test]
fn whole_periods_later_it_is_larger_by_as_much_for_each() {
    let w = 3.7;
    let at = |periods: f64| {
        let damping = dvector![0.05, 0.1];
        let two = dvector![1.0, 0.8];
        let chain = PendulumChain::new(two.clone(), two, &damping, 9.81).expect("valid");
        let base = BaseMotion::new(0.1, w, 0.4).expect("valid");
        let wall = Wall::new(1, 0.1, 0.6, WallSide::Right).expect("valid");
        let all = scene(chain, base, [wall]);
        let start = periods * TAU / w;
        let run = run(&all, &[-0.4, -0.5], &[0.5, 1.0], (start, start + 2.0));
        assert!(!run.impacts().is_empty());
        let found = derivatives_of_run(&run, &[Parameter::Frequency], &[run.span().1]);
        found.expect("an answer").by[0].row(0).transpose()
    };
    for periods in [1.0, 500.0, -500.0] {
        let [none, one, two] = [0.0, periods, 2.0 * periods].map(at);
        let off = (&two - &one * 2.0 + &none).amax();
        assert!(off < 1e-7 * two.amax(), "{periods}: {off:e} of {two}");
    }
}

//! Derivatives of runs: against runs beside, and by laws.

use crate::random::Random;
use crate::scenes::{
    harmonic, linear, loaded, lower, oscillator, scene, shaken_ball, unit_mass, upper,
};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    Constraint, Forcing, Harmonic, ImpactSide, Keep, Load, Motion, Parameter, PendulumChain, Ramp,
    RampProfile, Scene, SegmentKind, Signal, SimulateOptions, Solver, StopMotion, StopNumber,
    Trajectory, Wall, WallSide, derivatives_of_run, simulate,
};

fn run_of(scene: &Scene, q: &DVector<f64>, v: &DVector<f64>, end: f64) -> Trajectory {
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-14),
            ..Solver::default()
        },
        ..SimulateOptions::default()
    };
    simulate(scene, q, v, (0.0, end), &options).expect("a run")
}

/// A wall has none.
fn has_clearance(scene: &Scene) -> bool {
    matches!(scene.stops()[0], Constraint::Stop(_))
}

/// What happens along a run: the stops of its impacts, its segments.
fn course(run: &Trajectory) -> (Vec<usize>, usize) {
    let stops = run.impacts().iter().map(|own| own.stop).collect();
    (stops, run.segments().expect("kept").len())
}

/// The worst deviation of derivatives from differences of runs, in parts of the largest there; none where runs beside are others.
fn off(
    base: &Scene,
    parameter: Parameter,
    (q, v): (&DVector<f64>, &DVector<f64>),
    times: &[f64],
    step: f64,
) -> Option<f64> {
    let end = times[times.len() - 1];
    let run = run_of(base, q, v, end);
    let found = derivatives_of_run(&run, &[parameter], times).expect("derivatives");
    assert_eq!(found.reason, None);
    let mut sum = DMatrix::zeros(times.len(), 2 * q.len());
    for (steps, weight) in [
        (1.0, 8.0 / 12.0),
        (-1.0, -8.0 / 12.0),
        (2.0, -1.0 / 12.0),
        (-2.0, 1.0 / 12.0),
    ] {
        let stop = |i: usize| match &base.stops()[i] {
            Constraint::Stop(stop) => stop,
            other => panic!("{other:?}"),
        };
        let value = match parameter {
            Parameter::RESTITUTION if !has_clearance(base) => 0.8,
            Parameter::CLEARANCE => stop(0).clearance(),
            Parameter::RESTITUTION => stop(0).restitution().expect("rigid").value(),
            Parameter::Frequency => TAU / base.period().expect("one"),
            Parameter::OneStop(StopNumber::Clearance, i) => stop(i).clearance(),
            Parameter::OneStop(StopNumber::Restitution, i) => {
                stop(i).restitution().expect("rigid").value()
            }
            _ => 1.0,
        };
        let there = base
            .replace(parameter.change(value + steps * step))
            .expect("valid");
        let beside = run_of(&there, q, v, end);
        if course(&beside) != course(&run) {
            return None;
        }
        for (i, &t) in times.iter().enumerate() {
            let (q, v) = beside.state(t, ImpactSide::After).expect("kept");
            let x = DVector::from_iterator(2 * q.len(), q.iter().chain(v.iter()).copied());
            let row = x.transpose() * (weight / step);
            sum.set_row(i, &(sum.row(i) + row));
        }
    }
    Some((&sum - &found.by[0]).amax() / sum.amax().max(1.0))
}

/// Times that are no impacts.
fn between_impacts(run: &Trajectory, count: usize, end: f64) -> Vec<f64> {
    let near = |t: f64| run.impacts().iter().any(|own| (own.time - t).abs() < 1e-2);
    let all = (1..=count).map(|k| end * k as f64 / count as f64);
    all.filter(|&t| !near(t)).collect()
}

#[test]
fn they_are_the_differences_of_runs_beside() {
    let mut compared = 0;
    for case in 0..60 {
        let mut random = Random::of_case(77, case);
        let n = 1 + random.below(3);
        let k = random.matrix(n);
        let stiffness = &k * k.transpose() + DMatrix::identity(n, n);
        let damping = &stiffness * random.between(0.0, 0.1);
        let system = linear(DMatrix::<f64>::identity(n, n), damping, stiffness);
        let force: Vec<f64> = random.vector(n).iter().map(|x| 3.0 * x).collect();
        let w = random.between(0.6, 3.0);
        let stops = [
            upper(
                random.below(n),
                random.between(0.2, 0.8),
                random.between(0.3, 0.95),
            ),
            lower(
                random.below(n),
                random.between(0.2, 0.8),
                random.between(0.3, 0.95),
            ),
        ];
        let own = scene(system, harmonic(&force, w, random.between(0.0, TAU)), stops);
        let (q, v) = (random.vector(n) * 0.1, random.vector(n));
        let end = random.between(3.0, 8.0);
        let run = run_of(&own, &q, &v, end);
        let times = between_impacts(&run, 7, end);
        if times.last() != Some(&end) {
            continue;
        }
        for parameter in [
            Parameter::Frequency,
            Parameter::ForcingScale,
            Parameter::DampingScale,
            Parameter::CLEARANCE.of(0),
            Parameter::RESTITUTION.of(1),
        ] {
            if let Some(off) = off(&own, parameter, (&q, &v), &times, 1e-5) {
                assert!(off < 3e-7, "{case} {parameter}: {off:e}");
                compared += 1;
            }
        }
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn a_motion_twice_as_large_is_one_of_twice_the_force_and_clearance() {
    // Chaos: F dx/dF + d dx/dd = x of a motion from rest, whatever its deviations grow to.
    let own = oscillator(0.1, harmonic(&[5.0], 2.4, 0.0), [upper(0, 1.0, 0.8)]);
    let zero = dvector![0.0];
    let run = simulate(
        &own,
        &zero,
        &zero,
        (0.0, 150.0),
        &SimulateOptions::default(),
    );
    let run = run.expect("a run");
    assert!(run.impacts().len() > 30);
    let times: Vec<f64> = (1..=300).map(|k| 0.5 * f64::from(k)).collect();
    let both = [Parameter::ForcingScale, Parameter::CLEARANCE];
    let found = derivatives_of_run(&run, &both, &times).expect("derivatives");
    assert_eq!(found.reason, None);
    let mut largest = 0.0f64;
    for (i, &t) in times.iter().enumerate() {
        let (q, v) = run.state(t, ImpactSide::After).expect("kept");
        let sum = found.by[0].row(i) + found.by[1].row(i);
        let grown = found.by[0].row(i).amax();
        largest = largest.max(grown);
        let off = (sum[0] - q[0]).abs().max((sum[1] - v[0]).abs());
        assert!(off < 1e-8 * grown.max(1.0), "{t}: {off:e} of {grown:e}");
    }
    assert!(largest > 1e4, "{largest:e}");
}

#[test]
fn they_go_through_chatter_and_lasting_contact() {
    // A ball on a shaken table, which chatters to rest and is thrown up again.
    let own = shaken_ball(0.5, 1.3, 0.0);
    let (q, v) = (dvector![0.3], dvector![0.0]);
    let run = run_of(&own, &q, &v, 20.0);
    let kinds: Vec<_> = run
        .segments()
        .expect("kept")
        .iter()
        .map(|own| own.kind)
        .collect();
    assert!(kinds.len() > 6, "{kinds:?}");
    let times = [0.5, 4.0, 9.0, 10.5, 16.0, 20.0];
    for parameter in [
        Parameter::ForcingScale,
        Parameter::Frequency,
        Parameter::RESTITUTION.of(0),
        Parameter::CLEARANCE.of(0),
    ] {
        let off = off(&own, parameter, (&q, &v), &times, 1e-5).expect("runs alike");
        assert!(off < 1e-6, "{parameter}: {off:e}");
    }
    // While it is held it goes with the table.
    let held =
        derivatives_of_run(&run, &[Parameter::CLEARANCE.of(0)], &[5.0]).expect("derivatives");
    assert!(
        (held.by[0][(0, 0)].abs() - 1.0).abs() < 1e-12 && held.by[0][(0, 1)].abs() < 1e-12,
        "{held:?}"
    );
}

#[test]
fn any_excitation_and_any_system() {
    let tone = |force: f64, w: f64| Harmonic::new(dvector![force.into()], w, 0.2).expect("valid");
    let (q, v) = (&dvector![0.0], &dvector![0.3]);
    let times = [0.7, 2.9, 7.3, 9.1];
    // Two tones without a common period.
    let two = Forcing::Several(vec![tone(2.0, 1.3).into(), tone(1.0, 2.97).into()]);
    let incommensurate = oscillator(0.1, two, [upper(0, 0.4, 0.8)]);
    // A load that follows samples, which have corners.
    let t: Vec<f64> = (0..40).map(|k| 0.25 * f64::from(k)).collect();
    let values: Vec<f64> = t.iter().map(|t| 2.0 * (1.7 * t).cos()).collect();
    let signal = Signal::samples(&t, &values).expect("valid");
    let load = Load::new(0, signal).expect("valid");
    let measured = oscillator(0.1, Forcing::Load(load), [upper(0, 0.4, 0.8)]);
    // A stop that moves.
    let motion = Harmonic::new(dvector![0.1.into()], 2.0, 0.0).expect("valid");
    let motion = StopMotion::harmonic(motion).expect("valid");
    let stop = upper(0, 0.4, 0.8).with_motion(Some(motion));
    let moving = oscillator(0.1, harmonic(&[2.0], 1.0, 0.0), [stop]);
    // A pendulum before a wall, which is integrated.
    let pendulum = PendulumChain::new(dvector![1.0], dvector![1.0], &dvector![0.1], 1.0);
    let wall = Wall::new(0, 0.3, 0.8, WallSide::Right).expect("valid");
    let swung = Scene::new(pendulum.expect("valid"), harmonic(&[1.0], 1.4, 0.0), [wall]);
    for (k, own) in [incommensurate, measured, moving, swung.expect("valid")]
        .iter()
        .enumerate()
    {
        let run = run_of(own, q, v, 9.1);
        assert!(run.impacts().len() > 1, "{k}");
        for parameter in [
            Parameter::ForcingScale,
            Parameter::DampingScale,
            Parameter::CLEARANCE,
            Parameter::RESTITUTION,
        ] {
            if parameter == Parameter::CLEARANCE && !has_clearance(own) {
                continue;
            }
            let off = off(own, parameter, (q, v), &times, 1e-5).expect("runs alike");
            assert!(off < 1e-6, "{k} {parameter}: {off:e}");
        }
    }
}

#[test]
fn where_there_are_none_it_says_so() {
    let clearance = [Parameter::CLEARANCE];
    let zero = dvector![0.0];
    let none = |own: &Scene, q: f64, v: f64, end: f64, times: &[f64]| {
        let run = run_of(own, &dvector![q], &dvector![v], end);
        derivatives_of_run(&run, &clearance, times).expect("an answer")
    };
    // A touch: free, q = sin t before a stop at one.
    let touched = oscillator(0.0, Forcing::Unforced, [upper(0, 1.0, 0.5)]);
    let found = none(&touched, 0.0, 1.0, 5.0, &[1.0, 4.0]);
    assert!(found.by[0][(0, 0)] == 0.0 && found.by[0][(1, 0)].is_nan());
    assert!(found.reason.expect("one").contains("grazes stop 0"));
    // Two stops at one instant.
    let two = oscillator(
        0.0,
        Forcing::Unforced,
        [upper(0, 0.5, 0.5), upper(0, 0.5, 0.8)],
    );
    let found = none(&two, 0.0, 1.0, 3.0, &[0.1, 2.0]);
    assert!(found.by[0][(0, 0)] == 0.0 && found.by[0][(1, 0)].is_nan());
    assert!(found.reason.expect("one").contains("together"));
    // On the stop from the beginning.
    let found = none(&touched, 1.0, 0.0, 1.0, &[0.5]);
    assert!(found.by[0][(0, 0)].is_nan());
    assert!(found.reason.expect("one").contains("begins in contact"));
    // Within impacts that accumulate, and behind them.
    let ball = shaken_ball(0.5, 0.0, 0.0);
    let run = run_of(&ball, &dvector![1.0], &zero, 10.0);
    let chatter = run.segments().expect("kept");
    let chatter = chatter
        .iter()
        .find(|own| own.kind == SegmentKind::Chatter)
        .expect("one");
    let middle = 0.5 * (chatter.start + chatter.end);
    let found =
        derivatives_of_run(&run, &[Parameter::RESTITUTION], &[middle, 9.0]).expect("an answer");
    assert!(
        found.by[0][(0, 0)].is_nan() && found.by[0].row(1).amax() < 1e-12,
        "{found:?}"
    );
    // What is no argument.
    let run = run_of(&touched, &zero, &dvector![0.5], 5.0);
    for (parameter, times, word) in [
        (Parameter::Phase, vec![1.0], "shifts time alone"),
        (
            Parameter::CLEARANCE.of(3),
            vec![1.0],
            "a number that the scene",
        ),
        (Parameter::CLEARANCE, vec![6.0], "span of the run"),
        (Parameter::CLEARANCE, vec![f64::NAN], "span of the run"),
    ] {
        let text = derivatives_of_run(&run, &[parameter], &times)
            .expect_err("refused")
            .to_string();
        assert!(text.contains(word), "{text}");
    }
    let forgotten = SimulateOptions {
        keep: Keep::Final,
        ..SimulateOptions::default()
    };
    let run = simulate(&touched, &zero, &dvector![0.5], (0.0, 5.0), &forgotten).expect("a run");
    let text = derivatives_of_run(&run, &clearance, &[1.0])
        .expect_err("forgotten")
        .to_string();
    assert!(text.contains("keep"), "{text}");
    let ramp = Ramp::new(Parameter::CLEARANCE, 2.0, RampProfile::Over(3.0)).expect("valid");
    let drifting = SimulateOptions {
        ramps: vec![ramp],
        ..SimulateOptions::default()
    };
    let run = simulate(&touched, &zero, &dvector![0.5], (0.0, 5.0), &drifting).expect("a run");
    let text = derivatives_of_run(&run, &clearance, &[1.0])
        .expect_err("drifting")
        .to_string();
    assert!(text.contains("ramp"), "{text}");
}

#[test]
fn a_mass_that_is_held_from_an_impact_on_keeps_its_tangential_speed() {
    // Masses that are coupled: to first order in e the bounces give what the contact force gives without them.
    let mass = dmatrix![1.0, 0.3; 0.3, 1.0];
    let stiffness = dmatrix![2.0, -1.0; -1.0, 2.0];
    let system = loaded(
        linear(mass, dmatrix![0.0, 0.0; 0.0, 0.0], stiffness),
        &[3.0, 0.0],
    );
    let own = scene(system, Forcing::Unforced, [upper(0, 0.5, 0.0)]);
    let run = run_of(&own, &dvector![0.0, 0.0], &dvector![1.0, 0.0], 1.5);
    let found = derivatives_of_run(&run, &[Parameter::RESTITUTION], &[1.5]).expect("an answer");
    assert!(found.by[0].amax() < 1e-9, "{found:?}");
}

#[test]
fn impacts_accumulate_on_moving_stops_and_under_any_damping() {
    let motion = Harmonic::new(dvector![0.1.into()], 1.44, 0.3).expect("valid");
    let motion = StopMotion::harmonic(motion).expect("valid");
    for restitution in [0.3, 0.5, 0.7] {
        let stop = upper(0, 0.5, restitution).with_motion(Some(motion.clone()));
        let own = scene(
            loaded(unit_mass(0.0, 0.0), &[1.0]),
            Forcing::Unforced,
            [stop],
        );
        let zero = &dvector![0.0];
        let times = [0.5, 4.0, 5.0, 7.9];
        let off = off(&own, Parameter::Frequency, (zero, zero), &times, 1e-4);
        assert!(off.expect("runs alike") < 1e-5, "{restitution} {off:?}");
    }
    let mass = dmatrix![1.72, 0.17, 0.67; 0.17, 1.1, 0.28; 0.67, 0.28, 1.86];
    let damping = dmatrix![0.08, -0.03, -0.08; 0.09, 0.05, -0.11; -0.14, -0.14, 0.2];
    let system = linear(mass, damping, DMatrix::zeros(3, 3));
    for restitution in [0.2, 0.3, 0.4, 0.5] {
        let own = scene(
            loaded(system.clone(), &[-1.0, -1.0, 0.3]),
            Forcing::Unforced,
            [lower(0, 0.2, restitution)],
        );
        let (q, v) = (&dvector![-0.1, 0.05, -0.1], &dvector![0.0, -2.0, 0.5]);
        for parameter in [Parameter::RESTITUTION.of(0), Parameter::DampingScale] {
            let off = off(&own, parameter, (q, v), &[0.3, 3.0], 1e-5);
            assert!(
                off.is_none_or(|off| off < 1e-5),
                "{restitution} {parameter} {off:?}"
            );
        }
    }
}

#[test]
fn signals_of_any_size_take_as_long() {
    let of = |size: f64| {
        let signal = Signal::samples(&[0.5, 2.0, 3.0], &[0.0, 1.5 * size, -size]).expect("valid");
        let load = Load::new(0, signal).expect("valid");
        let system = linear(dvector![1.0, 1.0], dvector![0.1, 0.1], dvector![1.0, 2.0]);
        let own = scene(system, Forcing::Load(load), [upper(0, 0.5 * size, 0.6)]);
        let start = &dvector![size, size];
        let run = run_of(&own, &DVector::zeros(2), start, 9.0);
        derivatives_of_run(&run, &[Parameter::RESTITUTION], &[9.0])
            .expect("an answer")
            .by[0]
            .clone()
            / size
    };
    let one = of(1.0);
    for size in [1e-8, 1e6, 1e9] {
        let off = (of(size) - &one).amax() / one.amax();
        assert!(off < 1e-7, "{size:e}: {off:e}");
    }
}

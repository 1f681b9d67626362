//! Numbers of a scene that drift along a run: angles go on, what is kept comes back, the laws of mechanics hold along all chapters.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::rc::Rc;
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Error, ImpactSide, Keep, LinearSystem, Motion, Parameter, Ramp, RampLaw, RampProfile, Scene,
    Side, SimulateOptions, Status, Stop, Trajectory, plan_under, simulate, with_observer,
};
use vibroimpact::{Harmonic, Method};

fn scene() -> Scene {
    let damping = dmatrix![0.2, 0.03; 0.05, 0.15];
    let stiffness = dmatrix![9.0, -2.0; -2.0, 5.0];
    let system = LinearSystem::new(dmatrix![2.0, 0.3; 0.3, 1.0], damping, stiffness);
    let force = Harmonic::new(dvector![0.8.into(), 0.3.into()], 1.2, 0.4);
    let stops = [
        Stop::new(0, 0.2, 0.8).expect("valid"),
        Stop::new(1, 0.25, 0.6).expect("valid").on_side(Side::Lower),
    ];
    Scene::new(system.expect("valid"), force.expect("valid"), stops).expect("valid")
}

fn ramp(parameter: Parameter, to: f64, profile: RampProfile) -> Ramp {
    Ramp::new(parameter, to, profile).expect("valid")
}

const LEVELS: RampProfile = RampProfile::Steps {
    levels: 5,
    dwell: 2.25,
};

fn ways() -> Vec<Vec<Ramp>> {
    let up = |profile| ramp(Parameter::Frequency, 2.0, profile);
    vec![
        vec![up(RampProfile::Rate(0.03))],
        vec![up(RampProfile::Over(25.0)).with_law(RampLaw::Log)],
        vec![up(LEVELS)],
        vec![
            up(RampProfile::Rate(0.03)),
            ramp(Parameter::RESTITUTION.of(0), 0.3, LEVELS),
            ramp(Parameter::CLEARANCE.of(1), 0.1, RampProfile::Over(17.0)),
        ],
        vec![
            ramp(Parameter::Phase, 3.0, RampProfile::Over(11.0)),
            ramp(Parameter::ForcingScale, 2.0, RampProfile::Over(30.0)),
        ],
        vec![ramp(Parameter::DampingScale, 2.0, RampProfile::Over(20.0))],
    ]
}

fn run(ramps: Vec<Ramp>, keep: Keep) -> Trajectory {
    let options = SimulateOptions {
        ramps,
        keep,
        ..SimulateOptions::default()
    };
    let rest = DVector::zeros(2);
    simulate(&scene(), &rest, &rest, (0.0, 40.0), &options).expect("a run")
}

#[test]
fn what_is_kept_comes_back() {
    for ramps in ways() {
        for keep in [Keep::Motion, Keep::Impacts, Keep::Final] {
            let run = run(ramps.clone(), keep);
            let again = Trajectory::restore(run.scene(), run.save()).expect("its own numbers");
            assert_eq!(again.save(), run.save(), "{ramps:?}");
            let values = |run: &Trajectory| {
                let times = [0.0, 13.0, 40.0];
                times.map(|t| {
                    run.parameter(t, Some(ramps[0].parameter()))
                        .expect("a ramp")
                })
            };
            assert_eq!(values(&again), values(&run));
        }
    }
}

#[test]
fn the_state_and_the_angle_go_on_and_the_ledgers_close() {
    for ramps in ways() {
        let run = run(ramps.clone(), Keep::Motion);
        assert_eq!(run.status(), Status::Finished);
        // Each turn of the forcing takes its own time: the angle never jumps.
        let mut before = run.phase(0.0).expect("inside");
        for k in 1..=4000 {
            let phase = run.phase(f64::from(k) * 0.01).expect("inside");
            let turned = (phase - before).rem_euclid(std::f64::consts::TAU);
            let slowest = if ramps[0].parameter() == Parameter::Phase {
                0.01
            } else {
                0.0115
            };
            assert!((slowest..0.03).contains(&turned), "{ramps:?} {k} {turned}");
            before = phase;
        }
        let energy = run.energy().expect("kept");
        let most = energy.kinetic.iter().fold(0.0, |most: f64, x| most.max(*x));
        let open = energy
            .balance
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(open < 1e-7 * most, "{ramps:?}: {open:e}");
        // Both sides of every border of chapters have one state.
        let saved = run.save();
        for (start, _, _) in &saved.chapters[1..] {
            let [a, b] =
                [ImpactSide::Before, ImpactSide::After].map(|side| run.state(*start, side));
            let (a, b) = (a.expect("inside"), b.expect("inside"));
            assert!((a.0 - b.0).amax() < 1e-13 && (a.1 - b.1).amax() < 1e-13);
        }
    }
}

#[test]
fn levels_are_runs_one_after_another() {
    let numbers = [
        (Parameter::DampingScale, [1.0, 3.0]),
        (Parameter::ForcingScale, [1.0, 2.0]),
        (Parameter::RESTITUTION.of(0), [0.8, 0.3]),
        (Parameter::CLEARANCE.of(1), [0.25, 0.35]),
    ];
    let dwell = 2.25 * scene().period().expect("one force");
    for (parameter, [from, to]) in numbers {
        let whole = run(vec![ramp(parameter, to, LEVELS)], Keep::Final);
        let rest = DVector::zeros(2);
        let (mut q, mut v, mut start) = (rest.clone(), rest, 0.0);
        for k in 0..5 {
            let scene = scene().replace(parameter.change(from + (to - from) * f64::from(k) / 4.0));
            let end = (dwell * f64::from(k + 1)).min(40.0);
            let options = SimulateOptions::default();
            let part = simulate(&scene.expect("valid"), &q, &v, (start, end), &options);
            let part = part.expect("a run");
            (q, v) = (part.last().0.clone(), part.last().1.clone());
            start = end;
        }
        let (q_end, v_end) = whole.last();
        let off = (q_end - q).amax().max((v_end - v).amax());
        assert!(off < 1e-11, "{parameter:?}: {off:e}");
    }
}

#[test]
fn levels_beside_a_frequency_that_drifts_last_their_turns() {
    // `w0 t + r t^2/2` is 2.25 turns at the end of the first level, and so on.
    let (w0, rate) = (1.2, 0.03);
    let up = ramp(Parameter::Frequency, 9.0, RampProfile::Rate(rate));
    let saved = run(
        vec![up, ramp(Parameter::RESTITUTION.of(0), 0.3, LEVELS)],
        Keep::Motion,
    )
    .save();
    for k in 1..5 {
        let angle = 2.25 * std::f64::consts::TAU * f64::from(k);
        let then = 2.0 * angle / (w0 + (w0 * w0 + 2.0 * rate * angle).sqrt());
        let is_then = |chapter: &(f64, f64, usize)| (chapter.0 - then).abs() < 1e-12 * then;
        assert!(
            saved.chapters.iter().any(is_then),
            "{k}: {then} {:?}",
            saved.chapters
        );
    }
}

#[test]
fn chapters_that_are_not_those_of_the_ramps_are_refused() {
    let run = run(ways().swap_remove(2), Keep::Motion);
    let spoilt = |spoil: &dyn Fn(&mut vibroimpact::SavedTrajectory)| {
        let mut saved = run.save();
        spoil(&mut saved);
        Trajectory::restore(run.scene(), saved)
            .expect_err("spoilt")
            .to_string()
    };
    for message in [
        spoilt(&|s| s.chapters[1].0 += 0.1),
        spoilt(&|s| {
            s.chapters.pop();
        }),
        spoilt(&|s| s.chapters.clear()),
        spoilt(&|s| s.chapters[2].2 = usize::MAX),
        spoilt(&|s| s.ramps.0.clear()),
    ] {
        assert!(
            message.starts_with("the chapters of the saved trajectory"),
            "{message}"
        );
    }
}

#[test]
fn a_method_that_cannot_follow_says_so() {
    let refused = |ramps: Vec<Ramp>, method: Method| {
        let options = SimulateOptions {
            solver: method.into(),
            ramps,
            ..SimulateOptions::default()
        };
        let rest = DVector::zeros(2);
        let run = simulate(&scene(), &rest, &rest, (0.0, 1.0), &options);
        run.expect_err("refused").to_string()
    };
    let [frequency, damping] = [ways().swap_remove(0), ways().swap_remove(5)];
    let message = refused(frequency.clone(), Method::Exact);
    assert!(message.starts_with("ramp of \"frequency\" is continuous, but exact flights cannot"));
    assert!(refused(damping, Method::Taylor).contains("series cannot follow"));
    let plan = plan_under(&scene(), &frequency).expect("linear");
    assert!(plan.ends_with("to 1e-14 (method \"taylor\")"), "{plan}");
}

/// Long ramps are laid out in many pieces before the run begins: who observes it is asked meanwhile.
#[test]
fn whoever_observes_a_run_is_asked_while_its_ramp_is_laid_out() {
    let options = SimulateOptions {
        ramps: vec![ramp(Parameter::Frequency, 2.0, RampProfile::Over(3e4))],
        keep: Keep::Final,
        ..SimulateOptions::default()
    };
    let (rest, asked) = (dvector![0.0, 0.0], Rc::new(Cell::new(0)));
    let count = Rc::clone(&asked);
    let observer = move |part: f64| {
        count.set(count.get() + 1);
        if part > 0.0 || count.get() > 40 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let run = || simulate(&scene(), &rest, &rest, (0.0, 3e4), &options);
    let run = with_observer(observer, run);
    assert_eq!(run.expect_err("broken off"), Error::Interrupted);
    assert_eq!(asked.get(), 41, "asked before the run has begun");
}

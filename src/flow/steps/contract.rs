#![cfg(test)]
//! What every [`Stepper`] must keep, whoever it is.

use crate::error::Result;
use crate::flow::steps::chosen::{ChosenSteps, StepChoice};
use crate::flow::steps::control::Controller;
use crate::flow::steps::dense_output::DenseOutput;
use crate::flow::steps::dop853::Dop853;
use crate::flow::steps::dormand_prince::DormandPrince;
use crate::flow::steps::example::BogackiShampine;
use crate::flow::steps::radau::Radau;
use crate::flow::steps::state::State;
use crate::flow::steps::stepper::{StepStart, Stepper, Tolerance};
use crate::model::{Dynamics, Moment};

/// A driven pendulum and an oscillator beside it, `q'' = -sin q - 0.1 v + 0.5 cos t`, `p'' = -k p - c v`.
struct PendulumAndOscillator {
    stiffness: f64,
    damping: f64,
}

impl Dynamics for PendulumAndOscillator {
    type Drive = f64;

    fn n_dof(&self) -> usize {
        2
    }

    fn drive(&self, at: Moment) -> f64 {
        at.angle.cos()
    }

    fn driven(&self, drive: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a[0] = -q[0].sin() - 0.1 * v[0] + 0.5 * drive;
        a[1] = -self.stiffness * q[1] - self.damping * v[1] + q[0];
        Ok(())
    }
}

const SOFT: PendulumAndOscillator = PendulumAndOscillator {
    stiffness: 2.0,
    damping: 0.3,
};
const TOLERANCE: Tolerance = Tolerance {
    relative: 1e-8,
    absolute: 1e-10,
};
/// The state `(q, v)` from which the tests begin. [exact]
const CONTRACT_START: [f64; 4] = [0.4, -0.2, 0.3, 0.1];

fn moment(time: f64) -> Moment {
    Moment::new(time, time, 1.0)
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A run over a span under control: the end, and the number of steps.
fn run<S: State, P: Stepper<S>>(
    choice: P::Choice,
    dynamics: &PendulumAndOscillator,
    x: &S,
    span: f64,
) -> (S, usize) {
    let (mut stepper, mut controller) = (P::new(2, TOLERANCE, choice), Controller::default());
    let (mut x, mut done, mut h, mut count) = (x.clone(), 0.0, 1e-3, 0);
    let begin = |stepper: &mut P, done: f64, x: &S| {
        let at = moment(done);
        stepper
            .begin(dynamics, StepStart { at, x })
            .expect("a rate");
    };
    begin(&mut stepper, 0.0, &x);
    while done < span {
        let length = f64::min(h, span - done);
        let at = moment(done);
        let start = StepStart { at, x: &x };
        let is_taken = stepper.step(dynamics, start, length).expect("rates");
        let error = stepper.error(dynamics, start, length, TOLERANCE);
        let error = if is_taken {
            error.expect("rates")
        } else {
            f64::INFINITY
        };
        let verdict = controller.judge(stepper.control(), length, error);
        h = verdict.next;
        assert!(h > 1e-12, "steps shrink without end");
        if verdict.is_accepted {
            stepper.accept(length, &mut controller);
            x.clone_from(stepper.end());
            (done, count) = (done + length, count + 1);
            if !stepper.go_on() {
                begin(&mut stepper, done, &x);
            }
        }
    }
    (x, count)
}

fn keeps_the_contract<C: Copy, P, V>(name: &str, choice: C)
where
    P: Stepper<[f64; 4], Choice = C>,
    V: Stepper<Vec<f64>, Choice = C>,
{
    let h = 0.05;
    let x = CONTRACT_START;
    let at = moment(0.7);
    let start = StepStart { at, x: &x };
    let mut stepper = P::new(2, TOLERANCE, choice);
    stepper.begin(&SOFT, start).expect("a rate");
    // The rate at the start is that of the state, and stays so when steps are taken again.
    let rate = |x: &[f64], at: Moment| {
        let mut a = [0.0; 2];
        SOFT.acceleration(at, &x[..2], &x[2..], &mut a)
            .expect("a rate");
        [x[2], x[3], a[0], a[1]]
    };
    for length in [h, 0.5 * h, h] {
        assert!(stepper.step(&SOFT, start, length).expect("rates"), "{name}");
        assert_eq!(*stepper.start_rate(), rate(&x, at), "{name}");
        let there = rate(stepper.end(), at.after(length));
        assert!(apart(stepper.end_rate(), &there) < 1e-14, "{name}");
        // The dense output has the states at both ends.
        let dense = stepper.dense(&SOFT, start, length).expect("rates");
        let mut state = [0.0; 4];
        dense.state(0.0, &mut state);
        assert!(apart(&state, &x) < 1e-15, "{name}");
        dense.state(length, &mut state);
        assert!(apart(&state, stepper.end()) < 1e-15, "{name}");
        // As powers it is the same.
        dense.state(0.3 * length, &mut state);
        for (i, y) in state.iter().enumerate() {
            let powers = dense.powers(i);
            let sum = powers.iter().rev().fold(0.0, |sum, c| sum * 0.3 + c);
            assert!((sum - y).abs() < 1e-15, "{name}");
        }
        // So it is when it was written.
        let mut numbers = Vec::new();
        DenseOutput::write(&dense, &mut numbers);
        let degree = <P::Dense as DenseOutput<[f64; 4]>>::DEGREE;
        let read = super::dense_output::written_state(&numbers, degree, 0.3 * length);
        assert_eq!(read, state, "{name}");
    }
    // The error is that of the step last taken, and less for a shorter one.
    let mut error_of = |length: f64| {
        assert!(stepper.step(&SOFT, start, length).expect("rates"), "{name}");
        let error = stepper.error(&SOFT, start, length, TOLERANCE);
        error.expect("rates")
    };
    let (long, short) = (error_of(h), error_of(0.5 * h));
    assert!(
        long.is_finite() && 4.0 * short < long,
        "{name}: {long} {short}"
    );
    // A step of no length ends where it begins.
    assert!(stepper.step(&SOFT, start, 0.0).expect("rates"), "{name}");
    assert_eq!(*stepper.end(), x, "{name}");
    // Going on from the end is beginning there.
    assert!(stepper.step(&SOFT, start, h).expect("rates"), "{name}");
    let middle = *stepper.end();
    assert!(stepper.go_on(), "{name}");
    assert!(
        apart(stepper.start_rate(), &rate(&middle, at.after(h))) < 1e-14,
        "{name}"
    );
    let next = StepStart {
        at: at.after(h),
        x: &middle,
    };
    assert!(stepper.step(&SOFT, next, h).expect("rates"), "{name}");
    let mut fresh = P::new(2, TOLERANCE, choice);
    fresh.begin(&SOFT, next).expect("a rate");
    assert!(fresh.step(&SOFT, next, h).expect("rates"), "{name}");
    assert!(apart(stepper.end(), fresh.end()) < 1e-9, "{name}");
    // A rate that is no number ends in no step or in an error that no tolerance allows.
    let broken = [f64::NAN; 4];
    let nowhere = StepStart { at, x: &broken };
    stepper.begin(&SOFT, nowhere).expect("a rate");
    let is_taken = stepper.step(&SOFT, nowhere, h).expect("rates");
    let error = stepper.error(&SOFT, nowhere, h, TOLERANCE).expect("rates");
    let is_allowed = is_taken && error <= 1.0;
    assert!(!is_allowed, "{name}");
    // Runs to the tolerance, in arrays and vectors alike.
    let (end, count) = run::<_, P>(choice, &SOFT, &CONTRACT_START, 10.0);
    let (same, again) = run::<_, V>(choice, &SOFT, &CONTRACT_START.to_vec(), 10.0);
    assert_eq!((end.to_vec(), count), (same, again), "{name}");
    let (fine, _) = run::<_, Dop853<[f64; 4]>>((), &SOFT, &CONTRACT_START, 10.0);
    let off = apart(&end, &fine);
    assert!(off < 1e2 * TOLERANCE.relative, "{name}: {off:e}");
}

#[test]
fn every_method_keeps_the_contract() {
    type Array = [f64; 4];
    type Vector = Vec<f64>;
    keeps_the_contract::<_, DormandPrince<Array>, DormandPrince<Vector>>("rk45", ());
    keeps_the_contract::<_, Dop853<Array>, Dop853<Vector>>("dop853", ());
    keeps_the_contract::<_, Radau<Array>, Radau<Vector>>("radau", ());
    keeps_the_contract::<_, BogackiShampine<Array>, BogackiShampine<Vector>>("example", ());
    for choice in [StepChoice::Fitting, StepChoice::Dop853, StepChoice::Radau] {
        let name = format!("{choice:?}");
        keeps_the_contract::<_, ChosenSteps<Array>, ChosenSteps<Vector>>(&name, choice);
    }
}

#[test]
fn a_stiff_motion_is_given_over() {
    type Array = [f64; 4];
    let stiff = PendulumAndOscillator {
        stiffness: 1e8,
        damping: 2e4,
    };
    let (explicit, many) = run::<_, DormandPrince<Array>>((), &stiff, &CONTRACT_START, 5.0);
    let fitting = StepChoice::Fitting;
    let (implicit, few) = run::<_, ChosenSteps<Array>>(fitting, &stiff, &CONTRACT_START, 5.0);
    assert!(10 * few < many, "{few} {many}");
    assert!(apart(&explicit, &implicit) < 1e-7);
}

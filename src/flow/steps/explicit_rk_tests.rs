#![cfg(test)]
//! Steps of an explicit method, of order 8 with stages that only its dense output needs.

use std::cell::RefCell;

use crate::error::Result;
use crate::flow::steps::dense_output::{Dense, DenseOutput};
use crate::flow::steps::dop853::{Dop853, Dop853Tableau};
use crate::flow::steps::explicit_rk::{ButcherTableau, combined};
use crate::flow::steps::state::State;
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::model::{Dynamics, Moment};

const TOLERANCE: Tolerance = Tolerance {
    relative: 1e-9,
    absolute: 1e-9,
};

/// A system of n degrees of freedom, whose drive is the moment itself.
struct WrittenSystem<F> {
    n: usize,
    acceleration: F,
}

impl<F: Fn(Moment, &[f64], &[f64], &mut [f64])> Dynamics for WrittenSystem<F> {
    type Drive = Moment;

    fn n_dof(&self) -> usize {
        self.n
    }

    fn drive(&self, at: Moment) -> Moment {
        at
    }

    fn driven(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        (self.acceleration)(at, q, v, a);
        Ok(())
    }
}

fn single(acceleration: impl Fn(Moment, f64, f64) -> f64) -> impl Dynamics {
    let acceleration = move |at, q: &[f64], v: &[f64], a: &mut [f64]| {
        a[0] = acceleration(at, q[0], v[0]);
    };
    WrittenSystem { n: 1, acceleration }
}

/// A damped pendulum, driven at twice its natural frequency.
fn pendulum() -> impl Dynamics {
    single(|at, q, v| 0.5 * at.angle.cos() - 0.1 * v - q.sin())
}

const FREQUENCY: f64 = 2.0;
const PENDULUM: [f64; 2] = [1.5, 0.0];
/// The pendulum at the time 4, from its Taylor series with 30 digits.
const PENDULUM_AT_4: [f64; 2] = [-1.307_445_435_662_217, 0.608_670_070_357_097_3];

fn start<S>(x: &S, frequency: f64, time: f64) -> StepStart<'_, S> {
    let angle = frequency * time;
    let at = Moment::new(time, angle, frequency);
    StepStart { at, x }
}

/// A stepper after a step from a start.
fn stepped<S: State>(dynamics: &impl Dynamics, start: StepStart<'_, S>, h: f64) -> Dop853<S> {
    let mut stepper = Dop853::new(dynamics.n_dof(), TOLERANCE, ());
    stepper.begin(dynamics, start).expect("a rate");
    assert!(stepper.step(dynamics, start, h).expect("rates"));
    stepper
}

/// The states after equal steps from the time 0.
fn motion<S: State>(dynamics: &impl Dynamics, first: StepStart<'_, S>, h: f64, n: u32) -> Vec<S> {
    let mut stepper = Dop853::new(dynamics.n_dof(), TOLERANCE, ());
    stepper.begin(dynamics, first).expect("a rate");
    let mut states = vec![first.x.clone()];
    for step in 0..n {
        let x = states.last().expect("the first");
        let from = start(x, first.at.frequency, f64::from(step) * h);
        stepper.step(dynamics, from, h).expect("rates");
        states.push(stepper.end().clone());
        stepper.go_on();
    }
    states
}

fn distance(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The mean distance of a dense output from the motion, at equal times of which the last is the end.
fn dense_error(dense: &Dense<[f64; 2], 7>, motion: &[[f64; 2]]) -> f64 {
    let spans = motion.len() - 1;
    let error_at = |(k, exact): (usize, &[f64; 2])| {
        let mut state = [0.0; 2];
        dense.state(dense.h * k as f64 / spans as f64, &mut state);
        distance(&state, exact)
    };
    let sum: f64 = motion.iter().enumerate().map(error_at).sum();
    sum / motion.len() as f64
}

/// The orders that errors tell, of steps that are halved from one to the next.
fn orders(errors: &[f64]) -> Vec<f64> {
    let pairs = errors.windows(2);
    pairs.map(|pair| (pair[0] / pair[1]).log2()).collect()
}

#[test]
fn the_end_is_of_order_eight() {
    let first = start(&PENDULUM, FREQUENCY, 0.0);
    let errors = [8, 16, 32].map(|n| {
        let states = motion(&pendulum(), first, 4.0 / f64::from(n), n);
        distance(&states[n as usize], &PENDULUM_AT_4)
    });
    let orders = orders(&errors);
    assert!(orders.iter().all(|order| *order > 7.8), "{orders:?}");
    assert!(errors[2] < 1e-12);
}

#[test]
fn the_dense_output_is_of_order_seven() {
    let first = start(&PENDULUM, FREQUENCY, 0.0);
    let errors = [1.0, 0.5, 0.25, 0.125].map(|h| {
        let dense = stepped(&pendulum(), first, h).dense(&pendulum(), first, h);
        let exact = motion(&pendulum(), first, h / 16.0, 16);
        dense_error(&dense.expect("rates"), &exact)
    });
    let orders = orders(&errors);
    assert!(orders.iter().all(|order| *order > 7.6), "{orders:?}");
    assert!(errors[3] < 1e-12);
}

#[test]
fn the_dense_output_has_the_states_and_rates_of_both_ends() {
    let (h, first) = (0.5, start(&PENDULUM, FREQUENCY, 0.0));
    let mut stepper = stepped(&pendulum(), first, h);
    let dense = stepper.dense(&pendulum(), first, h).expect("rates");
    assert!(dense_error(&dense, &[PENDULUM, *stepper.end()]) < 1e-15);
    for i in 0..2 {
        let powers = dense.powers(i);
        let last: f64 = (0..=7).map(|k| f64::from(k) * powers[k as usize]).sum();
        assert!((powers[1] / h - stepper.start_rate()[i]).abs() < 1e-14);
        assert!((last / h - stepper.end_rate()[i]).abs() < 1e-13);
    }
}

#[test]
fn rates_are_taken_at_the_nodes() {
    let times = RefCell::new(Vec::new());
    let clock = single(|at, _, _| {
        times.borrow_mut().push(at.time);
        0.0
    });
    let (h, first) = (1.0, start(&PENDULUM, FREQUENCY, 0.0));
    let mut stepper = stepped(&clock, first, h);
    stepper.dense(&clock, first, h).expect("rates");
    let times = times.borrow();
    assert_eq!(times[0], 0.0);
    assert_eq!(times[1..], *Dop853Tableau::NODES);
}

#[test]
fn a_drive_alone_is_integrated() {
    let (h, n) = (0.04, 50);
    let drive = single(|at, _, _| at.angle.cos());
    let exact = |t: f64| [(1.0 - (5.0 * t).cos()) / 25.0, (5.0 * t).sin() / 5.0];
    let states = motion(&drive, start(&[0.0; 2], 5.0, 0.0), h, n);
    assert!(distance(&states[n as usize], &exact(h * f64::from(n))) < 1e-14);
    let time = 0.3;
    let x = exact(time);
    let from = start(&x, 5.0, time);
    let dense = stepped(&drive, from, h)
        .dense(&drive, from, h)
        .expect("rates");
    let between: Vec<_> = (0..=8)
        .map(|k| exact(time + h * f64::from(k) / 8.0))
        .collect();
    assert!(dense_error(&dense, &between) < 1e-12);
}

#[test]
fn evaluations_are_counted_and_those_of_the_dense_output_made_once() {
    let (h, first) = (0.5, start(&PENDULUM, FREQUENCY, 0.0));
    let mut stepper = stepped(&pendulum(), first, h);
    assert_eq!(stepper.n_rhs(), 1 + 12);
    stepper.dense(&pendulum(), first, h).expect("rates");
    assert_eq!(stepper.n_rhs(), 1 + 12 + 3);
    stepper
        .error(&pendulum(), first, h, TOLERANCE)
        .expect("an error");
    let again = stepper.dense(&pendulum(), first, h).expect("rates");
    assert_eq!(stepper.n_rhs(), 1 + 12 + 3);
    assert!(dense_error(&again, &motion(&pendulum(), first, h / 16.0, 16)) < 1e-7);
    // Another step from the same start has stages of its own.
    let h = 0.25;
    stepper.step(&pendulum(), first, h).expect("rates");
    let shorter = stepper.dense(&pendulum(), first, h).expect("rates");
    assert_eq!(stepper.n_rhs(), 1 + 2 * (12 + 3));
    assert!(dense_error(&shorter, &motion(&pendulum(), first, h / 16.0, 16)) < 1e-10);
}

#[test]
fn the_end_of_a_step_is_the_start_of_the_next() {
    let (h, first) = (0.25, start(&PENDULUM, FREQUENCY, 0.0));
    let mut stepper = stepped(&pendulum(), first, h);
    let (x, rate) = (*stepper.end(), *stepper.end_rate());
    stepper.go_on();
    assert_eq!(*stepper.start_rate(), rate);
    let next = start(&x, FREQUENCY, h);
    stepper.step(&pendulum(), next, h).expect("rates");
    assert_eq!(stepper.end(), stepped(&pendulum(), next, h).end());
    // And back again.
    stepper.go_on();
    let x = *stepper.end();
    let back = stepped(&pendulum(), start(&x, FREQUENCY, 2.0 * h), -2.0 * h);
    assert!(distance(back.end(), &PENDULUM) < 1e-7);
}

#[test]
fn arrays_and_vectors_give_the_same_bits() {
    let acceleration = |at: Moment, q: &[f64], v: &[f64], a: &mut [f64]| {
        a[0] = at.angle.cos() - q[0].powi(3) + 0.2 * (q[1] - q[0]);
        a[1] = 0.2 * (q[0] - q[1]) - 0.1 * v[1];
    };
    let chain = WrittenSystem { n: 2, acceleration };
    let array = [0.3, -0.7, 1.1, 0.2];
    let vector = array.to_vec();
    assert_eq!(bits(&chain, &array), bits(&chain, &vector));
}

/// What comes of a step, bit by bit: the dense output, the end and its rate, the error, the stiffness.
fn bits<S: State>(dynamics: &impl Dynamics, x: &S) -> Vec<u64> {
    let (h, first) = (0.3, start(x, FREQUENCY, 0.1));
    let mut stepper = stepped(dynamics, first, h);
    let mut numbers = vec![
        stepper
            .error(dynamics, first, h, TOLERANCE)
            .expect("an error"),
        stepper.stiffness(h),
    ];
    let dense = stepper.dense(dynamics, first, h).expect("rates");
    dense.write(&mut numbers);
    numbers.extend(stepper.end().slice());
    numbers.extend(stepper.end_rate().slice());
    numbers.into_iter().map(f64::to_bits).collect()
}

fn error_of_pendulum(stepper: &mut Dop853<[f64; 2]>, h: f64, tolerance: Tolerance) -> f64 {
    let first = start(&PENDULUM, FREQUENCY, 0.0);
    let error = stepper.error(&pendulum(), first, h, tolerance);
    error.expect("an error")
}

#[test]
fn the_error_is_of_order_eight_and_in_units_of_the_tolerance() {
    let first = start(&PENDULUM, FREQUENCY, 0.0);
    let errors = [0.5, 0.25, 0.125].map(|h| {
        let mut stepper = stepped(&pendulum(), first, h);
        error_of_pendulum(&mut stepper, h, TOLERANCE)
    });
    let orders = orders(&errors);
    assert!(
        orders.iter().all(|order| (order - 8.0).abs() < 0.2),
        "{orders:?}"
    );
    let mut back = stepped(&pendulum(), first, -0.5);
    assert!(error_of_pendulum(&mut back, -0.5, TOLERANCE) > 0.0);
    let (relative, absolute) = (2.0 * TOLERANCE.relative, 2.0 * TOLERANCE.absolute);
    let twice = Tolerance { relative, absolute };
    let mut stepper = stepped(&pendulum(), first, 0.5);
    let quotient = errors[0] / error_of_pendulum(&mut stepper, 0.5, twice);
    assert!((quotient - 2.0).abs() < 1e-12);
}

#[test]
fn estimates_are_combined_without_loss() {
    assert_eq!(combined(0.0, 0.0), 0.0);
    assert_eq!(combined(0.0, 1.0), 0.0);
    assert_eq!(combined(2.0, 0.0), 2.0);
    assert!((combined(3.0, 40.0) - 1.8).abs() < 1e-15);
    assert!((combined(3e-200, 40e-200) / 1.8e-200 - 1.0).abs() < 1e-15);
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(combined(bad, 1.0), f64::INFINITY);
        assert_eq!(combined(0.0, bad), f64::INFINITY);
        assert_eq!(combined(bad, f64::NAN), f64::INFINITY);
    }
}

#[test]
fn an_error_that_is_no_number_is_infinite() {
    let (h, first) = (0.5, start(&PENDULUM, FREQUENCY, 0.0));
    for bad in [f64::NAN, f64::INFINITY] {
        let late = single(|at, _, _| if at.time > 0.3 { bad } else { 0.0 });
        assert_eq!(
            error_of_pendulum(&mut stepped(&late, first, h), h, TOLERANCE),
            f64::INFINITY
        );
        for stage in [0, 5, Dop853Tableau::END - 1, Dop853Tableau::END] {
            let mut stepper = stepped(&pendulum(), first, h);
            stepper.stages[stage][1] = bad;
            assert_eq!(error_of_pendulum(&mut stepper, h, TOLERANCE), f64::INFINITY);
        }
        let mut stepper = stepped(&pendulum(), first, h);
        stepper.end_mut()[0] = bad;
        assert_eq!(error_of_pendulum(&mut stepper, h, TOLERANCE), f64::INFINITY);
    }
    // A system at rest has no error.
    let rest = single(|_, _, v| -v);
    let error = stepped(&rest, first, h).error(&rest, first, h, TOLERANCE);
    assert_eq!(error, Ok(0.0));
}

#[test]
fn the_stiffness_of_a_decay_is_its_rate_times_the_step() {
    let (h, decay) = (0.1, 50.0);
    let damped = single(|_, _, v| -decay * v);
    let x = [1.0, -decay];
    let first = start(&x, 0.0, 0.0);
    let mut stepper = stepped(&damped, first, h);
    // Neither the error nor the dense output change it.
    for _ in 0..2 {
        assert!((stepper.stiffness(h) - h * decay).abs() < 1e-9);
        assert_eq!(stepper.stiffness(h), stepper.stiffness(-h));
        stepper
            .error(&damped, first, h, TOLERANCE)
            .expect("an error");
        stepper.dense(&damped, first, h).expect("rates");
    }
    let rest = [1.0, 0.0];
    assert_eq!(
        stepped(&damped, start(&rest, 0.0, 0.0), h).stiffness(h),
        0.0
    );
}

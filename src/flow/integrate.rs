//! Integration of a motion over a span \[s\] without contacts, to a tolerance, step by step.

use crate::error::{Error, Result};
use crate::flow::steps::control::Controller;
use crate::flow::steps::{StepStart, Stepper, Tolerance};
use crate::model::{Dynamics, Moment};

/// The first step in parts of the span; the controller soon finds the right one. [work]
const FIRST_STEP_PART: f64 = 1e-3;
/// Steps before a span counts as too long to integrate. [work]
const MOST_INTEGRATION_STEPS: usize = 10_000_000;

/// A step that was accepted.
pub(crate) struct Accepted<'s, P> {
    pub stepper: &'s mut P,
    /// The moment and the state `(q, v)`, shape `(2 n_dof,)`, \[m\] and \[m/s\] for coordinates that are lengths, from which the step was
    /// taken.
    pub start: StepStart<'s, Vec<f64>>,
    /// The part of the span before it \[s\].
    pub done: f64,
    pub h: f64,
}

/// Integrates from a state `(q, v)` by a method, each of whose steps is handed out when it is accepted.
pub(crate) fn integrate<P: Stepper<Vec<f64>, Choice: Default>, D: Dynamics>(
    dynamics: &D,
    (at, span): (Moment, f64),
    tolerance: Tolerance,
    state: &mut Vec<f64>,
    mut accept: impl FnMut(Accepted<'_, P>) -> Result<()>,
) -> Result<()> {
    let mut stepper = P::new(dynamics.n_dof(), tolerance, P::Choice::default());
    let mut controller = Controller::default();
    let (mut done, mut h) = (0.0, FIRST_STEP_PART * span);
    stepper.begin(dynamics, StepStart { at, x: state })?;
    let mut tried = 0;
    while tried < MOST_INTEGRATION_STEPS {
        tried += 1;
        if done >= span {
            return Ok(());
        }
        let is_last = h >= 0.999 * (span - done);
        let step = if is_last { span - done } else { h };
        let start = StepStart {
            at: at.after(done),
            x: state,
        };
        let error = if stepper.step(dynamics, start, step)? {
            stepper.error(dynamics, start, step, tolerance)?
        } else {
            f64::INFINITY
        };
        let verdict = controller.judge(stepper.control(), step, error);
        h = verdict.next;
        if !verdict.is_accepted {
            if done + h == done {
                break;
            }
            continue;
        }
        accept(Accepted {
            stepper: &mut stepper,
            start,
            done,
            h: step,
        })?;
        state.clone_from(stepper.end());
        done = if is_last { span } else { done + step };
        if !stepper.go_on() {
            let at = at.after(done);
            stepper.begin(dynamics, StepStart { at, x: state })?;
        }
    }
    Err(Error::NoConvergence {
        stage: "the integration of a flight",
        iterations: tried,
        residual: span - done,
    })
}

/// One step of a flight that was kept.
#[derive(Debug, Clone)]
pub(crate) struct KeptStep<Q> {
    /// Its start, counted from that of the flight.
    pub start: f64,
    pub h: f64,
    pub dense: Q,
}

//! The interface of an integration method: one step on `q'' = a(t, q, v)`, its error, its dense output (theory 8).

use crate::error::Result;
use crate::flow::steps::control::{Controller, StepControl};
use crate::flow::steps::dense_output::DenseOutput;
use crate::flow::steps::state::State;
use crate::model::{Dynamics, Moment};

/// Tolerances of one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub relative: f64,
    pub absolute: f64,
}

impl Tolerance {
    /// The tolerances that are not given.
    pub const USUAL: Self = Self {
        relative: 1e-9,
        absolute: 1e-12,
    };

    /// The root mean square of some numbers, each in units of what is allowed of the larger of two entries.
    #[allow(clippy::inline_always, reason = "a part of every step")]
    #[inline(always)]
    pub fn norm<S: State>(self, numbers: &S, ends: (&S, &S)) -> f64 {
        let (mut sum, numbers) = (0.0, numbers.slice());
        let ends = ends.0.slice().iter().zip(ends.1.slice());
        for (e, (x, end)) in numbers.iter().zip(ends) {
            let scale = self.absolute + self.relative * x.abs().max(end.abs());
            sum += (e / scale).powi(2);
        }
        (sum / numbers.len() as f64).sqrt()
    }
}

/// Where a step begins.
#[derive(Debug)]
pub(crate) struct StepStart<'a, S> {
    pub at: Moment,
    pub x: &'a S,
}

impl<S> Clone for StepStart<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for StepStart<'_, S> {}

/// The states and rates at both ends of the step last taken.
pub(crate) trait StepEnds<S> {
    /// The rate of the state at the start.
    fn start_rate(&self) -> &S;
    /// The state at the end.
    fn end(&self) -> &S;
    fn end_mut(&mut self) -> &mut S;
    /// The rate of the state at the end.
    fn end_rate(&self) -> &S;
    /// Evaluations of the right-hand side so far.
    fn n_rhs(&self) -> usize;
    /// The name of the method that steps now, where it was chosen because it fits.
    fn fitting(&self) -> Option<&'static str> {
        None
    }
}

/// An integration method, step by step. A step is taken from a start whose rate is known, by [`begin`](Self::begin) or because it
/// is the end of the step before; it can be taken again, with another length.
pub(crate) trait Stepper<S: State>: StepEnds<S> + 'static {
    /// Whether a quintic through value, slope and curvature at both ends of a step is as near to the motion as the dense output.
    const HAS_QUINTIC: bool;
    /// The options of the method, none for most.
    type Choice: Copy;
    /// The motion on a step.
    type Dense: DenseOutput<S>;

    /// A stepper of n degrees of freedom.
    fn new(n_dof: usize, tolerance: Tolerance, choice: Self::Choice) -> Self;
    /// Makes a state the start of the next step.
    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()>;
    /// Takes a step of length h; false where there is none, since its equations have no solution nearby.
    fn step<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<bool>;
    /// The error of the step last taken, in units of the tolerance (root mean square).
    fn error<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
        tolerance: Tolerance,
    ) -> Result<f64>;
    /// The dense output of the step last taken.
    fn dense<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
    ) -> Result<Self::Dense>;
    /// Makes the end of the step last taken the start of the next one; false where that must begin anew, by another method.
    fn go_on(&mut self) -> bool;
    /// How the length of the next step follows from the error of the last.
    fn control(&self) -> StepControl;
    /// Tells the controller of an accepted step of length h whether stability, not accuracy, limits it.
    fn accept(&mut self, _h: f64, _controller: &mut Controller) {}
}

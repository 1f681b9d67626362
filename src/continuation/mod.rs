//! Continuation: curves of zeros of `G(Z, p) = 0`, whose unknowns are one more than its equations, followed by pseudo-arclength (theory 19).
//!
//! `zero_problem.rs` says what a problem has; `predictor.rs` and `corrector.rs` make one step of it, `step_control.rs` its length, `walk.rs`
//! one half of a curve from its first point to its end; `locator.rs` finds on a step where a test function changes its sign, or where a
//! property changes. `branch` has the problems: orbits over a number, special points over two.

mod corrector;
mod end;
mod failure;
mod locator;
mod predictor;
mod step_control;
mod walk;
mod zero_problem;

pub(crate) use corrector::{Corrected, bordered, corrected, tangent};
pub use end::{BranchEnd, EndReason};
pub(crate) use failure::{Attempt, StepFailure, attempted};
pub(crate) use locator::{
    ChangeBracket, LocatedZero, TestEvaluation, evaluated, locate_change, locate_zero,
};
pub(crate) use predictor::{stepped, stepped_to};
pub(crate) use step_control::step_factor;
pub(crate) use walk::{HalfBranch, StepOutcome, Walk, walk};
pub(crate) use zero_problem::{Linearisation, ScaledDirection, ZeroProblem};

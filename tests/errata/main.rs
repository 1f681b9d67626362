//! The paper's equations that fail, each beside the form that holds; `docs/errata.md` is the list. A form ending in
//! `_printed` is the paper's. Both are judged by something that neither was derived from: energies, the state
//! matrix and its exponential, a derivative. Where the library has the value in its public interface, it is held to the form
//! that holds. The state is the paper's `(q1, v1, q2, v2)`, the wall is above.

#![allow(
    clippy::many_single_char_names,
    clippy::similar_names,
    reason = "the letters are the symbols of the paper, which each function defines"
)]

mod contact;
mod first_kind;
mod library;
mod motion;
mod pendulum;
mod system;

/// A residual above this [-] is an error of the equation, one below `HOLDS` is rounding.
const FAILS: f64 = 1e-3;
const HOLDS: f64 = 1e-12;
/// Complex-step length: its square is below every rounding error, so derivatives are exact to rounding.
const STEP: f64 = 1e-20;

#[track_caller]
fn fails(residual: f64) {
    assert!(residual > FAILS, "an error should show: {residual:e}");
}

#[track_caller]
fn holds(residual: f64) {
    assert!(
        residual < HOLDS,
        "only rounding should be left: {residual:e}"
    );
}

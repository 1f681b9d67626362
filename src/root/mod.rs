//! Where a function of one number is zero, or a property of one changes: a bracket of the place, and the rules by which the next trial
//! in it is chosen: its middle (bisection), Newton's step, the secant through its ends (false position). Roots of polynomials:
//! `polynomial.rs`; where a function is lowest: `golden_section.rs`.

mod bracket;
mod false_position;
mod golden_section;
mod newton;
pub(crate) mod polynomial;
mod secant;

pub(crate) use bracket::{Bracket, bisected};
pub(crate) use false_position::FalsePosition;
pub(crate) use golden_section::golden_section;
pub(crate) use newton::{NewtonPoint, newton};
pub(crate) use secant::Secant;

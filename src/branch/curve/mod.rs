//! Curves in the plane of two numbers on which a special point of a branch lies (theory 20).

mod begun;
mod condition;
mod corrector;
mod followed;
mod one;
mod plane;
mod point;
mod step;
mod two_at_once;
mod walk;

pub use begun::CurveOf;
pub use followed::{bifurcation_curve, bifurcation_curve_of};
pub use one::{BifurcationCurve, CurvePoint};

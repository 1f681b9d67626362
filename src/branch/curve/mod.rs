//! Curves in the plane of two numbers on which a special point of a branch lies (theory 20).

mod condition;
mod corrector;
mod followed;
mod one;
mod plane;

pub use followed::{CurveOf, bifurcation_curve, bifurcation_curve_of};
pub use one::{BifurcationCurve, CurvePoint};

//! Curves in the plane of two numbers on which a special point of a branch lies (theory 20).

mod bifurcation_curve;
mod codimension_two;
mod condition;
mod direction;
mod point;
mod predictor;
mod problem;
mod result;
mod start;
mod walk;
mod zero_problem;

pub use bifurcation_curve::{bifurcation_curve, bifurcation_curve_of};
pub use result::{BifurcationCurve, CurvePoint};
pub use start::CurveOf;

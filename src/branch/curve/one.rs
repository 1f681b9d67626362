//! A curve.

use crate::branch::end::BranchEnd;
use crate::branch::special::SpecialKind;
use crate::orbit::PeriodicOrbit;

/// A point of a curve at which two things happen at once.
#[derive(Debug, Clone)]
pub struct CurvePoint {
    /// What happens there besides: `cusp`, `strong_1_1` to `strong_1_4`, `fold_flip`, `resonant_graze`, `graze_fold`, `double_graze`,
    /// `degenerate_graze`, `graze_corner`, or the name of a boundary of motion that the orbits come to.
    pub kind: &'static str,
    /// Both numbers.
    pub parameters: [f64; 2],
    /// How far each is known.
    pub error: [f64; 2],
    /// How far along the curve it is.
    pub arclength: f64,
    /// The orbit of the point of the curve next to it.
    pub orbit: PeriodicOrbit,
}

/// Periodic orbits at special points over two numbers of their scene: a sequence of m orbits, beside each other.
#[derive(Debug, Clone)]
pub struct BifurcationCurve {
    /// What lies on it; none of stops that are hit at one instant.
    pub kind: Option<SpecialKind>,
    /// The motions, shape `(m,)`.
    pub orbits: Vec<PeriodicOrbit>,
    /// The first number at each, and the second, shape `(m,)`.
    pub x: Vec<f64>,
    /// See `x`.
    pub y: Vec<f64>,
    /// How far along the curve each is, in scaled unknowns, from the one that was given; shape `(m,)`.
    pub arclength: Vec<f64>,
    /// Whether each breaks a rule of contact, but for the speed that an impact has not; shape `(m,)`.
    pub is_virtual: Vec<bool>,
    /// Where two things happen at once, along the curve.
    pub special: Vec<CurvePoint>,
    /// What it ends with, at its first point and at its last.
    pub ends: [BranchEnd; 2],
}

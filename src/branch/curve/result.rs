//! The result of a curve: orbits over two numbers, and the points at which two things happen at once.

use crate::branch::special::SpecialKind;
use crate::continuation::BranchEnd;
use crate::orbit::PeriodicOrbit;

/// A point of a curve at which two things happen at once.
#[derive(Debug, Clone)]
pub struct CurvePoint {
    /// What happens there besides: `cusp`, `strong_1_1` to `strong_1_4`, `fold_flip`, `resonant_graze`, `graze_fold`, `double_graze`,
    /// `degenerate_graze`, `graze_corner`, or the name of a boundary of motion that the orbits come to.
    pub kind: &'static str,
    /// Both numbers.
    pub parameters: [f64; 2],
    /// The error of each.
    pub error: [f64; 2],
    /// How far along the curve it is, in scaled unknowns \[-\].
    pub arclength: f64,
    /// The orbit of the point of the curve next to it.
    pub orbit: PeriodicOrbit,
}

/// Periodic orbits at special points over two numbers of their scene: a sequence of m orbits, beside each other.
#[derive(Debug, Clone)]
pub struct BifurcationCurve {
    /// The kind of special point on it; `None` for stops that are hit at one instant.
    pub kind: Option<SpecialKind>,
    /// The motions, shape `(m,)`.
    pub orbits: Vec<PeriodicOrbit>,
    /// The first number at each, shape `(m,)`, \[unit of the number\].
    pub x: Vec<f64>,
    /// The second number at each, shape `(m,)`, \[unit of the number\].
    pub y: Vec<f64>,
    /// How far along the curve each is from the one that was given, shape `(m,)`, \[-\], in scaled unknowns.
    pub arclength: Vec<f64>,
    /// Whether each breaks a rule of contact, but for the speed that an impact has not; shape `(m,)`.
    pub is_virtual: Vec<bool>,
    /// Where two things happen at once, along the curve.
    pub special: Vec<CurvePoint>,
    /// What it ends with, at its first point and at its last.
    pub ends: [BranchEnd; 2],
}

//! What the referee saw; times since the start.

use crate::runs::double_double::Dd;

/// Why a run is not compared any further where forces are shared that are not of one direction.
pub const AMBIGUOUS: &str = "stops that depend on each other push in different directions";

#[derive(Debug, Clone)]
pub struct Hit {
    pub time: Dd,
    pub stop: usize,
    pub approach: f64,
    pub departure: f64,
    pub impulse: f64,
    /// Second derivative of the gap without contact forces.
    pub curvature: f64,
    /// Rounds in which the impulses of the instant were found; 0 where dependent stops share them.
    pub rounds: usize,
}

#[derive(Debug, Clone)]
pub struct Stretch {
    pub stop: usize,
    pub start: f64,
    pub end: f64,
}

#[derive(Debug, Clone, Default)]
pub struct Record {
    pub hits: Vec<Hit>,
    pub sticks: Vec<Stretch>,
    /// The ends of accumulating impacts.
    pub chatters: Vec<Stretch>,
    /// Times at which rounding decides, and why.
    pub doubts: Vec<(f64, &'static str)>,
    /// Why the run ended early.
    pub stopped: Option<(f64, &'static str)>,
    pub samples: Vec<Vec<f64>>,
    pub end: f64,
    /// Largest position, velocity and contact force so far.
    pub q_size: f64,
    pub v_size: f64,
    pub force_size: f64,
}

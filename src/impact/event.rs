//! One impact as it is reported: when, where, how fast before and after (theory 1).

use std::f64::consts::TAU;

/// One impact of one stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// Time \[s\].
    pub time: f64,
    /// The stop hit.
    pub stop: usize,
    /// Normal velocity towards the stop before the impact; negative where an orbit is not admissible.
    pub approach: f64,
    /// Normal speed away from the stop after the impact.
    pub departure: f64,
    /// The impulse, positive where it pushes away from the stop.
    pub impulse: f64,
    /// Forcing phase at the impact \[rad\], in [0, 2 pi).
    pub phase: f64,
}

/// An angle in [0, 2 pi).
pub(crate) fn wrapped(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(TAU);
    if wrapped >= TAU { 0.0 } else { wrapped }
}

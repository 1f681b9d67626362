//! An orbit as its solver found it: its arcs, and [`OrbitData`] beside them.

use crate::itinerary::MotionArc;
use crate::modal::ModalState;
use crate::orbit::pattern::Pattern;

/// One arc of an orbit, its states in modal pairs; in pairs of position and velocity where the scene has no modes.
pub(crate) type OrbitArc = MotionArc<ModalState>;

impl OrbitArc {
    /// Whether the doubles hold its ends.
    pub fn is_finite(&self) -> bool {
        let states = self.after.iter().chain(&self.before_next);
        states.flatten().all(|x| x.is_finite())
    }
}

/// The parts of an orbit that a solver found.
pub(crate) struct OrbitData {
    pub pattern: Pattern,
    pub n_periods: usize,
    pub phase: f64,
    pub flights: Vec<OrbitArc>,
    /// The impulses, instant by instant, in the order of the pattern, shape (impacts,), [N s].
    pub impulses: Vec<f64>,
    /// The clearances that stops must have for it, where they were not given, in the order of the pattern.
    pub clearances: Vec<(usize, f64)>,
}

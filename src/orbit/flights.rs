//! An orbit as its solver found it: [`Flight`]s, and [`OrbitData`] beside them.

use crate::modal::ModalState;
use crate::orbit::contact_mode::ContactMode;
use crate::orbit::pattern::Pattern;

/// One flight of an orbit, its states in modal pairs; in pairs of position and velocity where the scene has no modes.
#[derive(Debug, Clone)]
pub(crate) struct Flight {
    /// Its start, counted from the first impact.
    pub start: f64,
    pub span: f64,
    /// The state at its start, after the impacts there.
    pub after: ModalState,
    /// The state at its end, before the impacts there.
    pub before_next: ModalState,
    /// Whether it is free, in lasting contact, or the completion of accumulating impacts.
    pub mode: ContactMode,
}

impl Flight {
    /// A free flight between two instants of the pattern, from a start over a span, from a state to another.
    pub fn struck([start, span]: [f64; 2], after: ModalState, before_next: ModalState) -> Self {
        Self {
            start,
            span,
            after,
            before_next,
            mode: ContactMode::struck(),
        }
    }

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
    pub flights: Vec<Flight>,
    /// The impulses, instant by instant, in the order of the pattern, shape (impacts,), [N s].
    pub impulses: Vec<f64>,
    /// The clearances that stops must have for it, where they were not given, in the order of the pattern.
    pub clearances: Vec<(usize, f64)>,
}

//! What is known of the elements that give way while a linear scene moves: what they do to the others, and the places of those that relax.

use crate::flow::RegimeMotion;
use crate::hybrid::relaxing_places::RelaxingPlaces;
use std::cell::OnceCell;
use std::sync::Arc;

/// The acceleration of a gap where nothing is held, under the forces of the elements that are pressed.
#[derive(Debug, Clone, Copy)]
pub(super) struct GapPull {
    pub acceleration: f64,
    pub jerk: f64,
    /// The size of the terms of the acceleration, and what the forcing's part leaves unknown of it.
    pub size: f64,
    pub lost: f64,
}

/// What elements that give way do to the others.
pub(super) struct CompliantElements {
    /// The motion without what is held, where that is not the free one.
    pub motion: Option<Arc<RegimeMotion>>,
    /// What is known of each gap's, once it has been asked for; of one that cannot change nothing.
    pub pulls: Vec<OnceCell<Option<GapPull>>>,
    pub places: RelaxingPlaces,
}

impl CompliantElements {
    /// Nothing, of so many stops.
    pub fn new(n_stops: usize) -> Self {
        Self {
            motion: None,
            pulls: vec![OnceCell::new(); n_stops],
            places: RelaxingPlaces::default(),
        }
    }

    /// That all are free.
    pub fn forget(&mut self) {
        if self.motion.take().is_some() {
            self.places.clear();
        }
    }

    /// Forgets what was asked of a state that has changed.
    #[inline]
    pub fn changed(&mut self) {
        if self.motion.is_some() {
            self.pulls.fill(OnceCell::new());
        }
    }
}

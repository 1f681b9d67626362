//! Whether two attractors are one (theory 15). Cycles are, if they have the same least period and, from one of their states on, all points
//! within `SAME_STATE` of the size of the motion (`recurrence/cycle.rs`), at the phase that is farthest from the impacts of both. Sets are
//! by the nearest neighbours of their states (`recurrence/set.rs`); where these leave it open, `gathering.rs` carries both motions on, and
//! those that no number of states tells apart count as one. A cycle and a set are two. What a cycle is: `Attractor::is_cycle`
//! (`record.rs`); distances and sizes: `recurrence/measure.rs`.

use crate::attractor::at_phase::{points_at, quiet_phase};
use crate::attractor::finding::AttractorSearch;
use crate::attractor::record::Attractor;
use crate::error::Result;
use crate::recurrence::{Measure, Sets, are_one_cycle, compared};
use crate::simulate::Keep;
use nalgebra::DMatrix;

/// Whether two attractors are one, by the states of each at one phase, one a row and period of the forcing; with them comes whether they are
/// a cycle, or else some of a set.
pub(crate) fn are_one(
    (a, is_cycle): (&DMatrix<f64>, bool),
    (b, is_other_cycle): (&DMatrix<f64>, bool),
    measure: &Measure,
) -> bool {
    match (is_cycle, is_other_cycle) {
        (true, true) => are_one_cycle(a, b, measure),
        (false, false) => compared(a, b, measure) == Sets::One,
        _ => false,
    }
}

impl AttractorSearch<'_> {
    /// Whether two attractors are one; with each come its states at the phase of the search, of a set as many as are known.
    pub(super) fn are_one(
        &self,
        (a, of_a): (&Attractor, &DMatrix<f64>),
        (b, of_b): (&Attractor, &DMatrix<f64>),
    ) -> Result<bool> {
        let (is_a, is_b) = (a.is_cycle(), b.is_cycle());
        if !(is_a && is_b) {
            return Ok(are_one((of_a, is_a), (of_b, is_b), &self.measure()));
        }
        if a.points == b.points {
            return Ok(true);
        }
        let quiet = quiet_phase([a, b], self.options.phase);
        self.is_on(&self.points_of_one(a, quiet)?, (b, quiet))
    }

    /// Whether a motion that repeats itself is on a cycle, by its states of one round at a phase.
    pub(super) fn is_on(
        &self,
        own: &DMatrix<f64>,
        (one, phase): (&Attractor, f64),
    ) -> Result<bool> {
        let points = self.points_of_one(one, phase)?;
        Ok(are_one((own, true), (&points, true), &self.measure()))
    }

    /// The points of an attractor at a phase.
    fn points_of_one(&self, one: &Attractor, phase: f64) -> Result<DMatrix<f64>> {
        let phases = (self.options.phase, phase);
        points_at(self.scene, one, phases, &self.options.run(Keep::Final))
    }
}

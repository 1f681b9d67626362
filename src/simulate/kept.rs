//! The chapters of a run (`schedule.rs`) as a trajectory keeps them: one where there is no ramp.

use crate::model::Ramp;
use crate::path::{AccumulationStart, Path};
use crate::simulate::schedule::Schedule;
use std::ops::Range;
use std::sync::OnceLock;

/// A chapter as a trajectory keeps it.
#[derive(Debug, Clone)]
pub(crate) struct KeptChapter {
    /// The motion, if it is kept.
    pub path: Option<Path>,
    /// What its contacts are read from, where the motion is not kept: the parts of it in contact, and where impacts began to accumulate.
    pub contacts: Option<(Path, Vec<AccumulationStart>)>,
    /// The impulses of the stops in contact on each segment of the path, computed when first asked for: for each segment shape
    /// `(n_contacts,)`, [N s].
    pub contact_impulses: OnceLock<Vec<Vec<f64>>>,
    pub span: (f64, f64),
    /// Its impacts among those of the run.
    pub impacts: Range<usize>,
}

/// The ramps of a run: as given, the time up to which the run was to go, and what they make of it.
#[derive(Debug, Clone)]
pub(crate) struct Ramped {
    pub ramps: Vec<Ramp>,
    pub until: f64,
    pub schedule: Schedule,
}

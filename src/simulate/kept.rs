//! What is kept of the chapters of a run (`schedule.rs`): one where there is no ramp.

use crate::model::Ramp;
use crate::path::Path;
use crate::simulate::schedule::Schedule;
use std::ops::Range;
use std::sync::OnceLock;

/// What is kept of a chapter.
#[derive(Debug, Clone)]
pub(crate) struct KeptChapter {
    /// The motion, if it is kept.
    pub path: Option<Path>,
    /// What stops give on each segment of the path, once it has been asked for.
    pub given: OnceLock<Vec<Vec<f64>>>,
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

//! What looks at a run at times of its own while it goes on, and may end it.

use crate::model::PhysicalState;
use std::any::Any;
use std::ops::ControlFlow;

/// Looks at a run from time to time.
pub(crate) trait Watcher: Send {
    /// When it wants to look next.
    fn next(&self) -> f64;
    /// How long it waits from look to look.
    fn every(&self) -> f64;
    /// Looks at the state then; breaking off ends the run.
    fn look(&mut self, state: &PhysicalState) -> ControlFlow<()>;
    /// What it is, when the run has ended.
    fn into_any(self: Box<Self>) -> Box<dyn Any>;
}

/// A watcher of a run, if there is one, and whether it has seen enough.
#[derive(Default)]
pub(crate) struct Watch {
    pub watcher: Option<Box<dyn Watcher>>,
    pub is_done: bool,
}

impl Watch {
    /// Whether it wants to look before a time.
    pub fn wants_before(&self, t: f64) -> bool {
        self.watcher
            .as_ref()
            .is_some_and(|watcher| watcher.next() < t)
    }
}

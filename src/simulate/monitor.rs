//! What inspects the state of a run at times of its own choice while the run goes on, and may end it.

use crate::model::PhysicalState;
use std::any::Any;
use std::ops::ControlFlow;

/// Inspects the state of a run from time to time.
pub(crate) trait RunMonitor: Send {
    /// The time at which it wants the next state.
    fn next(&self) -> f64;
    /// The time from one state to the next.
    fn every(&self) -> f64;
    /// Inspects the state at that time; breaking off ends the run.
    fn inspect(&mut self, state: &PhysicalState) -> ControlFlow<()>;
    /// The monitor itself, when the run has ended, for its type to be taken back.
    fn into_any(self: Box<Self>) -> Box<dyn Any>;
}

/// The monitor of a run, if it has one, and whether that has ended the run.
#[derive(Default)]
pub(crate) struct MonitorSlot {
    pub monitor: Option<Box<dyn RunMonitor>>,
    pub is_done: bool,
}

impl MonitorSlot {
    /// Whether it wants a state before a time.
    pub fn wants_before(&self, t: f64) -> bool {
        self.monitor
            .as_ref()
            .is_some_and(|monitor| monitor.next() < t)
    }
}

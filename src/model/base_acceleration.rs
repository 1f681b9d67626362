//! A base whose acceleration is known as a function of time, such as ground motion.

use crate::model::signal::Signal;

/// Base whose acceleration follows a signal, such as ground motion, under a pendulum or a linear system with an influence vector.
/// Coordinates are relative to the base.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseAcceleration {
    pub(super) signal: Signal,
}

impl BaseAcceleration {
    /// A base with an acceleration.
    pub fn new(signal: Signal) -> Self {
        Self { signal }
    }

    /// The acceleration.
    pub fn signal(&self) -> &Signal {
        &self.signal
    }
}

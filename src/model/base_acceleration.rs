//! A base whose acceleration is known as a function of time, such as ground motion.

use crate::model::signal::Signal;

/// A base that accelerates as a signal says, under a pendulum or a linear system with an influence vector; coordinates are relative to
/// the base.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseAcceleration {
    signal: Signal,
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

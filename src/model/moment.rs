//! A moment as forcings see it.

/// A time, and the forcing angle `frequency t + phase` there, which keeps its digits at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub time: f64,
    pub angle: f64,
}

//! A time, with the angle and the frequency of the forcing there.

/// A time, and the forcing angle `frequency t + phase` there, which keeps its digits at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub time: f64,
    pub angle: f64,
    pub frequency: f64,
}

impl Moment {
    /// A time later.
    #[inline]
    pub fn after(self, span: f64) -> Self {
        Self {
            time: self.time + span,
            angle: self.angle + self.frequency * span,
            ..self
        }
    }
}

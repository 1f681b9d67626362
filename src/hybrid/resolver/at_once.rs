//! Counts how often a stop is let go, or opens and closes again, at one instant, so that the loop can end it.

use crate::hybrid::pen::Pen;
use crate::tolerance::INSTANT;

/// The stops to which it happened, each as often as it did, at the instant at which it happened last.
#[derive(Debug, Clone, Default)]
pub(super) struct AtOnce {
    time: f64,
    stops: Vec<usize>,
}

impl AtOnce {
    /// It happened to a stop at a time.
    pub fn note(&mut self, now: f64, stop: usize) {
        if !is_one_instant(self.time, now) {
            self.time = now;
            self.stops.clear();
        }
        self.stops.push(stop);
    }

    /// How often it happened to a stop at the instant of a time.
    pub fn times(&self, now: f64, stop: usize) -> usize {
        let stops = self.stops.iter();
        if is_one_instant(self.time, now) {
            stops.filter(|&&other| other == stop).count()
        } else {
            0
        }
    }

    /// Puts them down, or takes them up.
    pub fn carry(&mut self, pen: &mut Pen) {
        pen.number(&mut self.time);
        pen.counts(&mut self.stops);
    }

    pub fn clear(&mut self) {
        self.stops.clear();
    }
}

/// Whether two times are one, but for rounding.
pub(crate) fn is_one_instant(a: f64, b: f64) -> bool {
    (a - b).abs() <= INSTANT * a.abs().max(b.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_begin_anew_at_another_instant() {
        let mut at_once = AtOnce::default();
        assert_eq!(at_once.times(1.0, 2), 0);
        at_once.note(1.0, 2);
        at_once.note(1.0, 0);
        at_once.note(1.0 + 1e-13, 2);
        assert_eq!(at_once.times(1.0, 2), 2);
        assert_eq!(at_once.times(1.0, 1), 0);
        assert_eq!(at_once.times(1.1, 2), 0);
        at_once.note(1.1, 2);
        assert_eq!(at_once.times(1.1, 2), 1);
        assert_eq!(at_once.times(1.1, 0), 0);
    }
}

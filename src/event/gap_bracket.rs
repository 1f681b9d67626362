//! Where a gap falls through zero on a flight: between a time at which it was open and one at which it was not.

/// Times between which a gap falls through zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapBracket {
    /// The last at which it was open; the start of the flight where it never was since.
    open: f64,
    /// The first after that at which it was not; infinite where there is none.
    pub closed: f64,
    /// One at which it is provably below zero; infinite where none is known.
    pub passed: f64,
    /// The gap that counts as zero: the rounding below zero of a flight that began on the stop, zero elsewhere.
    pub floor: f64,
}

impl GapBracket {
    /// The bracket at the start of a flight, from a gap with a root of some order there, zero for an open gap. A flight may rise by less
    /// than rounding left its start below zero.
    pub fn start(gap: f64, order: usize) -> Self {
        Self {
            open: 0.0,
            closed: f64::INFINITY,
            passed: f64::INFINITY,
            floor: if order > 0 { gap.min(0.0) } else { 0.0 },
        }
    }

    /// Includes a gap at a later time.
    #[inline]
    pub fn note(&mut self, time: f64, gap: f64) {
        if gap > self.floor {
            (self.open, self.closed, self.passed) = (time, f64::INFINITY, f64::INFINITY);
        } else {
            self.closed = self.closed.min(time);
        }
    }

    /// Narrows the bracket by a gap at a time inside.
    pub fn narrow(&mut self, time: f64, gap: f64) {
        if gap > self.floor {
            self.open = time;
        } else {
            self.closed = time;
        }
    }

    /// The time after `from` to try: that which is wanted, if there is one and it lies inside, else half-way.
    pub fn next(self, wanted: Option<f64>, from: f64) -> f64 {
        match wanted {
            Some(next) if next >= self.open && next <= self.closed => next,
            _ if self.closed.is_finite() => 0.5 * (self.open + self.closed),
            _ => from,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_stays_between_open_and_closed() {
        let mut bracket = GapBracket::start(0.4, 0);
        for (time, gap) in [(1.0, 0.2), (2.0, -1e-9), (3.0, -1e-9)] {
            bracket.note(time, gap);
        }
        assert_eq!((bracket.open, bracket.closed), (1.0, 2.0));
        assert_eq!(bracket.next(Some(1.3), 2.0), 1.3);
        assert_eq!(bracket.next(Some(0.7), 2.0), 1.5);
        assert_eq!(bracket.next(None, 2.0), 1.5);
        bracket.narrow(1.5, -1.0);
        assert_eq!(bracket.next(Some(1.7), 1.5), 1.25);
        // A gap that opens again has not been reached before.
        bracket.note(4.0, 0.1);
        assert_eq!(bracket.next(Some(5.0), 4.0), 5.0);
        // Without a time at which it is closed nothing is known but that it comes after the last at which it was open.
        assert_eq!(bracket.next(Some(3.0), 4.5), 4.5);
        assert_eq!(GapBracket::start(0.0, 1).next(Some(-0.1), 0.2), 0.2);
    }

    #[test]
    fn a_flight_from_just_below_a_stop_ends_where_it_began() {
        let mut bracket = GapBracket::start(-1e-16, 1);
        bracket.note(1.0, -1e-17);
        bracket.note(2.0, -2e-16);
        assert_eq!((bracket.open, bracket.closed), (1.0, 2.0));
        assert_eq!(GapBracket::start(-1e-16, 0).floor, 0.0);
    }
}

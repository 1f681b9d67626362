//! Time as whole forcing periods and a remainder, so that the forcing phase keeps its digits at any time (theory 4).

use std::f64::consts::TAU;

/// `2 pi - TAU` to the next 53 bits.
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;

/// A time: `whole` forcing periods and `local` beyond them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Clock {
    /// The forcing period; without forcing a power of two, so that a long sum of short flights keeps its digits.
    period: f64,
    /// The forcing frequency, zero without forcing.
    frequency: f64,
    whole: f64,
    /// Time since the start of the period.
    pub local: f64,
}

impl Clock {
    /// The clock at time t, for a forcing frequency; without forcing (zero) it counts in powers of two not below `beat`.
    pub fn new(t: f64, frequency: f64, beat: f64) -> Self {
        if frequency > 0.0 {
            return Self {
                period: TAU / frequency,
                frequency,
                whole: 0.0,
                local: 0.0,
            }
            .at(t);
        }
        let period = beat.clamp(1e-150, 1e150).log2().ceil().exp2();
        Self {
            period,
            frequency: 0.0,
            whole: 0.0,
            local: 0.0,
        }
        .at(t)
    }

    /// The same clock at another time.
    pub fn at(self, t: f64) -> Self {
        let Self {
            period, frequency, ..
        } = self;
        if frequency <= 0.0 {
            let whole = (t / period).floor();
            return Self {
                whole,
                local: t - whole * period,
                ..self
            };
        }
        // w t - 2 pi n in double-double arithmetic: a product of doubles is exact as a sum of two.
        let angle = t * frequency;
        let angle_low = t.mul_add(frequency, -angle);
        let whole = (angle / TAU).floor();
        let turns = whole * TAU;
        let turns_low = whole.mul_add(TAU, -turns) + whole * TAU_LOW;
        let local = ((angle - turns) + (angle_low - turns_low)) / frequency;
        Self {
            whole,
            local,
            ..self
        }
        .normalised()
    }

    #[inline]
    fn normalised(mut self) -> Self {
        if self.local >= 0.0 && self.local < self.period {
            return self;
        }
        let turns = (self.local / self.period).floor();
        if turns != 0.0 {
            self.local -= turns * self.period;
            self.whole += turns;
        }
        self
    }

    /// Whole periods and the time beyond them, from which the clock can be set again.
    pub fn reading(self) -> [f64; 2] {
        [self.whole, self.local]
    }

    /// The same clock set to a reading.
    pub fn set(self, [whole, local]: [f64; 2]) -> Self {
        Self {
            whole,
            local,
            ..self
        }
    }

    /// The time.
    pub fn time(self) -> f64 {
        self.whole * self.period + self.local
    }

    /// The clock `span` later.
    pub fn after(self, span: f64) -> Self {
        Self {
            local: self.local + span,
            ..self
        }
        .normalised()
    }

    /// The time from here to another clock of the same forcing.
    pub fn until(self, other: Self) -> f64 {
        (other.whole - self.whole) * self.period + (other.local - self.local)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_keeps_its_digits_after_a_billion_periods() {
        // 2^30 / (2 pi) periods of frequency 1: the remainder of 2^30 by 2 pi is known to many digits.
        let clock = Clock::new(1_073_741_824.0, 1.0, 1.0);
        assert!((clock.local.sin() - 1_073_741_824.0f64.sin()).abs() < 1e-15);
        assert!((clock.time() - 1_073_741_824.0).abs() < 1e-6);
        let later = clock.after(0.25);
        assert!((clock.until(later) - 0.25).abs() < 1e-15);
        let negative = Clock::new(-3.0, 2.0, 1.0);
        assert!((negative.time() + 3.0).abs() < 1e-15 && negative.local >= 0.0);
    }
}

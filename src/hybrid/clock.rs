//! Time in twice the precision, and with it the angle of the forcing: both keep their digits at any time, after any number of
//! flights, however slow or fast the forcing is (theory 4).

use crate::model::{Moment, nearest_turn, two_sum};
use std::f64::consts::PI;

/// A time, and the angle of the forcing from the nearest whole turn of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Clock {
    /// The time, and what rounding took from it.
    time: f64,
    rest: f64,
    /// Where the angle counts from: the time of a whole turn, likewise.
    turn: f64,
    turn_rest: f64,
    /// The forcing frequency, zero without forcing.
    frequency: f64,
}

impl Clock {
    /// The clock at time t, for a forcing frequency, zero without forcing.
    pub fn new(t: f64, frequency: f64) -> Self {
        Self {
            time: 0.0,
            rest: 0.0,
            turn: 0.0,
            turn_rest: 0.0,
            frequency,
        }
        .at(t)
    }

    /// The same clock at another time.
    pub fn at(self, t: f64) -> Self {
        self.set([t, 0.0])
    }

    /// The time and what rounding took from it, from which the clock can be set again.
    pub fn reading(self) -> [f64; 2] {
        [self.time, self.rest]
    }

    /// The same clock set to a reading.
    pub fn set(self, [time, rest]: [f64; 2]) -> Self {
        Self { time, rest, ..self }.turned()
    }

    /// All that it knows beside the frequency, from which it can be written again to the bit.
    pub fn written(self) -> [f64; 4] {
        [self.time, self.rest, self.turn, self.turn_rest]
    }

    /// The clock of the same frequency that was written.
    pub fn read(self, [time, rest, turn, turn_rest]: [f64; 4]) -> Self {
        Self {
            time,
            rest,
            turn,
            turn_rest,
            ..self
        }
    }

    /// The time.
    pub fn time(self) -> f64 {
        self.time
    }

    /// The angle of the forcing without its phase, within about half a turn of zero.
    #[inline]
    pub fn angle(self) -> f64 {
        self.frequency * ((self.time - self.turn) + (self.rest - self.turn_rest))
    }

    /// The moment that forcings of a phase see.
    #[inline]
    pub fn moment(self, phase: f64) -> Moment {
        Moment {
            time: self.time,
            rest: self.rest,
            angle: self.angle() + phase,
            frequency: self.frequency,
            since: self.time,
        }
    }

    /// The clock `span` later.
    #[inline]
    pub fn after(self, span: f64) -> Self {
        let (sum, lost) = two_sum(self.time, span);
        let (time, rest) = two_sum(sum, self.rest + lost);
        let then = Self { time, rest, ..self };
        if then.angle().abs() <= PI {
            then
        } else {
            then.turned()
        }
    }

    /// The time from here to another clock of the same forcing.
    pub fn until(self, other: Self) -> f64 {
        (other.time - self.time) + (other.rest - self.rest)
    }

    /// The same time, its angle counted from the whole turn nearest to it: `2 pi k/w` in twice the precision.
    fn turned(self) -> Self {
        let (turn, turn_rest) = nearest_turn([self.time, self.rest], self.frequency);
        Self {
            turn,
            turn_rest,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_keeps_its_digits_after_a_billion_periods() {
        for t in [1_073_741_824.0f64, -1_073_741_824.0, 3.0, -1e-9, 1e15] {
            let clock = Clock::new(t, 1.0);
            assert!((clock.angle().sin() - t.sin()).abs() < 1e-15, "{t}");
            assert!(clock.angle().abs() <= PI && clock.time() == t);
            let later = clock.after(0.25);
            assert_eq!(clock.until(later), 0.25);
            let turned = t.sin() * 0.25f64.cos() + t.cos() * 0.25f64.sin();
            assert!((later.angle().sin() - turned).abs() < 1e-15, "{t}");
        }
    }

    #[test]
    fn a_sum_of_short_flights_loses_nothing_however_slow_the_forcing() {
        for frequency in [0.0, 1e-308, 1e-17, 1e-9, 0.7, 1e6] {
            for start in [0.0, -1e6, 1e9] {
                // 2^-10 is added exactly; a third is not.
                let (count, third) = (3 << 14, 1.0 / 3.0);
                let mut clock = Clock::new(start, frequency);
                for _ in 0..count {
                    clock = clock.after(2f64.powi(-10)).after(third);
                }
                let sum = f64::from(count) / 1024.0 + f64::from(count) * third;
                let error = Clock::new(start, frequency).until(clock) - sum;
                assert!(
                    error.abs() <= 1e-16 * sum,
                    "{frequency:e} {start:e} {error:e}"
                );
                let angle = frequency * sum + Clock::new(start, frequency).angle();
                let miss = (clock.angle() - angle).sin().abs();
                assert!(
                    miss <= 1e-15 * (1.0 + frequency * sum),
                    "{frequency:e} {start:e} {miss:e}"
                );
            }
        }
    }

    #[test]
    fn a_reading_sets_the_clock_again() {
        let clock = Clock::new(-7.3, 2.3).after(1.0 / 3.0).after(1e-20);
        assert_eq!(Clock::new(0.0, 2.3).set(clock.reading()), clock);
        assert_eq!(Clock::new(0.0, 2.3).read(clock.written()), clock);
    }
}

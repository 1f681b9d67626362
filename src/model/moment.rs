//! A time, with the angle and the frequency of the forcing there.

use crate::model::turns::{nearest_turn, two_sum};

/// A time, and the forcing angle `frequency t + phase` there, which keeps its digits at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub time: f64,
    /// What rounding took from the time.
    pub rest: f64,
    pub angle: f64,
    pub frequency: f64,
    /// When the step began that it belongs to: of a signal that piece counts which begins no later.
    pub since: f64,
}

impl Moment {
    /// A time with the angle and frequency of the forcing there, the beginning of a step.
    #[inline]
    pub fn new(time: f64, angle: f64, frequency: f64) -> Self {
        Self {
            time,
            rest: 0.0,
            angle,
            frequency,
            since: time,
        }
    }

    /// A moment at an angle of the forcing, where nothing depends on time but by that.
    pub fn of_angle(angle: f64) -> Self {
        Self::new(0.0, angle, 0.0)
    }

    /// A time later, in the same step.
    #[inline]
    pub fn after(self, span: f64) -> Self {
        let (sum, lost) = two_sum(self.time, span);
        let (time, rest) = two_sum(sum, self.rest + lost);
        Self {
            time,
            rest,
            angle: self.angle + self.frequency * span,
            ..self
        }
    }

    /// The angle `frequency t` of another frequency, within half a turn of zero.
    pub fn angle_of(self, frequency: f64) -> f64 {
        let (turn, turn_rest) = nearest_turn([self.time, self.rest], frequency);
        frequency * ((self.time - turn) + (self.rest - turn_rest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_later_angles_of_any_frequency_keep_their_digits() {
        let (start, span, w) = (1e9, 1.234_567_890_123, 0.7);
        let [before, after] = [0.0, span].map(|s| Moment::new(start, 0.0, 0.0).after(s));
        let turned = after.angle_of(w) - before.angle_of(w);
        let whole = ((turned - w * span) / std::f64::consts::TAU).round();
        let off = turned - w * span - whole * std::f64::consts::TAU;
        assert!(off.abs() < 1e-15, "{off:e}");
        // In as many short spans too, each of which rounding takes from a time so large.
        let short = (0..1024).fold(before, |at, _| at.after(span / 1024.0));
        let off = short.angle_of(w) - after.angle_of(w);
        assert!(off.abs() < 1e-15, "{off:e}");
    }
}

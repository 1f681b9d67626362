//! Whole turns of an angle `w t` in twice the precision, from which angles are counted (theory 4).

use std::f64::consts::TAU;

/// `2 pi - TAU` to the next 53 bits. [exact]
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;
/// Turns up to which doubles count one by one, 2^53; an angle of more has no digits. [exact]
const COUNTABLE_TURNS: f64 = 9_007_199_254_740_992.0;

/// The time of the whole turn of frequency w that is nearest to a time, `2 pi k/w`, and what rounding took from it; the time, too, is
/// given with what rounding took from it.
pub(crate) fn nearest_turn([time, rest]: [f64; 2], w: f64) -> (f64, f64) {
    let turns = (time * w / TAU).round();
    if turns == 0.0 {
        return (0.0, 0.0);
    }
    if turns.abs() >= COUNTABLE_TURNS {
        return (time, rest);
    }
    let angle = turns * TAU;
    let lost = turns.mul_add(TAU, -angle) + turns * TAU_LOW;
    let quotient = angle / w;
    let remainder = (-quotient).mul_add(w, angle) + lost;
    two_sum(quotient, remainder / w)
}

/// `a + b` and what rounding takes from it.
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

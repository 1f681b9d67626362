//! Sine, cosine and exponential function within one unit in the last place, without a branch, so that several are taken in one register
//! with the bits of one (theory 4): arguments are led back to small ones by parts of pi/2 and ln 2 whose multiples are exact (W. J. Cody,
//! W. Waite, Software Manual for the Elementary Functions, 1980), series end where no digit changes. Numbers out of range are the standard library's.

use std::f64::consts::{FRAC_2_PI, LOG2_E};

/// Largest angle [rad] that is reduced here: fewer than 2^10 quarter turns, whose multiples of the leading parts of pi/2 are exact. [exact]
const LARGEST_ANGLE: f64 = 1000.0;
/// The largest exponent whose exponential function, and its inverse, has all its digits. [exact]
const LARGEST_EXPONENT: f64 = 700.0;
/// Added to a number below 2^51 it leaves the nearest integer, in its last bits. [exact]
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;
/// `pi/2` as a sum of 43 bits, the next 43, and the rest. [exact]
const QUARTER_TURN: [f64; 3] = [
    1.570_796_326_794_834_4,
    6.223_372_171_896_261e-14,
    3.521_559_865_183_2e-27,
];
/// `ln 2` as a sum of 42 bits and the rest. [exact]
const LN_2: [f64; 2] = [0.693_147_180_559_890_3, 5.497_923_018_708_371e-14];

/// `1/k!`
const fn reciprocal_factorial(k: u32) -> f64 {
    let (mut factorial, mut j) = (1.0, 2);
    while j <= k {
        factorial *= j as f64;
        j += 1;
    }
    1.0 / factorial
}

/// The coefficients `1/k!` of the exponential series. [exact]
const TERM: [f64; 19] = {
    let (mut terms, mut k) = ([1.0; 19], 0);
    while k < 19 {
        terms[k] = reciprocal_factorial(k as u32);
        k += 1;
    }
    terms
};

/// Sine and cosine of an angle.
#[inline]
pub(crate) fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() <= LARGEST_ANGLE {
        sin_cos_in_range(angle)
    } else {
        angle.sin_cos()
    }
}

/// `e^x`
#[inline]
pub(crate) fn exp(x: f64) -> f64 {
    if x.abs() <= LARGEST_EXPONENT {
        exp_in_range(x)
    } else {
        x.exp()
    }
}

/// Sines and cosines of K angles.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
pub(crate) fn sines_and_cosines<const K: usize>(angles: &[f64; K]) -> [[f64; K]; 2] {
    let [mut sines, mut cosines] = [[0.0; K]; 2];
    for k in 0..K {
        (sines[k], cosines[k]) = sin_cos_in_range(angles[k]);
    }
    let are_in_range = angles
        .iter()
        .fold(true, |are, x| are & (x.abs() <= LARGEST_ANGLE));
    if !are_in_range {
        for k in 0..K {
            (sines[k], cosines[k]) = sin_cos(angles[k]);
        }
    }
    [sines, cosines]
}

/// `e^x` of K numbers.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
pub(crate) fn exponentials<const K: usize>(x: &[f64; K]) -> [f64; K] {
    let mut all = [0.0; K];
    for k in 0..K {
        all[k] = exp_in_range(x[k]);
    }
    let are_in_range = x
        .iter()
        .fold(true, |are, x| are & (x.abs() <= LARGEST_EXPONENT));
    if !are_in_range {
        all = x.map(exp);
    }
    all
}

#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
fn sin_cos_in_range(angle: f64) -> (f64, f64) {
    let shifted = angle * FRAC_2_PI + TO_INTEGER;
    let (quarters, n) = (shifted.to_bits(), shifted - TO_INTEGER);
    // angle - n pi/2 = r + rest: the first difference is exact, what rounding takes from the second is kept.
    let (a, b) = (angle - n * QUARTER_TURN[0], n * QUARTER_TURN[1]);
    let left = a - b;
    let taken = left - a;
    let rounded = (a - (left - taken)) - (b + taken);
    let rest = rounded - n * QUARTER_TURN[2];
    let r = left + rest;
    let rest = (left - r) + rest;

    let (square, fourth) = (r * r, (r * r) * (r * r));
    // r - r^3/3! + ... and 1 - r^2/2! + ..., every other term by a power of r^4.
    let by_fourth = |c: [f64; 4]| c[0] + fourth * (c[1] + fourth * (c[2] + fourth * c[3]));
    let [down, up] = [
        by_fourth([3, 7, 11, 15].map(|k| -TERM[k])),
        by_fourth([5, 9, 13, 17].map(|k| TERM[k])),
    ];
    let cubic = r * (square * (down + square * up));
    let sin = r + (cubic + rest * (1.0 - 0.5 * square));
    let [up, down] = [
        by_fourth([4, 8, 12, 16].map(|k| TERM[k])),
        by_fourth([6, 10, 14, 18].map(|k| -TERM[k])),
    ];
    let half = 0.5 * square;
    let parabola = 1.0 - half;
    let lost = (1.0 - parabola) - half;
    let cos = parabola + (lost + (fourth * (up + square * down) - r * rest));

    let (s, c) = if quarters & 1 == 0 {
        (sin, cos)
    } else {
        (cos, sin)
    };
    let turned = |x: f64, quarters: u64| f64::from_bits(x.to_bits() ^ ((quarters & 2) << 62));
    (turned(s, quarters), turned(c, quarters.wrapping_add(1)))
}

#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
fn exp_in_range(x: f64) -> f64 {
    let shifted = x * LOG2_E + TO_INTEGER;
    let n = shifted - TO_INTEGER;
    // x - n ln 2 = a - b
    let (a, b) = (x - n * LN_2[0], n * LN_2[1]);
    let r = a - b;
    let (square, fourth) = (r * r, (r * r) * (r * r));
    let four = |k: usize| (TERM[k] + r * TERM[k + 1]) + square * (TERM[k + 2] + r * TERM[k + 3]);
    let series = four(2) + fourth * (four(6) + fourth * four(10));
    let power = 1.0 + (a + (square * series - b));
    // By 2^n, into its exponent.
    f64::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// The power of two that is nearest to a positive number, one for others.
pub(crate) fn power_of_two(x: f64) -> f64 {
    let power = x.log2().round().exp2();
    if power.is_normal() { power } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;
    use std::iter::successors;

    /// By how many of its last places a number is off another.
    fn places(x: f64, y: f64) -> u64 {
        if x == y || (x.is_nan() && y.is_nan()) {
            return 0;
        }
        x.to_bits().abs_diff(y.to_bits())
    }

    /// Sizes from 1e-300 to beyond every range, quarter turns and multiples of ln 2 with their neighbours, zeros and no numbers.
    fn arguments() -> Vec<f64> {
        let sizes = successors(Some(1e-300), |x| Some(x * 1.003)).take_while(|x| *x < 1e6);
        let near =
            |x: f64| (-4..=4).map(move |k| f64::from_bits(x.to_bits().wrapping_add_signed(k)));
        let quarters = (1..700).flat_map(|k| near(f64::from(k) * FRAC_PI_2));
        let doubles = (1..1100).flat_map(|k| near(f64::from(k) * std::f64::consts::LN_2));
        let rare = [
            0.0,
            -0.0,
            f64::INFINITY,
            f64::NAN,
            1e300,
            LARGEST_ANGLE,
            LARGEST_EXPONENT,
        ];
        let all: Vec<f64> = sizes.chain(quarters).chain(doubles).chain(rare).collect();
        all.iter().flat_map(|&x| [x, -x]).collect()
    }

    #[test]
    fn they_are_those_of_the_standard_library_to_one_place() {
        for x in arguments() {
            let ((s, c), e) = (sin_cos(x), exp(x));
            assert!(places(s, x.sin()) <= 1, "sin {x:e}: {s} {}", x.sin());
            assert!(places(c, x.cos()) <= 1, "cos {x:e}: {c} {}", x.cos());
            assert!(places(e, x.exp()) <= 1, "exp {x:e}: {e} {}", x.exp());
        }
        assert_eq!((sin_cos(0.0), exp(0.0)), ((0.0, 1.0), 1.0));
    }

    #[test]
    fn several_have_the_bits_of_one() {
        let arguments = arguments();
        let count = arguments.len();
        for i in 0..count {
            let x = [1, 7, 31, 113].map(|stride| arguments[i * stride % count]);
            let ([s, c], e) = (sines_and_cosines(&x), exponentials(&x));
            for k in 0..4 {
                let (sin, cos) = sin_cos(x[k]);
                let same = [(s[k], sin), (c[k], cos), (e[k], exp(x[k]))]
                    .map(|(one, other)| one.to_bits() == other.to_bits());
                assert!(same == [true; 3] || x[k].is_nan(), "{x:?} {k}");
            }
        }
    }
}

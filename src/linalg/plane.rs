//! Pairs of real numbers and 2 by 2 matrices, by rows.

use std::array::from_fn;

/// A vector of the plane.
pub(crate) type Pair = [f64; 2];

/// `A z`
#[inline]
pub(crate) fn times(a: &[Pair; 2], z: Pair) -> Pair {
    [
        a[0][0] * z[0] + a[0][1] * z[1],
        a[1][0] * z[0] + a[1][1] * z[1],
    ]
}

/// `a + b`
#[inline]
pub(crate) fn plus(a: Pair, b: Pair) -> Pair {
    from_fn(|i| a[i] + b[i])
}

/// `sqrt 2 - 1`, rounded up. [exact]
const DIAGONAL: f64 = 0.414_213_562_373_1;

/// No less than the length of `(x, y)` and at most 1.083 of it, without a root: `a + (sqrt 2 - 1) b` of the larger size and the smaller.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
pub(crate) fn longer_than(x: f64, y: f64) -> f64 {
    let (x, y) = (x.abs(), y.abs());
    if x > y {
        x + DIAGONAL * y
    } else {
        y + DIAGONAL * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_is_bounded_closely() {
        for k in 0..10_000 {
            let angle = f64::from(k) * 1e-3;
            let (y, x) = angle.sin_cos();
            let bound = longer_than(x, y);
            assert!((1.0 - 1e-15..1.083).contains(&bound), "{angle} {bound}");
        }
        assert_eq!((longer_than(-3.0, 0.0), longer_than(0.0, 2.0)), (3.0, 2.0));
        assert!(longer_than(f64::NAN, 1.0).is_nan() && longer_than(1.0, f64::NAN).is_nan());
    }
}

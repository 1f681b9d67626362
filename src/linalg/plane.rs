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

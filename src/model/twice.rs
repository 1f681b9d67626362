//! Numbers in twice the precision, in which long angles keep their digits (theory 14).

use crate::model::turns::{nearest_turn, two_sum};

/// A number in twice the precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Twice(pub f64, pub f64);

impl Twice {
    /// A number that is a double.
    pub fn of(x: f64) -> Self {
        Self(x, 0.0)
    }

    /// The sum.
    pub fn plus(self, other: Self) -> Self {
        let (sum, lost) = two_sum(self.0, other.0);
        let (high, low) = two_sum(sum, lost + (self.1 + other.1));
        Self(high, low)
    }

    /// The product.
    pub fn times(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let lost = self.0.mul_add(other.0, -product);
        let (high, low) = two_sum(product, lost + (self.0 * other.1 + self.1 * other.0));
        Self(high, low)
    }

    /// The quotient by a whole number.
    fn over(self, k: u32) -> Self {
        let divisor = f64::from(k);
        let first = self.0 / divisor;
        let rest = (-first).mul_add(divisor, self.0) + self.1;
        let (high, low) = two_sum(first, rest / divisor);
        Self(high, low)
    }

    /// The number as an angle [rad], reduced by whole turns to within half a turn of zero.
    pub fn reduced(self) -> f64 {
        let (turn, rest) = nearest_turn([self.0, self.1], 1.0);
        (self.0 - turn) + (self.1 - rest)
    }
}

/// The largest argument at which the series is summed as it is; of a larger one the argument is halved. [exact]
const EXPONENTIAL_SERIES_RANGE: f64 = 1.0;
/// The number of terms with which the series is within `1e-33` up to that argument, the rounding of twice the precision. [exact]
const EXPONENTIAL_SERIES_TERMS: u32 = 30;

/// `(e^x - 1)/x = sum_k x^k/(k + 1)!`; of a large x by that of its half, `p(2 y) = p(y) (1 + y p(y)/2)`.
pub(crate) fn mean_exponential(x: Twice) -> Twice {
    if x.0.abs() > EXPONENTIAL_SERIES_RANGE && x.0.is_finite() {
        let half = Twice(0.5 * x.0, 0.5 * x.1);
        let p = mean_exponential(half);
        let grown = Twice::of(1.0).plus(half.times(p).times(Twice::of(0.5)));
        return p.times(grown);
    }
    let one = Twice::of(1.0);
    (2..EXPONENTIAL_SERIES_TERMS)
        .rev()
        .fold(one, |sum, k| one.plus(sum.times(x).over(k)))
}

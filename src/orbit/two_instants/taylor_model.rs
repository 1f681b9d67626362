//! A function on a cell `t = origin + scale x`, `|x| <= 1`, as a Taylor polynomial in x with a proved remainder: the
//! coefficients `f^(k)/k!` at the origin for `k < TAYLOR_TERMS`, and a bound on `|f^(TAYLOR_TERMS)|/TAYLOR_TERMS!` over the whole cell. Sums
//! and products carry the bound along (Leibniz), so derivatives are enclosed as well as values (theory 5).

/// Terms of the polynomial. With another number bounds are as true, and the parts that they decide longer or shorter. [work]
pub(crate) const TAYLOR_TERMS: usize = 8;
/// A step of Newton's method towards a root, in units of the cell, below which it has come to an end. [work]
const STILL_ROOT: f64 = 1e-15;

/// The polynomial, and what bounds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TaylorModel {
    /// `f^(k)/k!` at the origin, in units x of the cell.
    c: [f64; TAYLOR_TERMS],
    /// Bounds on `|f^(k)|/k!` over the cell; the last is the remainder's.
    bounds: [f64; TAYLOR_TERMS + 1],
    /// Size of the numbers that the function was summed from: what its rounding is relative to.
    size: f64,
    is_constant: bool,
}

/// Bounds of every derivative from the polynomial at the origin and the bound of the highest: a Taylor shift by 1.
fn shifted(c: &[f64; TAYLOR_TERMS], rest: f64) -> [f64; TAYLOR_TERMS + 1] {
    let mut a = [rest; TAYLOR_TERMS + 1];
    for (a, c) in a.iter_mut().zip(c) {
        *a = c.abs();
    }
    for i in 0..TAYLOR_TERMS {
        for j in (i..TAYLOR_TERMS).rev() {
            a[j] += a[j + 1];
        }
    }
    a
}

impl TaylorModel {
    /// A number.
    pub fn constant(value: f64) -> Self {
        let mut series = Self {
            c: [0.0; TAYLOR_TERMS],
            bounds: [0.0; TAYLOR_TERMS + 1],
            size: value.abs(),
            is_constant: true,
        };
        series.c[0] = value;
        series.bounds[0] = value.abs();
        series
    }

    /// The function x.
    pub fn x() -> Self {
        let mut c = [0.0; TAYLOR_TERMS];
        c[1] = 1.0;
        Self::new(c, 0.0, 1.0)
    }

    /// A function from its coefficients, the bound on the next one, and the size of its terms.
    pub fn new(c: [f64; TAYLOR_TERMS], rest: f64, size: f64) -> Self {
        let bounds = shifted(&c, rest);
        let is_constant = bounds[1] == 0.0;
        Self {
            c,
            bounds,
            size: size.max(bounds[0]),
            is_constant,
        }
    }

    /// Whether the function is zero all over.
    pub fn is_zero(&self) -> bool {
        self.bounds[0] == 0.0
    }

    /// The sum of `sign a b`.
    pub fn sum_of_products<'a>(terms: impl Iterator<Item = (f64, &'a Self, &'a Self)>) -> Self {
        let (mut c, mut rest, mut size) = ([0.0; TAYLOR_TERMS], 0.0, 0.0);
        for (sign, a, b) in terms {
            // Of errors the first order: what one factor is known to, times the other, which may be far below the terms it was summed from.
            let first_order = a.bounds[0] * b.size + a.size * b.bounds[0];
            size += first_order.min(a.size * b.size);
            let (a, b) = if b.is_constant { (b, a) } else { (a, b) };
            if a.is_constant {
                let factor = sign * a.c[0];
                for (c, b) in c.iter_mut().zip(&b.c) {
                    *c += factor * b;
                }
                rest += factor.abs() * b.bounds[TAYLOR_TERMS];
                continue;
            }
            for i in 0..TAYLOR_TERMS {
                let factor = sign * a.c[i];
                for j in 0..TAYLOR_TERMS - i {
                    c[i + j] += factor * b.c[j];
                }
            }
            for i in 0..=TAYLOR_TERMS {
                rest += a.bounds[i] * b.bounds[TAYLOR_TERMS - i];
            }
        }
        Self::new(c, rest, size)
    }

    /// The sum of `factor a`.
    pub fn sum<'a>(terms: impl Iterator<Item = (f64, &'a Self)>) -> Self {
        let (mut c, mut rest, mut size) = ([0.0; TAYLOR_TERMS], 0.0, 0.0);
        for (factor, a) in terms {
            for (c, a) in c.iter_mut().zip(&a.c) {
                *c += factor * a;
            }
            rest += factor.abs() * a.bounds[TAYLOR_TERMS];
            size += factor.abs() * a.size;
        }
        Self::new(c, rest, size)
    }

    /// One over it; `None` where bounds do not keep it from zero.
    pub fn reciprocal(&self) -> Option<Self> {
        let [first, others @ ..] = &self.c;
        let varying: f64 = others.iter().map(|c| c.abs()).sum();
        let least = first.abs() - varying - self.remainder();
        if least.is_nan() || least <= 0.0 {
            return None;
        }
        // The derivatives of f (1/f) = 1, one after the other.
        let mut c = [1.0 / first; TAYLOR_TERMS];
        let mut bounds = [1.0 / least; TAYLOR_TERMS + 1];
        for k in 1..=TAYLOR_TERMS {
            bounds[k] = (1..=k).map(|j| self.bounds[j] * bounds[k - j]).sum::<f64>() / least;
            if k < TAYLOR_TERMS {
                c[k] = -(1..=k).map(|j| self.c[j] * c[k - j]).sum::<f64>() / first;
            }
        }
        let size = self.size / (first * first);
        Some(Self::new(c, bounds[TAYLOR_TERMS], size))
    }

    /// The polynomial at x.
    pub fn value(&self, x: f64) -> f64 {
        self.c.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    /// The value at the origin.
    pub fn at_origin(&self) -> f64 {
        self.c[0]
    }

    /// The derivative in x at the origin.
    pub fn slope_at_origin(&self) -> f64 {
        self.c[1]
    }

    /// Bound on the error of the polynomial over the whole interval.
    pub fn remainder(&self) -> f64 {
        self.bounds[TAYLOR_TERMS]
    }

    /// Bound on the value over the cell.
    pub fn bound(&self) -> f64 {
        self.bounds[0]
    }

    /// See the field.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Whether the function provably stays farther than `floor` from zero over the cell.
    pub fn is_clear_of_zero(&self, floor: f64) -> bool {
        let varying: f64 = self.c[1..].iter().map(|c| c.abs()).sum();
        self.c[0].abs() > varying + self.remainder() + floor
    }

    /// Whether the derivative provably keeps one sign over the cell.
    pub fn is_monotone(&self) -> bool {
        let varying: f64 = (2..TAYLOR_TERMS).map(|k| k as f64 * self.c[k].abs()).sum();
        self.c[1].abs() > varying + TAYLOR_TERMS as f64 * self.remainder()
    }

    /// The zero of the polynomial nearest to where Newton's method from `x` leads, kept in `|x| <= 1`.
    pub fn newton(&self, mut x: f64) -> f64 {
        for _ in 0..30 {
            let (mut value, mut slope) = (0.0, 0.0);
            for c in self.c.iter().rev() {
                slope = slope * x + value;
                value = value * x + c;
            }
            let next = (x - value / slope).clamp(-1.0, 1.0);
            if !next.is_finite() || (next - x).abs() < STILL_ROOT {
                break;
            }
            x = next;
        }
        x
    }
}

/// One entry of the conditions before it is scaled: two more coefficients than a `TaylorModel` and the bounds of these orders
/// too, so that a simple or double zero known to lie at the origin can be divided out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct UnscaledModel {
    /// `f^(k)/k!`, in units x of the cell.
    pub c: [f64; TAYLOR_TERMS + 2],
    /// Bounds on `|f^(k)|/k!` over the cell for `k = TAYLOR_TERMS`, `TAYLOR_TERMS + 1` and `TAYLOR_TERMS + 2`.
    pub rest: [f64; 3],
    /// Size of the terms at the origin.
    pub size: f64,
}

impl UnscaledModel {
    /// A number.
    pub fn constant(value: f64) -> Self {
        let mut entry = Self {
            size: value.abs(),
            ..Self::default()
        };
        entry.c[0] = value;
        entry
    }

    /// Adds `factor` times another entry.
    pub fn add(&mut self, factor: f64, other: &Self) {
        for (a, b) in self.c.iter_mut().zip(&other.c) {
            *a += factor * b;
        }
        for (a, b) in self.rest.iter_mut().zip(&other.rest) {
            *a += factor.abs() * b;
        }
        self.size += factor.abs() * other.size;
    }

    /// The sum of two entries times factors.
    pub fn combined(factors: [f64; 2], entries: [&Self; 2]) -> Self {
        let mut sum = Self::default();
        sum.add(factors[0], entries[0]);
        sum.add(factors[1], entries[1]);
        sum
    }

    /// The entry times a number.
    pub fn series(&self, factor: f64) -> TaylorModel {
        let mut c = [0.0; TAYLOR_TERMS];
        c.copy_from_slice(&self.c[..TAYLOR_TERMS]);
        TaylorModel::new(
            c.map(|x| x * factor),
            factor.abs() * self.rest[0],
            factor.abs() * self.size,
        )
    }

    /// The entry, whose first `power` coefficients are zero, over `x^power`, times a number: `|(f/x)^(k)|/k!` is at most
    /// the bound on `|f^(k+1)|/(k+1)!`.
    pub fn over_x(&self, power: usize, factor: f64) -> TaylorModel {
        let mut c = [0.0; TAYLOR_TERMS];
        c.copy_from_slice(&self.c[power..power + TAYLOR_TERMS]);
        TaylorModel::new(c.map(|x| x * factor), factor.abs() * self.rest[power], 0.0)
    }

    /// Bounds on `|f^(k)|/k!` over the cell, of every order.
    fn bounds(&self) -> [f64; TAYLOR_TERMS + 3] {
        let mut all = [self.rest[2]; TAYLOR_TERMS + 3];
        for (bound, c) in all.iter_mut().zip(&self.c) {
            *bound = c.abs();
        }
        for i in 0..TAYLOR_TERMS + 2 {
            for j in (i..TAYLOR_TERMS + 2).rev() {
                all[j] += all[j + 1];
            }
        }
        for (bound, rest) in all[TAYLOR_TERMS..].iter_mut().zip(self.rest) {
            *bound = bound.min(rest);
        }
        all
    }

    /// The product of two entries.
    pub fn product(a: &Self, b: &Self) -> Self {
        let mut product = Self {
            size: a.size * b.size,
            ..Self::default()
        };
        for (i, x) in a.c.iter().enumerate() {
            for (own, y) in product.c[i..].iter_mut().zip(&b.c) {
                *own += x * y;
            }
        }
        let (a, b) = (a.bounds(), b.bounds());
        for (k, rest) in (TAYLOR_TERMS..).zip(&mut product.rest) {
            *rest = (0..=k).map(|i| a[i] * b[k - i]).sum();
        }
        product
    }

    /// The integral from the origin on, `scale` times that over x.
    pub fn integral(&self, scale: f64) -> Self {
        let bounds = self.bounds();
        let mut integral = Self {
            size: scale.abs() * self.size,
            ..Self::default()
        };
        for k in 1..TAYLOR_TERMS + 3 {
            let factor = scale / k as f64;
            if k < TAYLOR_TERMS + 2 {
                integral.c[k] = factor * self.c[k - 1];
            }
            if k >= TAYLOR_TERMS {
                integral.rest[k - TAYLOR_TERMS] = factor.abs() * bounds[k - 1];
            }
        }
        integral
    }

    /// The entry, whose first coefficient is zero, over x; of its bounds the last is not known.
    pub fn shifted(&self) -> Self {
        let mut c = [0.0; TAYLOR_TERMS + 2];
        c[..=TAYLOR_TERMS].copy_from_slice(&self.c[1..]);
        let [_, first, second] = self.rest;
        Self {
            c,
            rest: [first, second, f64::INFINITY],
            size: 0.0,
        }
    }

    /// The entry times x; only the last of its bounds is known.
    pub fn times_x(&self) -> Self {
        let mut c = [0.0; TAYLOR_TERMS + 2];
        c[1..].copy_from_slice(&self.c[..=TAYLOR_TERMS]);
        // (x f)^(k)/k! = x f^(k)/k! + f^(k-1)/(k-1)!
        let rest = [f64::INFINITY, f64::INFINITY, self.rest[1] + self.rest[2]];
        Self {
            c,
            rest,
            size: self.size,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `a cos(k x) + b` over `|x| <= 1`.
    fn cosine(a: f64, k: f64, b: f64) -> UnscaledModel {
        let mut entry = UnscaledModel {
            size: a.abs() + b.abs(),
            ..UnscaledModel::default()
        };
        let mut factor = a;
        for n in 0..TAYLOR_TERMS + 3 {
            if n >= TAYLOR_TERMS {
                entry.rest[n - TAYLOR_TERMS] = factor.abs();
            }
            if n < TAYLOR_TERMS + 2 {
                entry.c[n] = [factor, 0.0, -factor, 0.0][n % 4];
            }
            factor *= k / (n + 1) as f64;
        }
        entry.c[0] += b;
        entry
    }

    #[test]
    fn products_and_their_derivatives_stay_inside_their_bounds() {
        for k in [0.1, 0.5, 1.0] {
            let (f, g) = (
                cosine(2.0, k, 0.3).series(1.0),
                cosine(-1.0, 1.7 * k, 1.0).series(1.0),
            );
            let three = TaylorModel::constant(3.0);
            let h = TaylorModel::sum_of_products([(1.0, &f, &g), (-1.0, &three, &f)].into_iter());
            let exact = |x: f64| {
                let (f, g) = (2.0 * (k * x).cos() + 0.3, 1.0 - (1.7 * k * x).cos());
                f * g - 3.0 * f
            };
            for i in -50..=50 {
                let x = f64::from(i) / 50.0;
                let miss = (h.value(x) - exact(x)).abs();
                assert!(
                    miss <= h.remainder() * x.abs().powi(8) + 1e-14,
                    "{k} {x} {miss:e} {:e}",
                    h.remainder()
                );
                assert!(exact(x).abs() <= h.bound());
                let slope = (exact(x + 1e-6) - exact(x - 1e-6)) / 2e-6;
                assert!(slope.abs() <= h.bounds[1] + 1e-8);
            }
        }
    }

    #[test]
    fn a_known_zero_is_divided_out() {
        // (cos(x) - 1)/x
        let over = cosine(1.0, 1.0, -1.0).over_x(1, 1.0);
        for x in [-1.0, -0.3, 0.2, 0.9f64] {
            let miss = (over.value(x) - (x.cos() - 1.0) / x).abs();
            assert!(miss <= over.remainder() * x.abs().powi(8) + 1e-15);
        }
        assert!(over.remainder() < 1e-5);
        // (x cos(2 x) - x cos(x))/x^2
        let mut difference = cosine(1.0, 2.0, 0.0).times_x();
        difference.add(-1.0, &cosine(1.0, 1.0, 0.0).times_x());
        let over = difference.over_x(2, 1.0);
        for x in [-1.0, -0.3, 0.2, 0.9f64] {
            let miss = (over.value(x) - ((2.0 * x).cos() - x.cos()) / x).abs();
            assert!(miss <= over.remainder() * x.abs().powi(8) + 1e-15);
        }
        assert!(over.remainder() < 1e-2);
    }

    #[test]
    fn integrals_of_products_stay_inside_their_bounds() {
        // The integral of 2 cos(x) (3 - cos(0.6 x)).
        let (one, other) = (cosine(2.0, 1.0, 0.0), cosine(-1.0, 0.6, 3.0));
        let found = UnscaledModel::product(&one, &other).integral(1.0);
        let exact = |x: f64| 6.0 * x.sin() - (1.6 * x).sin() / 1.6 - (0.4 * x).sin() / 0.4;
        let (whole, over) = (found.series(1.0), found.over_x(1, 1.0));
        assert!(whole.remainder() < 1e-2);
        for x in [-1.0, -0.3, 0.2, 0.9f64] {
            let miss = (whole.value(x) - exact(x)).abs();
            assert!(
                miss <= whole.remainder() * x.abs().powi(8) + 1e-15,
                "{x} {miss:e}"
            );
            let miss = (over.value(x) - exact(x) / x).abs();
            assert!(
                miss <= over.remainder() * x.abs().powi(8) + 1e-15,
                "{x} {miss:e}"
            );
        }
    }

    #[test]
    fn a_reciprocal_stays_inside_its_bounds() {
        let f = cosine(0.3, 0.3, -1.5).series(1.0);
        let over = f.reciprocal().expect("away from zero");
        for x in [-1.0, -0.3, 0.0, 0.2, 0.9f64] {
            let exact = 1.0 / (0.3 * (0.3 * x).cos() - 1.5);
            let miss = (over.value(x) - exact).abs();
            assert!(
                miss <= over.remainder() * x.abs().powi(8) + 1e-15,
                "{x} {miss:e}"
            );
        }
        assert!(over.remainder() < 1e-3);
        assert!(cosine(1.0, 1.0, -0.9).series(1.0).reciprocal().is_none());
    }

    #[test]
    fn what_is_decided_is_true() {
        let (mut clear, mut monotone) = (0, 0);
        for i in 0..200 {
            let (k, b) = (0.02 * f64::from(i % 50), 0.5 - 0.01 * f64::from(i));
            let f = cosine(1.0, k, b).series(1.0);
            let lowest = k.cos() + b;
            if f.is_clear_of_zero(0.0) {
                clear += 1;
                assert!(lowest * (1.0 + b) > 0.0, "{k} {b}");
            }
            monotone += usize::from(f.is_monotone());
        }
        assert!(clear > 100 && monotone == 0, "{clear} {monotone}");
    }
}

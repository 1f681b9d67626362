//! The gap near one time as a cubic with a certified remainder, `|h(r) - sum c_k r^k| <= quartic r^4 + quintic r^5`, and
//! what follows from it on `0 <= r <= span`, proved by the Bernstein form: a polynomial is no smaller than its least
//! Bernstein coefficient (theory 8).

use crate::root::Bracket;
use crate::tolerance::FALLING_ROOT_STEP;

/// Values of a cubic for its root in a bracket, halvings among them. [work]
const MOST_CUBIC_POLISHES: usize = 60;

/// Taylor coefficients of a gap to third order, and the bound on the rest.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GapModel {
    /// `h^(k)/k!`
    pub c: [f64; 4],
    /// Bound on the fourth-order remainder.
    pub quartic: f64,
    /// Bound on its growth.
    pub quintic: f64,
    /// Size of the numbers that c[0] was summed from.
    pub size: f64,
}

/// What the gap does over a span, as far as it can be proved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// Falling all over.
    Falling,
    /// Lowest at one of the ends: rising, or concave.
    LowestAtEnd,
    /// Convex with its one minimum inside: at a time `at` and of a value `value` by the cubic; the gap's own minimum, which
    /// may be elsewhere, differs from that by `error` at the most.
    Minimum { at: f64, value: f64, error: f64 },
    /// Nothing could be proved.
    Unknown,
}

/// Whether every Bernstein coefficient on [0, 1] of `sum a_k x^k`, degree 4, is positive, and with them the polynomial.
/// Comparisons, not minima: a NaN proves nothing; all of them, without a branch.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[allow(clippy::needless_bitwise_bool, reason = "without a branch")]
#[inline(always)]
fn is_positive_4(a: [f64; 5]) -> bool {
    let b1 = a[0] + a[1] * 0.25;
    let b2 = a[0] + a[1] * 0.5 + a[2] * (1.0 / 6.0);
    let b3 = a[0] + a[1] * 0.75 + a[2] * 0.5 + a[3] * 0.25;
    let b4 = a[0] + a[1] + a[2] + a[3] + a[4];
    (a[0] > 0.0) & (b1 > 0.0) & (b2 > 0.0) & (b3 > 0.0) & (b4 > 0.0)
}

/// The same for degree 3.
#[inline]
fn is_positive_3(a: [f64; 4]) -> bool {
    let b1 = a[0] + a[1] * (1.0 / 3.0);
    let b2 = a[0] + a[1] * (2.0 / 3.0) + a[2] * (1.0 / 3.0);
    let b3 = a[0] + a[1] + a[2] + a[3];
    (a[0] > 0.0) && (b1 > 0.0) && (b2 > 0.0) && (b3 > 0.0)
}

/// The same for degree 2.
#[inline]
fn is_positive_2(a: [f64; 3]) -> bool {
    (a[0] > 0.0) && (a[0] + 0.5 * a[1] > 0.0) && (a[0] + a[1] + a[2] > 0.0)
}

impl GapModel {
    /// The cubic at r.
    pub fn value(&self, r: f64) -> f64 {
        self.c[0] + r * (self.c[1] + r * (self.c[2] + r * self.c[3]))
    }

    /// The slope of the cubic at r.
    #[inline]
    pub fn slope(&self, r: f64) -> f64 {
        self.c[1] + r * (2.0 * self.c[2] + 3.0 * r * self.c[3])
    }

    /// The model above a floor.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn above(&self, floor: f64) -> Self {
        let [gap, speed, bend, third] = self.c;
        Self {
            c: [gap - floor, speed, bend, third],
            ..*self
        }
    }

    /// The model from a root of some order on.
    pub fn only(&self, order: usize) -> Self {
        let mut c = self.c;
        c[..order].fill(0.0);
        Self { c, ..*self }
    }

    /// The model a step later, by the cubic alone.
    pub fn after(&self, step: f64) -> Self {
        let [_, b, c, d] = self.c;
        Self {
            c: [
                self.value(step),
                b + step * (2.0 * c + step * (3.0 * d)),
                c + step * (3.0 * d),
                d,
            ],
            ..*self
        }
    }

    /// Bound on what the cubic leaves out of the gap at r.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn remainder(&self, r: f64) -> f64 {
        let r2 = r * r;
        r2 * r2 * (self.quartic + r * self.quintic)
    }

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn scaled(&self, span: f64) -> ([f64; 4], f64) {
        let s2 = span * span;
        let a = [
            self.c[0],
            self.c[1] * span,
            self.c[2] * s2,
            self.c[3] * s2 * span,
        ];
        (a, self.remainder(span))
    }

    /// How far the gap can be from its value at r = 0 anywhere on the span.
    pub fn spread(&self, span: f64) -> f64 {
        let (a, rest) = self.scaled(span);
        a[1].abs() + a[2].abs() + a[3].abs() + rest
    }

    /// Whether it is provably above a floor all over the span.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn is_above(&self, floor: f64, span: f64) -> bool {
        let (a, rest) = self.scaled(span);
        is_positive_4([a[0] - floor, a[1], a[2], a[3], -rest])
    }

    /// What can be proved over the span, in the order of what it costs.
    pub fn shape(&self, span: f64) -> Shape {
        let (a, rest) = self.scaled(span);
        // The slope a1 + 2 a2 x + 3 a3 x^2 -+ 4 (5) rest x^3, in units of the span.
        let slope_rest = 5.0 * rest;
        if is_positive_3([-a[1], -2.0 * a[2], -3.0 * a[3], -slope_rest]) {
            return Shape::Falling;
        }
        if is_positive_3([a[1], 2.0 * a[2], 3.0 * a[3], -slope_rest]) {
            return Shape::LowestAtEnd;
        }
        let curvature_rest = 20.0 * rest;
        if is_positive_2([-2.0 * a[2], -6.0 * a[3], -curvature_rest]) {
            return Shape::LowestAtEnd;
        }
        if is_positive_2([2.0 * a[2], 6.0 * a[3], -curvature_rest]) {
            if a[1] >= 0.0 {
                return Shape::LowestAtEnd;
            }
            let end_slope = a[1] + 2.0 * a[2] + 3.0 * a[3];
            if end_slope - slope_rest > 0.0 {
                let at = self.stationary_point(span);
                return Shape::Minimum {
                    at,
                    value: self.value(at),
                    error: rest,
                };
            }
        }
        Shape::Unknown
    }

    /// The zero of the slope `b + 2 c r + 3 d r^2` of a cubic that is convex on the span, in the form without
    /// cancellation.
    fn stationary_point(&self, span: f64) -> f64 {
        let [_, b, c, d] = self.c;
        let root = (c * c - 3.0 * d * b).max(0.0).sqrt();
        (-b / (c + root)).clamp(0.0, span)
    }

    /// The first root of a cubic that falls from `c[0] >= 0` through zero before `span`: Newton's method inside the bracket, to the last places of
    /// the span, since it is a first guess.
    pub fn falling_root(&self, span: f64) -> f64 {
        let mut between = Bracket::new([0.0, span]);
        let mut r = if self.c[1] < 0.0 {
            (-self.c[0] / self.c[1]).clamp(0.0, span)
        } else {
            between.middle()
        };
        for _ in 0..MOST_CUBIC_POLISHES {
            let value = self.value(r);
            between.narrow(r, value > 0.0);
            let wanted = r - value / self.slope(r);
            // The error of Newton's method is the square of its step.
            let (next, sharp) = if between.has(wanted) {
                (wanted, FALLING_ROOT_STEP)
            } else {
                (between.middle(), f64::EPSILON)
            };
            if (next - r).abs() <= sharp * span {
                return next;
            }
            r = next;
        }
        r
    }

    /// The same gap after an impact, its root at r = 0 divided out: `h/r`, whose sign is that of the gap. `order` is the
    /// multiplicity of the root.
    pub fn deflated(&self, order: usize) -> DeflatedGapModel {
        let mut c = [0.0; 4];
        c[..4 - order].copy_from_slice(&self.c[order..]);
        DeflatedGapModel {
            c,
            order,
            quartic: self.quartic,
            quintic: self.quintic,
        }
    }
}

/// `h(r)/r^order` with its remainder `quartic r^(4 - order) + quintic r^(5 - order)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DeflatedGapModel {
    c: [f64; 4],
    order: usize,
    quartic: f64,
    quintic: f64,
}

impl DeflatedGapModel {
    /// Coefficients in units x of the span, degree at most 3, and the remainder at its end, which goes as
    /// `x^(4 - order)`.
    fn scaled(&self, span: f64) -> ([f64; 4], f64) {
        let mut a = self.c;
        let mut power = 1.0;
        for (k, x) in a.iter_mut().enumerate() {
            *x *= power;
            if k + self.order < 4 {
                power *= span;
            }
        }
        (a, (self.quartic + self.quintic * span) * power)
    }

    /// Whether the gap stays positive on the whole span after r = 0.
    pub fn is_positive(&self, span: f64) -> bool {
        let (mut a, rest) = self.scaled(span);
        a[4 - self.order] -= rest;
        is_positive_3(a)
    }

    /// Whether the deflated gap provably falls through zero on the span.
    pub fn crosses(&self, span: f64) -> bool {
        let (a, rest) = self.scaled(span);
        let mut slope = [-a[1], -2.0 * a[2], -3.0 * a[3], 0.0];
        slope[3 - self.order] -= 4.0 * rest;
        a[0] + a[1] + a[2] + a[3] + rest < 0.0 && is_positive_3(slope)
    }

    /// How far the gap itself can be from zero anywhere on the span.
    pub fn spread(&self, span: f64) -> f64 {
        let (a, rest) = self.scaled(span);
        let deflated = a.iter().map(|x| x.abs()).sum::<f64>() + rest;
        (0..self.order).fold(deflated, |spread, _| spread * span)
    }

    /// The root of the deflated cubic on a span on which it crosses.
    pub fn root(&self, span: f64) -> f64 {
        GapModel {
            c: self.c,
            ..GapModel::default()
        }
        .falling_root(span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The model at t of `1 + a - cos(t)`, whose least value is a at t = 0 (mod 2 pi).
    fn cosine(a: f64, t: f64) -> GapModel {
        GapModel {
            c: [1.0 + a - t.cos(), t.sin(), t.cos() / 2.0, -t.sin() / 6.0],
            quartic: 1.0 / 24.0,
            quintic: 0.0,
            size: 2.0,
        }
    }

    #[test]
    fn what_is_proved_is_true() {
        for a in [0.5, 1e-3, 0.0, -1e-3] {
            for i in -40..40 {
                let t = f64::from(i) * 0.1;
                for level in 0..12 {
                    let span = 2.0 * 0.5f64.powi(level);
                    let samples: Vec<f64> =
                        (0..=200).map(|k| t + span * f64::from(k) / 200.0).collect();
                    let gap = |t: f64| 1.0 + a - t.cos();
                    let lowest = samples
                        .iter()
                        .map(|&t| gap(t))
                        .fold(f64::INFINITY, f64::min);
                    let model = cosine(a, t);
                    if model.is_above(0.0, span) {
                        assert!(lowest > 0.0);
                        continue;
                    }
                    match model.shape(span) {
                        Shape::Falling => {
                            assert!(samples.windows(2).all(|w| gap(w[1]) < gap(w[0])));
                        }
                        Shape::LowestAtEnd => assert!(lowest >= gap(t).min(gap(t + span)) - 1e-15),
                        Shape::Minimum { value, error, .. } => {
                            assert!((value - a).abs() <= error + 1e-15, "{value} {a} {error}");
                        }
                        Shape::Unknown => assert!(span > 1e-3),
                    }
                }
            }
        }
    }

    #[test]
    fn the_minimum_of_a_convex_cubic_is_exact() {
        // (r - 1)^2 (r + 2)/10 - 1e-9 has its minimum at 1, far from where the curvature at 0 points.
        let model = GapModel {
            c: [0.2 - 1e-9, -0.3, 0.0, 0.1],
            ..GapModel::default()
        };
        assert!((model.stationary_point(2.0) - 1.0).abs() < 1e-15);
        assert!((model.value(model.stationary_point(2.0)) + 1e-9).abs() < 1e-16);
    }

    #[test]
    fn a_low_flight_is_found_behind_its_own_start() {
        // h = v r - r^2/2: the next root is at 2 v, however small v is.
        for v in [1.0, 1e-6, 1e-12] {
            let model = GapModel {
                c: [1e-17, v, -0.5, 0.0],
                ..GapModel::default()
            };
            let deflated = model.deflated(1);
            assert!(deflated.is_positive(1.9 * v) && !deflated.is_positive(2.1 * v));
            assert!(deflated.crosses(3.0 * v));
            assert!((deflated.root(3.0 * v) / (2.0 * v) - 1.0).abs() < 1e-14);
        }
    }
}

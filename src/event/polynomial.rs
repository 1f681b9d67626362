//! The gap along one step of an integrator as a quintic (theory 8): value, slope and curvature are known at both ends. Its
//! Bernstein form says at once where there is no contact; elsewhere its extrema part it into monotone pieces, so that
//! no contact between two samples is missed. A known root at the start is divided out.

use crate::event::first_root::FirstRoot;
use crate::event::touch::Bottom;
use crate::root::polynomial::{QUINTIC_SIZE, bracketed_root, derivative, roots, value};
use crate::tolerance::{ERROR_FACTOR, QUINTIC_ERROR_PART};

/// `sum c_k x^k`, `0 <= x <= 1` along the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quintic {
    c: [f64; QUINTIC_SIZE],
}

/// Value, slope and second derivative of the gap at both ends of a step, by parts of the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EndValues {
    start: [f64; 3],
    end: [f64; 3],
}

impl EndValues {
    /// The ends of a step of length h; a root of the given order at the start is made exact.
    #[inline]
    pub fn new(mut start: [f64; 3], end: [f64; 3], h: f64, order: usize) -> Self {
        start[..order.min(3)].fill(0.0);
        let scaled = |[p, d, s]: [f64; 3]| [p, h * d, h * h * s];
        Self {
            start: scaled(start),
            end: scaled(end),
        }
    }

    /// The coefficients of the quintic in Bernstein's form.
    #[inline]
    fn bernstein(&self) -> [f64; QUINTIC_SIZE] {
        let ([p, d, s], [p1, d1, s1]) = (self.start, self.end);
        [
            p,
            p + 0.2 * d,
            p + 0.4 * d + 0.05 * s,
            p1 - 0.4 * d1 + 0.05 * s1,
            p1 - 0.2 * d1,
            p1,
        ]
    }

    /// Whether the quintic stays above a floor, because its Bernstein coefficients do, by so much that a motion near to it does.
    pub fn are_far(&self, floor: f64) -> bool {
        let bernstein = self.bernstein();
        let most = bernstein.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let least = bernstein.into_iter().fold(f64::INFINITY, f64::min);
        least > floor + QUINTIC_ERROR_PART * (most - least)
    }

    /// Whether the quintic stays above a floor, because its Bernstein coefficients do. A root at the start, its floor zero,
    /// is divided out: `x B_j^4(x) = (j + 1)/5 B_{j+1}^5(x)`, so that its coefficients are skipped and the others keep their
    /// signs.
    #[inline]
    pub fn are_clear(&self, order: usize, floor: f64) -> bool {
        let bernstein = self.bernstein();
        let floor = if order == 0 { floor } else { 0.0 };
        bernstein[order.min(QUINTIC_SIZE - 1)..]
            .iter()
            .all(|b| *b > floor)
    }
}

/// How a minimum of the gap is judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judgement {
    /// Distance from zero within which a minimum is a touch without impact.
    pub rounding: f64,
    /// Error of the interpolation half-way, where it is largest.
    pub error: f64,
}

impl Judgement {
    /// The error of the interpolation at x, which goes as `x^3 (1 - x)^3`: value, slope and curvature are met at both ends.
    fn doubt(self, x: f64) -> f64 {
        ERROR_FACTOR * self.error * (4.0 * x * (1.0 - x)).powi(3)
    }
}

/// Where a polynomial is lowest between 0 and 1, and its value there.
fn lowest(c: &[f64]) -> (f64, f64) {
    let (d, size) = derivative::<QUINTIC_SIZE>(c);
    let turning = roots(&d[..size]);
    let places = turning.slice().iter().copied().chain([0.0, 1.0]);
    let values = places.map(|x| (x, value(c, x)));
    values.fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
}

/// A quantity along a step, known at the parts 0, 1/4, 1/2, 3/4 and 1 of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quartic {
    c: [f64; 5],
}

impl Quartic {
    /// The quartic through five values: Newton's divided differences, gathered into powers of x.
    pub fn through(values: [f64; 5]) -> Self {
        let mut differences = values;
        for order in 1..5 {
            for k in (order..5).rev() {
                differences[k] = (differences[k] - differences[k - 1]) * 4.0 / order as f64;
            }
        }
        let mut c = [0.0; 5];
        for k in (0..5).rev() {
            for j in (1..5).rev() {
                c[j] = c[j - 1] - 0.25 * k as f64 * c[j];
            }
            c[0] = differences[k] - 0.25 * k as f64 * c[0];
        }
        Self { c }
    }

    /// The quantity at x.
    pub fn value(&self, x: f64) -> f64 {
        value(&self.c, x)
    }

    /// Where it is lowest, and its value there.
    pub fn lowest(&self) -> (f64, f64) {
        lowest(&self.c)
    }

    /// Where it first falls from above zero to below it; a touch of zero from above is no fall.
    pub fn first_fall(&self) -> Option<f64> {
        let (d, size) = derivative::<QUINTIC_SIZE>(&self.c);
        let slope = |x: f64| value(&d[..size], x);
        roots(&self.c)
            .slice()
            .iter()
            .copied()
            .find(|&x| slope(x) < 0.0)
    }
}

impl Quintic {
    /// The quintic between both ends of a step.
    pub fn new(ends: &EndValues) -> Self {
        let ([p, d, s], [p1, d1, s1]) = (ends.start, ends.end);
        let rise = p1 - p;
        Self {
            c: [
                p,
                d,
                0.5 * s,
                10.0 * rise - 6.0 * d - 4.0 * d1 - 1.5 * s + 0.5 * s1,
                -15.0 * rise + 8.0 * d + 7.0 * d1 + 1.5 * s - s1,
                6.0 * rise - 3.0 * (d + d1) - 0.5 * (s - s1),
            ],
        }
    }

    /// Its coefficients in powers of x.
    pub fn powers(&self) -> &[f64] {
        &self.c
    }

    /// The gap at x.
    pub fn value(&self, x: f64) -> f64 {
        value(&self.c, x)
    }

    /// Where the gap is lowest, and how far below zero it is there.
    pub fn lowest(&self) -> (f64, f64) {
        let (x, gap) = lowest(&self.c);
        (x, -gap)
    }

    /// The first contact, a root of the given order at the start divided out, and the touches before it; undecided at the first
    /// minimum that is nearer to zero than the interpolation is to the motion.
    pub fn first_contact(
        &self,
        order: usize,
        judgement: Judgement,
        touches: &mut Vec<(f64, f64)>,
    ) -> FirstRoot {
        let order = order.min(QUINTIC_SIZE - 1);
        let rounding = judgement.rounding;
        let c = &self.c[order..];
        let (d, size) = derivative::<QUINTIC_SIZE>(c);
        let mut left = 0.0;
        for &right in roots(&d[..size]).slice().iter().chain(&[1.0]) {
            let (before, there) = (value(c, left), value(c, right));
            let gap = (0..order).fold(there, |gap, _| gap * right);
            let is_minimum = right < 1.0 && there < before;
            let doubt = judgement.doubt(right);
            let doubt = (is_minimum && doubt > 0.5 * rounding).then_some(rounding + doubt);
            match Bottom::in_step(gap, rounding, doubt) {
                Bottom::Undecided => return FirstRoot::Undecided { at: right },
                Bottom::Passed => {
                    let at = if before > 0.0 {
                        bracketed_root(c, left, right)
                    } else {
                        left
                    };
                    return FirstRoot::Crossing { at, passed: right };
                }
                Bottom::Touch if is_minimum => touches.push((right, gap)),
                Bottom::Touch | Bottom::Open => {}
            }
            left = right;
        }
        FirstRoot::None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::first_root::FirstRoot;
    use crate::root::polynomial::from_roots;

    #[test]
    fn the_first_fall_of_a_quartic_is_found_and_a_rise_passed_over() {
        for at in [
            vec![0.3],
            vec![0.1, 0.2, 0.7],
            vec![0.6, 0.8],
            vec![-1.0, 0.55, 2.0],
        ] {
            for sign in [1.0, -1.0] {
                let c = from_roots(&at, sign);
                let values = std::array::from_fn(|k| value(&c, 0.25 * k as f64));
                let rises = |x: f64| value(&c, x + 1e-6) > value(&c, x - 1e-6);
                let inside = at.iter().copied().filter(|x| (0.0..1.0).contains(x));
                let wanted = inside.filter(|&x| !rises(x)).fold(f64::INFINITY, f64::min);
                match Quartic::through(values).first_fall() {
                    Some(x) => assert!((x - wanted).abs() < 1e-12, "{at:?} {sign} {x}"),
                    None => assert!(wanted.is_infinite(), "{at:?} {sign}"),
                }
            }
        }
    }

    #[test]
    fn the_quintic_meets_both_ends() {
        let f = |t: f64| {
            [
                (2.0 * t).sin(),
                2.0 * (2.0 * t).cos(),
                -4.0 * (2.0 * t).sin(),
            ]
        };
        let (t, h) = (0.3, 0.2);
        let p = Quintic::new(&EndValues::new(f(t), f(t + h), h, 0));
        let mut worst = 0.0f64;
        for k in 0..=20 {
            let x = f64::from(k) / 20.0;
            worst = worst.max((p.value(x) - f(t + x * h)[0]).abs());
        }
        // h^6 |f^(6)| / (6! 64)
        assert!(worst < 64.0 * h.powi(6) / 720.0 / 64.0 * 1.01, "{worst:e}");
    }

    fn judged(p: &Quintic, order: usize, error: f64) -> (FirstRoot, usize) {
        let mut touches = Vec::new();
        let judgement = Judgement {
            rounding: 1e-15,
            error,
        };
        let along = p.first_contact(order, judgement, &mut touches);
        (along, touches.len())
    }

    #[test]
    fn a_dip_between_positive_ends_is_a_contact_however_shallow() {
        for depth in [1e-3, 1e-8, 1e-13, 0.0, -1e-13, -1e-8] {
            // (x - 0.4)^2 - depth, as a quintic by its ends.
            let f = |x: f64| [(x - 0.4) * (x - 0.4) - depth, 2.0 * (x - 0.4), 2.0];
            let ends = EndValues::new(f(0.0), f(1.0), 1.0, 0);
            let p = Quintic::new(&ends);
            let (along, touches) = judged(&p, 0, 0.0);
            if depth > 0.0 {
                let FirstRoot::Crossing { at: x, passed } = along else {
                    panic!("{depth}: {along:?}")
                };
                let error = 1e-15 / depth.sqrt();
                assert!((x - (0.4 - depth.sqrt())).abs() < error && (passed - 0.4).abs() < 1e-9);
            } else {
                assert_eq!(along, FirstRoot::None);
                assert_eq!(touches, usize::from(depth == 0.0));
            }
            assert!(!ends.are_clear(0, 1e-6), "{depth}");
            // Where the interpolation may be off by more, the motion has to say.
            let (along, _) = judged(&p, 0, 1e-10);
            let is_open = depth.abs() < 1e-9;
            assert_eq!(
                matches!(along, FirstRoot::Undecided { .. }),
                is_open,
                "{depth}"
            );
        }
        let high = EndValues::new([1.0, 0.1, 0.0], [1.2, 0.3, 0.1], 0.5, 0);
        assert!(high.are_clear(0, 0.5));
    }

    #[test]
    fn a_low_flight_behind_an_impact_is_found() {
        for v in [0.3, 1e-3, 1e-8] {
            let f = |t: f64| [v * t - 0.5 * t * t, v - t, -1.0];
            let start = [1e-17, v, -1.0];
            let ends = EndValues::new(start, f(1.0), 1.0, 1);
            assert!(!ends.are_clear(1, 0.0));
            let (FirstRoot::Crossing { at: x, .. }, 0) = judged(&Quintic::new(&ends), 1, 0.0)
            else {
                panic!("{v}")
            };
            assert!((x / (2.0 * v) - 1.0).abs() < 1e-7 + 1e-15 / v, "{x} {v}");
        }
        let rising = EndValues::new([0.0, 1.0, 0.0], [1.0, 1.0, 0.0], 1.0, 1);
        assert!(rising.are_clear(1, 0.0));
        assert_eq!(judged(&Quintic::new(&rising), 1, 0.0), (FirstRoot::None, 0));
    }

    #[test]
    fn a_polynomial_lies_above_its_least_coefficient() {
        for order in 0..4 {
            let m = f64::from(u32::try_from(order).expect("small"));
            // x^m (1 - x/2)^2: clear behind its root.
            let f = |x: f64| {
                let (g, g1, g2) = ((1.0 - 0.5 * x).powi(2), -(1.0 - 0.5 * x), 0.5);
                let power = |k: f64| if k < 0.0 { 0.0 } else { x.powf(k) };
                let (w, w1, w2) = (power(m), m * power(m - 1.0), m * (m - 1.0) * power(m - 2.0));
                [w * g, w1 * g + w * g1, w2 * g + 2.0 * w1 * g1 + w * g2]
            };
            let ends = EndValues::new(f(0.0), f(1.0), 1.0, order);
            assert!(ends.are_clear(order, 0.2), "{order}");
            assert_eq!(ends.are_clear(0, 0.0), order == 0, "{order}");
            for step in 1..=10 {
                let x = f64::from(step) / 10.0;
                assert!((Quintic::new(&ends).value(x) - f(x)[0]).abs() < 1e-14);
            }
        }
    }
}

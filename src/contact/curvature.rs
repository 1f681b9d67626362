//! A nonlinear gap along one step of an integrator, searched with a bound on the gap's second derivative: what is passed
//! over is proved.
//!
//! The motion on the step is the quartic `q(x)`, `0 <= x <= 1`, which is the true one to the tolerance of the step. With
//! `|q'| <= V` and `|q''| <= A` there, the sums of its coefficients, and with a curvature K, `|hess h| <= K`, the gradient is
//! at most `G = |grad h(q(0))| + K V` on the step, and the gap `g(x) = h(q(x))` has
//!
//! `|g''| = |grad h.q'' + q'.(hess h) q'| <= G A + K V^2 =: B`.
//!
//! plus a bound on that of the own motion of the stop, if it moves. So `g(x + s) >= g + g' s - B s^2/2`, which stays above `-margin` up to its root in s: a step that provably holds no
//! contact deeper than the margin. The steps shrink, as Newton's do, towards a place where the stop is crossed.

use crate::error::{Error, Result};
use crate::model::NonlinearStop;
use nalgebra::DVector;

/// Steps of one search, of which a touch within the margin needs some hundreds.
const MOST_STEPS: usize = 1 << 16;
/// The part of the margin below zero at which a gap that goes on falling has crossed: the whole of it is a limit of the steps.
const CROSSED: f64 = 0.9;

/// A gap with bounds on what it is a sum of.
pub(crate) struct BoundedGap<'a> {
    pub stop: &'a NonlinearStop,
    /// K
    pub curvature: f64,
    /// What the own motion of the stop adds at x, and its slope there; `None` of one that rests.
    pub moved: &'a dyn Fn(f64) -> Option<[f64; 2]>,
    /// A bound on the second derivative of that.
    pub bend: f64,
}

impl BoundedGap<'_> {
    /// The gap at x, where the motion is at q, the gradient, and what the own motion of the stop adds to the slope.
    fn at(&self, x: f64, q: &[f64]) -> Result<(f64, DVector<f64>, f64)> {
        let (gap, gradient) = (self.stop.gap(q)?, self.stop.gradient(q)?);
        let [moved, slope] = (self.moved)(x).unwrap_or_default();
        Ok((gap + moved, gradient, slope))
    }
}

/// Where the gap, approaching, has all but reached `-margin` before `until`; `None`: it provably stays above. `path` has
/// the coefficients of each coordinate in powers of x.
///
/// # Errors
/// What the functions of the stop report; `Error::NoConvergence` for a curvature so large that the search does not end.
pub(crate) fn first_crossing(
    of: &BoundedGap<'_>,
    path: &[impl AsRef<[f64]>],
    margin: f64,
    until: f64,
) -> Result<Option<f64>> {
    let size = |of: fn(f64) -> f64| {
        let most = |p: &[f64]| -> f64 {
            let terms = p.iter().enumerate();
            terms.map(|(k, c)| of(k as f64) * c.abs()).sum()
        };
        let squares = path.iter().map(|p| most(p.as_ref()).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let speed = size(|k| k);
    let bend = size(|k| k * (k - 1.0));
    let mut x = 0.0;
    let mut bound = None;
    for _ in 0..MOST_STEPS {
        let q: Vec<f64> = path
            .iter()
            .map(|p| p.as_ref().iter().rev().fold(0.0, |sum, c| sum * x + c))
            .collect();
        let rate = |p: &[f64]| {
            let terms = p.iter().enumerate().skip(1).rev();
            terms.fold(0.0, |sum, (k, c)| sum * x + k as f64 * c)
        };
        let (gap, gradient, own_slope) = of.at(x, &q)?;
        let slopes = gradient.iter().zip(path).map(|(g, p)| g * rate(p.as_ref()));
        let slope = slopes.sum::<f64>() + own_slope;
        if gap < -CROSSED * margin && slope <= 0.0 {
            return Ok(Some(x));
        }
        let bound = *bound.get_or_insert_with(|| {
            let turning = (gradient.norm() + of.curvature * speed) * bend;
            turning + of.curvature * speed * speed + of.bend
        });
        let room = (gap + margin).max(0.0);
        let root = (slope * slope + 2.0 * bound * room).sqrt();
        // Of the two forms of the root the one without cancellation; infinite for a gap that neither falls nor can bend.
        x += if slope > 0.0 {
            (slope + root) / bound
        } else {
            2.0 * room / (root - slope)
        };
        if x >= until {
            return Ok(None);
        }
    }
    Err(Error::NoConvergence {
        stage: "the search for contacts with a nonlinear stop of this curvature",
        iterations: MOST_STEPS,
        residual: until - x,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::GapFunction;

    /// A wall along the first coordinate with a spike at zero of height 1.
    struct Spike {
        width: f64,
    }

    impl GapFunction for Spike {
        fn gap(&self, q: &[f64]) -> Result<f64> {
            Ok(q[1] - (-(q[0] / self.width).powi(2)).exp())
        }
        fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
            let x = q[0] / self.width;
            (gradient[0], gradient[1]) = (2.0 * x / self.width * (-x * x).exp(), 1.0);
            Ok(())
        }
    }

    fn at_rest(stop: &NonlinearStop, curvature: f64) -> BoundedGap<'_> {
        BoundedGap {
            stop,
            curvature,
            moved: &|_| None,
            bend: 0.0,
        }
    }

    fn spike(width: f64) -> (NonlinearStop, f64) {
        let stop = NonlinearStop::new(Spike { width }, 1.0).expect("valid");
        (stop, 2.0 / (width * width))
    }

    /// From -1 to 3 along the first coordinate at the given height.
    fn path(height: f64) -> [[f64; 5]; 2] {
        [[-1.0, 4.0, 0.0, 0.0, 0.0], [height, 0.0, 0.0, 0.0, 0.0]]
    }

    #[test]
    fn a_spike_narrower_than_the_step_is_found_and_one_passed_above_is_not() {
        for width in [1.0, 0.1, 1e-2] {
            let (stop, curvature) = spike(width);
            let low =
                first_crossing(&at_rest(&stop, curvature), &path(0.5), 1e-9, 1.0).expect("ends");
            let exact = 0.25 * (1.0 - width * 2f64.ln().sqrt());
            assert!(
                (low.expect("crossed") - exact).abs() < 1e-8,
                "{low:?} {exact}"
            );
            let high = first_crossing(&at_rest(&stop, curvature), &path(1.0 + 1e-6), 1e-9, 1.0);
            assert_eq!(high.expect("ends"), None);
            let short = first_crossing(&at_rest(&stop, curvature), &path(0.5), 1e-9, 0.9 * exact);
            assert_eq!(short.expect("ends"), None);
        }
    }

    #[test]
    fn a_touch_within_the_margin_is_passed_and_one_beyond_is_not() {
        let (stop, curvature) = spike(0.1);
        let at = |height: f64| first_crossing(&at_rest(&stop, curvature), &path(height), 1e-6, 1.0);
        assert_eq!(at(1.0 - 0.8e-6).expect("ends"), None);
        assert!(at(1.0 - 1.1e-6).expect("ends").is_some());
    }

    #[test]
    fn the_bound_holds_on_a_bent_path() {
        // 1 + q_0 along q_0 = -16 x^2 (1 - x)^2: a dip of depth 1 that touches.
        struct Line;
        impl GapFunction for Line {
            fn gap(&self, q: &[f64]) -> Result<f64> {
                Ok(1.0 + q[0])
            }
            fn gradient(&self, _q: &[f64], gradient: &mut [f64]) -> Result<()> {
                gradient[0] = 1.0;
                Ok(())
            }
        }
        let stop = NonlinearStop::new(Line, 1.0).expect("valid");
        let dip = |depth: f64| [[0.0, 0.0, -16.0 * depth, 32.0 * depth, -16.0 * depth]];
        let at = |depth: f64| {
            first_crossing(&at_rest(&stop, 0.0), &dip(depth), 1e-8, 1.0).expect("ends")
        };
        assert_eq!(at(1.0 - 1e-7), None);
        let x = at(1.0 + 1e-6).expect("crossed");
        assert!(x < 0.5 && x > 0.499, "{x}");
    }
}

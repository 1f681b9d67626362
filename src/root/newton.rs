//! Newton's method inside a bracket.

use crate::root::bracket::Bracket;

/// A function at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NewtonPoint {
    /// Positive before the zero, negative after it.
    pub value: f64,
    pub slope: f64,
    /// A step no longer than this has led to the zero.
    pub resolution: f64,
}

/// The last step of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NewtonStep {
    /// The last place at which the function was evaluated.
    pub from: f64,
    /// The zero.
    pub to: f64,
}

/// The zero of a function that falls through it in a bracket, from a first guess and after no more than `most` values. A step that
/// leaves the bracket is one to its middle instead, and never taken for a converged one.
#[inline]
pub(crate) fn newton<E>(
    mut between: Bracket,
    guess: f64,
    most: usize,
    mut at: impl FnMut(f64) -> Result<NewtonPoint, E>,
) -> Result<NewtonStep, E> {
    let mut step = NewtonStep {
        from: guess,
        to: guess,
    };
    for _ in 0..most {
        let from = step.to;
        let here = at(from)?;
        between.narrow(from, here.value > 0.0);
        let wanted = from - here.value / here.slope;
        let is_newton = between.has(wanted);
        let to = if here.value == 0.0 {
            from
        } else if is_newton {
            wanted
        } else {
            between.middle()
        };
        step = NewtonStep { from, to };
        let is_converged = is_newton && (to - from).abs() <= here.resolution;
        if is_converged || !between.has(to) {
            break;
        }
    }
    Ok(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn zero(ends: [f64; 2], guess: f64, f: impl Fn(f64) -> [f64; 2]) -> NewtonStep {
        let Ok(found) = newton(Bracket::new(ends), guess, 200, |x| {
            let [value, slope] = f(x);
            let resolution = 2.0 * f64::EPSILON * x.abs();
            Ok::<_, Infallible>(NewtonPoint {
                value,
                slope,
                resolution,
            })
        });
        found
    }

    #[test]
    fn zeros_of_known_functions() {
        let root = zero([0.0, 2.0], 1.0, |x| [2.0 - x * x, -2.0 * x]).to;
        assert!((root - 2f64.sqrt()).abs() <= 2.0 * f64::EPSILON);
        // Newton's steps for it lead away from everywhere but near its zero.
        let root = zero([-50.0, 1e3], 900.0, |x| {
            [-(x - 0.3).atan(), -1.0 / (1.0 + (x - 0.3).powi(2))]
        });
        assert!((root.to - 0.3).abs() <= f64::EPSILON);
        // A root of the third order, whose slope is zero there.
        let root = zero([-1.0, 2.0], 0.5, |x| {
            [-(x - 0.7).powi(3), -3.0 * (x - 0.7).powi(2)]
        });
        assert!((root.to - 0.7).abs() < 1e-5);
    }

    #[test]
    fn a_slope_that_tells_nothing_leaves_bisection() {
        for slope in [f64::NAN, 0.0, f64::INFINITY, 1e-300, 3.0] {
            let found = zero([0.0, 1.0], 0.5, |x| {
                [if x < 0.3 { 1.0 } else { -1.0 }, slope]
            });
            if slope.is_finite() {
                assert!((found.to - 0.3).abs() <= f64::EPSILON, "{slope}");
            }
        }
        // A guess that is the zero is found at once.
        let found = zero([0.0, 1.0], 0.25, |x| [0.25 - x, -1.0]);
        assert_eq!((found.from, found.to), (0.25, 0.25));
    }
}

//! The locator: the zero of a test function on a step of a branch or a curve, by the method of false position in its Illinois form. The
//! abscissa is the arclength along the step; how well the zero is known is told by the parameter.

use crate::error::Result;
use crate::tolerance::{ZERO_BRACKET_LENGTH, ZERO_PARAMETER_CHANGE, ZERO_VALUE};

/// Halvings of an interval: down to neighbouring doubles. `[work]`
pub(super) const MOST_BISECTIONS: usize = 60;
/// Evaluations of a search. `[work]`
const MOST_ZERO_TRIALS: usize = 40;
/// Points of a step that Newton's method does not reach, at the most. `[work]`
const MOST_UNREACHED: usize = 12;

/// An evaluation of a test function at a point of a step.
pub(super) struct TestEvaluation<T> {
    pub point: T,
    /// The parameter there.
    pub parameter: f64,
    /// The function there.
    pub value: f64,
}

/// The point nearest to a zero, and its arclength on the step.
pub(super) struct LocatedZero<T> {
    pub point: T,
    pub along: f64,
    /// The error of the parameter, in the unit of its span.
    pub error: f64,
}

/// The zero of a test function on a step, given by its length and the values at both ends; `span` is the range of the parameter, and
/// `point` evaluates the function at an arclength, or says that no point is reached there. None if no point at all is reached.
pub(super) fn locate_zero<T>(
    [length, at_start, at_end]: [f64; 3],
    span: f64,
    point: &mut dyn FnMut(f64) -> Result<Option<TestEvaluation<T>>>,
) -> Result<Option<LocatedZero<T>>> {
    let (mut low, mut high) = ((0.0, at_start), (length, at_end));
    let mut found: Option<(LocatedZero<T>, f64)> = None;
    let mut side = 0;
    let (mut misses, mut beside) = (0, None);
    for _ in 0..MOST_ZERO_TRIALS {
        let wanted = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let inside = if wanted > low.0 && wanted < high.0 {
            wanted
        } else {
            0.5 * (low.0 + high.0)
        };
        let along = beside.take().unwrap_or(inside);
        let Some(TestEvaluation {
            point,
            parameter,
            value,
        }) = point(along)?
        else {
            // Next to a branch point no point is reached: the zero is only bracketed from both sides.
            misses += 1;
            let from = if misses % 2 == 1 { low.0 } else { high.0 };
            beside = Some(0.5 * (from + along));
            if misses < MOST_UNREACHED {
                continue;
            }
            break;
        };
        let change = found
            .as_ref()
            .map_or(f64::INFINITY, |(_, before)| (before - parameter).abs());
        let is_small = value.abs() <= ZERO_VALUE * at_start.abs().max(at_end.abs());
        let is_over =
            is_small && change <= ZERO_PARAMETER_CHANGE * span && high.0 - low.0 < 0.5 * length
                || high.0 - low.0 <= ZERO_BRACKET_LENGTH * length
                || value == 0.0;
        let error = if value == 0.0 {
            0.0
        } else {
            change.min(length * span)
        };
        let zero = LocatedZero {
            point,
            along,
            error,
        };
        found = Some((zero, parameter));
        if is_over {
            break;
        }
        if (value > 0.0) == (low.1 > 0.0) {
            low = (along, value);
            if side == -1 {
                high.1 *= 0.5;
            }
            side = -1;
        } else {
            high = (along, value);
            if side == 1 {
                low.1 *= 0.5;
            }
            side = 1;
        }
    }
    let width = (high.0 - low.0) * span;
    Ok(found.map(|(zero, _)| LocatedZero {
        error: if misses > 0 { width } else { zero.error },
        ..zero
    }))
}

//! The locator: where a test function is zero on a step of a curve, by false position; or where a property changes, by bisection. The
//! abscissa is the arclength along the step; how well a zero is known is told by a parameter.

use crate::continuation::corrector::CorrectedOf;
use crate::continuation::predictor::{BaseOf, stepped};
use crate::continuation::zero_problem::ZeroProblem;
use crate::error::Result;
use crate::root::{Bracket, FalsePosition};
use crate::tolerance::{ZERO_BRACKET_LENGTH, ZERO_PARAMETER_CHANGE, ZERO_VALUE};

/// Halvings of an interval: down to neighbouring doubles. `[work]`
const MOST_BISECTIONS: usize = 60;
/// Evaluations of a search. `[work]`
const MOST_ZERO_TRIALS: usize = 40;
/// Points of a step that Newton's method does not reach, at the most. `[work]`
const MOST_UNREACHED: usize = 12;

/// An evaluation of a test function at a point of a step.
pub(crate) struct TestEvaluation<T> {
    pub point: T,
    /// The parameter there.
    pub parameter: f64,
    /// The function there.
    pub value: f64,
}

/// The point nearest to a zero, and its arclength on the step.
pub(crate) struct LocatedZero<T> {
    pub point: T,
    pub along: f64,
    /// The error of the parameter, in the unit of its span.
    pub error: f64,
}

/// The zero of a test function on a step, given by its length and the values at both ends; `span` is the range of the parameter, and
/// `point` evaluates the function at an arclength, or says that no point is reached there. None if no point at all is reached.
pub(crate) fn locate_zero<T>(
    [length, at_start, at_end]: [f64; 3],
    span: f64,
    point: &mut dyn FnMut(f64) -> Result<Option<TestEvaluation<T>>>,
) -> Result<Option<LocatedZero<T>>> {
    let mut search = FalsePosition::new([0.0, length], [at_start, at_end]);
    let mut found: Option<(LocatedZero<T>, f64)> = None;
    let (mut misses, mut beside) = (0, None);
    for _ in 0..MOST_ZERO_TRIALS {
        let Bracket { before, after } = search.between;
        let inside = search.trial();
        let along = beside.take().unwrap_or(inside);
        let Some(TestEvaluation {
            point,
            parameter,
            value,
        }) = point(along)?
        else {
            // Next to a branch point no point is reached: the zero is only bracketed from both sides.
            misses += 1;
            let from = if misses % 2 == 1 { before } else { after };
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
            is_small && change <= ZERO_PARAMETER_CHANGE * span && after - before < 0.5 * length
                || after - before <= ZERO_BRACKET_LENGTH * length
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
        search.narrow(along, value);
    }
    let width = search.between.length() * span;
    Ok(found.map(|(zero, _)| LocatedZero {
        error: if misses > 0 { width } else { zero.error },
        ..zero
    }))
}

/// A test function at an arclength of a step from a point; `of` gives a parameter and the value. None where the corrector fails, or the
/// function has no value.
pub(crate) fn evaluated<P: ZeroProblem>(
    problem: &P,
    base: BaseOf<'_, P>,
    along: f64,
    of: impl FnOnce(&CorrectedOf<P>) -> Result<Option<(f64, f64)>>,
) -> Result<Option<TestEvaluation<CorrectedOf<P>>>> {
    let Ok(point) = stepped(problem, base, along)? else {
        return Ok(None);
    };
    Ok(of(&point)?.map(|(parameter, value)| TestEvaluation {
        point,
        parameter,
        value,
    }))
}

/// The part of a step on which a property changes.
pub(crate) struct ChangeBracket<T> {
    /// Its ends, in arclength.
    pub ends: [f64; 2],
    /// The point at each end, where that is not an end of the step.
    pub points: [Option<T>; 2],
    /// Whether all points were found that were looked for.
    pub is_reached: bool,
}

/// Where a property changes on a step of some length, to a shortest length. `aim` gives the next trial, `at` a point and whether the
/// property there is that of the beginning; where there is no point, the search ends.
pub(crate) fn locate_change<T>(
    length: f64,
    shortest: f64,
    aim: &mut dyn FnMut(&ChangeBracket<T>) -> Result<f64>,
    at: &mut dyn FnMut(f64) -> Result<Option<(T, bool)>>,
) -> Result<ChangeBracket<T>> {
    let mut bracket = ChangeBracket {
        ends: [0.0, length],
        points: [None, None],
        is_reached: true,
    };
    for _ in 0..MOST_BISECTIONS {
        if bracket.ends[1] - bracket.ends[0] <= shortest {
            break;
        }
        let along = aim(&bracket)?;
        let Some((point, is_before)) = at(along)? else {
            bracket.is_reached = false;
            break;
        };
        let side = usize::from(!is_before);
        bracket.ends[side] = along;
        bracket.points[side] = Some(point);
    }
    Ok(bracket)
}

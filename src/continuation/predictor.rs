//! A step along a curve of zeros: the predictor along the tangent, then the corrector (theory 19).

use crate::continuation::corrector::{CorrectedOf, corrected};
use crate::continuation::failure::{Attempt, attempted};
use crate::continuation::zero_problem::{ScaledDirection, ZeroProblem};
use nalgebra::DVector;

/// The point that a step begins from: its iterate, the equations there, and the tangent of the curve.
pub(crate) type BaseOf<'a, P> = (
    &'a <P as ZeroProblem>::Iterate,
    &'a <P as ZeroProblem>::Equations,
    &'a <P as ZeroProblem>::Direction,
);

/// A step by an arclength along the tangent \[-\], corrected on the plane at right angles to it.
pub(crate) fn stepped<P: ZeroProblem>(
    problem: &P,
    (iterate, equations, tangent): BaseOf<'_, P>,
    length: f64,
) -> Attempt<CorrectedOf<P>> {
    let predicted = problem.retract(iterate, equations, &tangent.scaled(length));
    match attempted(predicted, problem.value(iterate))? {
        Ok(predicted) => corrected(problem, predicted, tangent),
        Err(failure) => Ok(Err(failure)),
    }
}

/// A step to where a number has a value, which is an arclength ahead along the tangent.
pub(crate) fn stepped_to<P: ZeroProblem>(
    problem: &P,
    (iterate, equations, tangent): BaseOf<'_, P>,
    length: f64,
    (number, value): (usize, f64),
) -> Attempt<CorrectedOf<P>> {
    let mut normal = DVector::zeros(tangent.row().len());
    let column = normal.len() - P::N_NUMBERS + number;
    normal[column] = 1.0;
    let predicted = problem.retract(iterate, equations, &tangent.scaled(length));
    let predicted = predicted.and_then(|there| problem.pin(there, number, value));
    let predicted = match attempted(predicted, problem.value(iterate))? {
        Ok(predicted) => predicted,
        Err(failure) => return Ok(Err(failure)),
    };
    let mut found = corrected(problem, predicted, &P::Direction::of(&normal))?;
    // Corrections leave the number at its value but for rounding.
    if let Ok(found) = &mut found {
        found.iterate = problem.pin(found.iterate.clone(), number, value)?;
    }
    Ok(found)
}

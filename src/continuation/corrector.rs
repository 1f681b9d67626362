//! The corrector: Newton's method from a predicted iterate back to the curve of zeros; and the tangent of the curve there (theory 19).

use crate::continuation::failure::{Attempt, StepFailure, attempted};
use crate::continuation::zero_problem::{Linearisation, ScaledDirection, ZeroProblem};
use crate::tolerance::{
    CORRECTION_NO_SHORTER, LAST_CORRECTION_LENGTH, ORBIT_CLOSED, ROUNDED_CORRECTION, SHARP_MISMATCH,
};
use nalgebra::{DMatrix, DVector};

/// A point of a curve of zeros as the corrector leaves it.
#[derive(Clone)]
pub(crate) struct Corrected<I, E, D> {
    pub iterate: I,
    pub equations: E,
    /// The tangent of the curve, of length one.
    pub tangent: D,
    /// The ratio of the second correction to the first \[-\]; zero if there was no second one.
    pub contraction: f64,
}

impl<I, E, D> Corrected<I, E, D> {
    /// The point as the base of a step.
    pub fn base(&self) -> (&I, &E, &D) {
        (&self.iterate, &self.equations, &self.tangent)
    }
}

/// A corrected point of a problem.
pub(crate) type CorrectedOf<P> = Corrected<
    <P as ZeroProblem>::Iterate,
    <P as ZeroProblem>::Equations,
    <P as ZeroProblem>::Direction,
>;

/// An iterate that solves the equations, these, and the correction that remains.
struct SolvingIterate<P: ZeroProblem> {
    iterate: P::Iterate,
    equations: P::Equations,
    left: Option<P::Direction>,
}

/// The Jacobian bordered by one more row, that of a direction.
pub(crate) fn bordered(
    equations: &impl Linearisation,
    border: &impl ScaledDirection,
) -> DMatrix<f64> {
    let matrix = equations.matrix();
    let last = matrix.nrows();
    let mut matrix = matrix.insert_row(last, 0.0);
    matrix.set_row(last, &border.row().transpose());
    matrix
}

/// The solution of the equations bordered by one more row.
fn solved<D: ScaledDirection>(
    equations: &impl Linearisation,
    border: &D,
    right: &DVector<f64>,
) -> Option<D> {
    let matrix = bordered(equations, border);
    // Stops that are hit at one instant give one equation too many.
    if !matrix.is_square() {
        return None;
    }
    let found = matrix.lu().solve(right)?;
    found.iter().all(|x| x.is_finite()).then(|| D::of(&found))
}

/// The tangent of the curve, on the side of a direction.
pub(crate) fn tangent<D: ScaledDirection>(equations: &impl Linearisation, border: &D) -> Option<D> {
    let count = equations.right().len();
    let mut right = DVector::zeros(count + 1);
    right[count] = 1.0;
    let found = solved(equations, border, &right)?;
    let length = found.length();
    (length.is_finite() && length > 0.0).then(|| found.unit())
}

/// Whether an iterate with some mismatch solves the equations sharply with the remaining correction, or corrections come no nearer, by the
/// last two.
fn is_sharp(mismatch: f64, [last, left]: [f64; 2]) -> bool {
    let shorter = (left / last).min(1.0);
    mismatch * shorter <= SHARP_MISMATCH || shorter > CORRECTION_NO_SHORTER
}

/// The point of the curve near a predicted iterate, on the plane through that with a given normal: the tangent for a step of
/// pseudo-arclength, the direction of a number for a point at a given value. Expensive derivatives are taken at the first iterate and at
/// the last.
pub(crate) fn corrected<P: ZeroProblem>(
    problem: &P,
    mut iterate: P::Iterate,
    normal: &P::Direction,
) -> Attempt<CorrectedOf<P>> {
    let mut total = P::Direction::of(&DVector::zeros(normal.row().len()));
    let (mut last, mut first) = (f64::INFINITY, None);
    let (mut contraction, mut mismatch) = (0.0, f64::INFINITY);
    let mut value = problem.value(&iterate);
    let mut near: Option<P::Equations> = None;
    // The last iterate that solves the equations: it is the result where another correction fails.
    let mut kept: Option<SolvingIterate<P>> = None;
    let mut failure = None;
    for corrections in 0..=P::MOST_CORRECTIONS {
        let is_last = corrections == P::MOST_CORRECTIONS;
        value = problem.value(&iterate);
        if let Some(instant) = problem.coinciding(&iterate) {
            failure = Some(StepFailure::Met { value, instant });
            break;
        }
        let equations = problem.linearise(&iterate, near.as_ref());
        let equations = match attempted(equations, value)? {
            Ok(equations) => equations,
            Err(own) => {
                failure = Some(own);
                break;
            }
        };
        mismatch = equations.mismatch();
        let right = equations.right().clone().push(-normal.dot(&total));
        let Some(by) = solved(&equations, normal, &right) else {
            break;
        };
        let left = by.length();
        match first {
            None => first = Some(left),
            Some(first) if contraction == 0.0 && first > ROUNDED_CORRECTION => {
                contraction = left / first;
            }
            Some(_) => {}
        }
        let is_solved = mismatch <= ORBIT_CLOSED;
        let is_there = is_solved && left <= LAST_CORRECTION_LENGTH;
        if is_there && (is_last || is_sharp(mismatch, [last, left])) {
            let own = SolvingIterate {
                iterate,
                equations,
                left: Some(by),
            };
            return settled(problem, own, (normal, contraction), failure);
        }
        // Where curves cross, corrections come no nearer than this: the iterate is kept.
        if let Some(longest) = P::KEPT_CORRECTION
            && (is_there || is_last && is_solved && last <= longest)
        {
            kept = Some(SolvingIterate {
                iterate: iterate.clone(),
                equations: equations.clone(),
                left: is_there.then(|| by.clone()),
            });
        }
        last = left;
        total = total.plus(&by);
        iterate = match attempted(problem.retract(&iterate, &equations, &by), value)? {
            Ok(iterate) => iterate,
            Err(own) => {
                failure = Some(own);
                break;
            }
        };
        near.get_or_insert(equations);
    }
    match kept {
        Some(kept) => settled(problem, kept, (normal, contraction), failure),
        None => Ok(Err(
            failure.unwrap_or_else(|| StepFailure::stalled(value, mismatch))
        )),
    }
}

/// The point after the remaining correction; a failure, the given one if there is one, where the equations have no tangent.
fn settled<P: ZeroProblem>(
    problem: &P,
    own: SolvingIterate<P>,
    (normal, contraction): (&P::Direction, f64),
    failure: Option<StepFailure>,
) -> Attempt<CorrectedOf<P>> {
    let (value, mismatch) = (problem.value(&own.iterate), own.equations.mismatch());
    let there = problem.settle(own.iterate, own.equations, own.left.as_ref());
    let (iterate, equations) = match attempted(there, value)? {
        Ok(there) => there,
        Err(own) => return Ok(Err(own)),
    };
    if let Some(instant) = problem.coinciding(&iterate) {
        return Ok(Err(StepFailure::Met { value, instant }));
    }
    Ok(match tangent(&equations, normal) {
        Some(tangent) => Ok(Corrected {
            iterate,
            equations,
            tangent,
            contraction,
        }),
        None => Err(failure.unwrap_or_else(|| StepFailure::stalled(value, mismatch))),
    })
}

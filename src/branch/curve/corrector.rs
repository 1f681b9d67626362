//! The corrector of a curve: Newton's method from a predicted loop back to it; and its tangent there (theory 20).

use crate::branch::corrector::{
    Attempt, CorrectionFailure, attempted, coinciding_instant, is_sharp,
};
use crate::branch::curve::problem::{CurveProblem, DefiningSystem, TwoParameterLoop};
use crate::tolerance::{LAST_CORRECTION_LENGTH, ORBIT_CLOSED, ROUNDED_CORRECTION};
use nalgebra::{DMatrix, DVector};

/// Corrections of one point of a curve: more than on a branch, as the row of the condition stays that of the first iterate. `[work]`
const MOST_CURVE_CORRECTIONS: usize = 10;

/// A point of a curve as the corrector leaves it.
#[derive(Clone)]
pub(super) struct CorrectedCurvePoint {
    pub iterate: TwoParameterLoop,
    pub conditions: DefiningSystem,
    /// The tangent of the curve, of length one in the product of [`weighted`], shape `(n_unknowns + 2,)`, \[-\], in scaled unknowns and
    /// both numbers in parts of their ranges.
    pub tangent: DVector<f64>,
    /// The ratio of the second correction to the first \[-\]; zero if there was no second one.
    pub contraction: f64,
}

/// The row whose product with a direction is the inner product: the mean over the unknowns of the loop, plus that of both numbers.
pub(super) fn weighted(direction: &DVector<f64>) -> DVector<f64> {
    let count = direction.len() - 2;
    let mut row = direction.clone();
    row.rows_mut(0, count).unscale_mut(count as f64);
    row
}

/// The length of a direction \[-\].
pub(super) fn length(direction: &DVector<f64>) -> f64 {
    weighted(direction).dot(direction).sqrt()
}

/// The matrix of the equations bordered by one more row.
fn bordered(at: &DefiningSystem, border: &DVector<f64>) -> DMatrix<f64> {
    let last = at.matrix.nrows();
    let mut matrix = at.matrix.clone().insert_row(last, 0.0);
    matrix.set_row(last, &border.transpose());
    matrix
}

/// The tangent of the curve, on the side of a row.
fn tangent(at: &DefiningSystem, border: &DVector<f64>) -> Option<DVector<f64>> {
    let mut right = DVector::zeros(border.len());
    right[border.len() - 1] = 1.0;
    let found = bordered(at, border).lu().solve(&right)?;
    let size = length(&found);
    (size.is_finite() && size > 0.0).then(|| found / size)
}

impl CurveProblem<'_> {
    /// The point of the curve near a predicted loop, on the plane through that with a given normal row. Derivatives by both numbers, and
    /// those of the condition, are taken at the first iterate and at the last.
    pub fn corrected(
        &self,
        mut iterate: TwoParameterLoop,
        normal: &DVector<f64>,
    ) -> Attempt<CorrectedCurvePoint> {
        let value = |iterate: &TwoParameterLoop| iterate.place.value;
        let mut total: DVector<f64> = DVector::zeros(normal.len());
        let (mut first, mut near): (_, Option<DefiningSystem>) = (None, None);
        let mut contraction = 0.0;
        let mut last = f64::INFINITY;
        if let Some(instant) = coinciding_instant(&iterate.place) {
            let value = value(&iterate);
            return Ok(Err(CorrectionFailure::Met { value, instant }));
        }
        for corrections in 0..=MOST_CURVE_CORRECTIONS {
            let is_last = corrections == MOST_CURVE_CORRECTIONS;
            let conditions = match &near {
                Some(near) => self.conditions_nearby(&iterate, near),
                None => self.conditions(&iterate),
            };
            let conditions = match attempted(conditions, value(&iterate))? {
                Ok(conditions) => conditions,
                Err(failure) => return Ok(Err(failure)),
            };
            let right = conditions.right.clone().push(-normal.dot(&total));
            let solved = bordered(&conditions, normal).lu().solve(&right);
            let Some(by) = solved.filter(|by| by.iter().all(|x| x.is_finite())) else {
                break;
            };
            let left = length(&by);
            match first {
                None => first = Some(left),
                Some(first) if contraction == 0.0 && first > ROUNDED_CORRECTION => {
                    contraction = left / first;
                }
                Some(_) => {}
            }
            let mismatch = conditions.mismatch;
            let is_sharp = is_last || is_sharp(mismatch, [last, left]);
            let is_there = mismatch <= ORBIT_CLOSED && left <= LAST_CORRECTION_LENGTH && is_sharp;
            last = left;
            let conditions = if is_there {
                self.renewed(&iterate, conditions)
            } else {
                Ok(conditions)
            };
            let moved = conditions.and_then(|own| Ok((self.moved(&iterate, &own, &by)?, own)));
            let conditions;
            (iterate, conditions) = match attempted(moved, value(&iterate))? {
                Ok(moved) => moved,
                Err(failure) => return Ok(Err(failure)),
            };
            total += &by;
            if let Some(instant) = coinciding_instant(&iterate.place) {
                let value = value(&iterate);
                return Ok(Err(CorrectionFailure::Met { value, instant }));
            }
            if is_there {
                let Some(tangent) = tangent(&conditions, normal) else {
                    break;
                };
                let conditions = self.conditions_at(&iterate, conditions)?;
                return Ok(Ok(CorrectedCurvePoint {
                    iterate,
                    conditions,
                    tangent,
                    contraction,
                }));
            }
            near.get_or_insert(conditions);
        }
        Ok(Err(CorrectionFailure::Stalled {
            value: value(&iterate),
            reason: "Newton's method does not settle".to_owned(),
        }))
    }
}

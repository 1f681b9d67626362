//! Newton's method back to a curve, and the direction in which it goes on.

use crate::branch::corrector::{Attempt, Missed, attempted, is_sharp, met};
use crate::branch::curve::plane::{Conditions, Plane, Spot};
use crate::tolerance::ORBIT_CLOSED;
use nalgebra::{DMatrix, DVector};

/// Corrections of one point, and the length of the last, after which the conditions are those before it.
const MOST_CORRECTIONS: usize = 10;
const SETTLED: f64 = 1e-10;

/// A point of a curve.
#[derive(Clone)]
pub(super) struct Found {
    pub spot: Spot,
    pub conditions: Conditions,
    /// Along the curve, of length one in the product of [`weighted`].
    pub tangent: DVector<f64>,
    /// How much shorter the second correction was than the first.
    pub contraction: f64,
}

/// A row that is the product of directions: the mean over the unknowns of the loop, and both numbers.
pub(super) fn weighted(direction: &DVector<f64>) -> DVector<f64> {
    let count = direction.len() - 2;
    let mut row = direction.clone();
    row.rows_mut(0, count).unscale_mut(count as f64);
    row
}

/// The length of a direction.
pub(super) fn length(direction: &DVector<f64>) -> f64 {
    weighted(direction).dot(direction).sqrt()
}

/// The matrix of the conditions beside one more row.
fn bordered(at: &Conditions, border: &DVector<f64>) -> DMatrix<f64> {
    let last = at.matrix.nrows();
    let mut matrix = at.matrix.clone().insert_row(last, 0.0);
    matrix.set_row(last, &border.transpose());
    matrix
}

/// The direction of the curve, on the side of a row.
fn tangent(at: &Conditions, border: &DVector<f64>) -> Option<DVector<f64>> {
    let mut right = DVector::zeros(border.len());
    right[border.len() - 1] = 1.0;
    let found = bordered(at, border).lu().solve(&right)?;
    let size = length(&found);
    (size.is_finite() && size > 0.0).then(|| found / size)
}

impl Plane<'_> {
    /// The point of the curve near a spot on the plane through it that a row is normal to. What changes with both numbers, and the condition
    /// with all unknowns, is taken where the way begins and where it ends.
    pub fn corrected(&self, mut spot: Spot, normal: &DVector<f64>) -> Attempt<Found> {
        let value = |spot: &Spot| spot.place.value;
        let mut gone: DVector<f64> = DVector::zeros(normal.len());
        let (mut first, mut near): (_, Option<Conditions>) = (None, None);
        let mut contraction = 0.0;
        let mut last = f64::INFINITY;
        if let Some(instant) = met(&spot.place) {
            let value = value(&spot);
            return Ok(Err(Missed::Met { value, instant }));
        }
        for corrections in 0..=MOST_CORRECTIONS {
            let is_last = corrections == MOST_CORRECTIONS;
            let conditions = match &near {
                Some(near) => self.conditions_nearby(&spot, near),
                None => self.conditions(&spot),
            };
            let conditions = match attempted(conditions, value(&spot))? {
                Ok(conditions) => conditions,
                Err(missed) => return Ok(Err(missed)),
            };
            let right = conditions.right.clone().push(-normal.dot(&gone));
            let solved = bordered(&conditions, normal).lu().solve(&right);
            let Some(by) = solved.filter(|by| by.iter().all(|x| x.is_finite())) else {
                break;
            };
            let left = length(&by);
            match first {
                None => first = Some(left),
                Some(first) if contraction == 0.0 && first > 1e-8 => contraction = left / first,
                Some(_) => {}
            }
            let mismatch = conditions.mismatch;
            let is_sharp = is_last || is_sharp(mismatch, [last, left]);
            let is_there = mismatch <= ORBIT_CLOSED && left <= SETTLED && is_sharp;
            last = left;
            let conditions = if is_there {
                self.renewed(&spot, conditions)
            } else {
                Ok(conditions)
            };
            let moved = conditions.and_then(|own| Ok((self.moved(&spot, &own, &by)?, own)));
            let conditions;
            (spot, conditions) = match attempted(moved, value(&spot))? {
                Ok(moved) => moved,
                Err(missed) => return Ok(Err(missed)),
            };
            gone += &by;
            if let Some(instant) = met(&spot.place) {
                let value = value(&spot);
                return Ok(Err(Missed::Met { value, instant }));
            }
            if is_there {
                let Some(tangent) = tangent(&conditions, normal) else {
                    break;
                };
                let conditions = self.conditions_at(&spot, conditions)?;
                return Ok(Ok(Found {
                    spot,
                    conditions,
                    tangent,
                    contraction,
                }));
            }
            near.get_or_insert(conditions);
        }
        Ok(Err(Missed::Stalled {
            value: value(&spot),
            reason: "Newton's method does not settle".to_owned(),
        }))
    }
}

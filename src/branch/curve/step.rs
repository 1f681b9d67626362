//! A step along a curve.

use crate::branch::corrector::{Attempt, attempted};
use crate::branch::curve::corrector::Found;
use crate::branch::curve::plane::{Plane, Spot};
use nalgebra::DVector;

/// A step along a curve.
pub(super) fn stepped(
    plane: &Plane<'_>,
    from: &Found,
    tangent: &DVector<f64>,
    ahead: f64,
    normal: &DVector<f64>,
) -> Attempt<Found> {
    let moved = plane.moved(&from.spot, &from.conditions, &(tangent * ahead));
    let spot = match attempted(moved, from.spot.place.value)? {
        Ok(spot) => spot,
        Err(missed) => return Ok(Err(missed)),
    };
    plane.corrected(spot, normal)
}

/// The way from a spot to another in scaled unknowns.
pub(super) fn chord(plane: &Plane<'_>, from: &Spot, to: &Spot) -> DVector<f64> {
    let place = plane.along(0, from, |family| Ok(family.between(&from.place, &to.place)));
    let second = (to.second - from.second) / plane.span(1);
    place.map_or_else(|_| DVector::zeros(0), |own| own.numbers().push(second))
}

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

/// A step, no longer than some length, to where a number has a value.
pub(super) fn stepped_to(
    plane: &Plane<'_>,
    from: &Found,
    tangent: &DVector<f64>,
    step: f64,
    (axis, end): (usize, f64),
) -> Attempt<Found> {
    let at = [from.spot.place.value, from.spot.second][axis];
    let column = tangent.len() - 2 + axis;
    let ahead = (end - at) / (tangent[column] * plane.span(axis));
    let ahead = if ahead.is_finite() {
        ahead.clamp(0.0, step)
    } else {
        step
    };
    let mut row = DVector::zeros(tangent.len());
    row[column] = 1.0;
    let moved = plane.moved(&from.spot, &from.conditions, &(tangent * ahead));
    let there = moved.and_then(|spot| plane.at_value(&spot, axis, end));
    let spot = match attempted(there, from.spot.place.value)? {
        Ok(spot) => spot,
        Err(missed) => return Ok(Err(missed)),
    };
    let found = plane.corrected(spot, &row)?;
    let Ok(there) = found else {
        return Ok(found);
    };
    // But for the rounding of corrections.
    let spot = plane.at_value(&there.spot, axis, end)?;
    Ok(Ok(Found { spot, ..there }))
}

/// A spot so many turns of the forcing later as another is, to the nearest.
pub(super) fn turned_to(plane: &Plane<'_>, spot: &Spot, other: &Spot) -> Spot {
    let place = plane.along(0, spot, |family| {
        let turns = family.turns(&spot.place, &other.place);
        Ok(spot.place.turned(turns))
    });
    Spot {
        place: place.unwrap_or_else(|_| spot.place.clone()),
        second: spot.second,
    }
}

/// The way from a spot to another in scaled unknowns.
pub(super) fn chord(plane: &Plane<'_>, from: &Spot, to: &Spot) -> DVector<f64> {
    let place = plane.along(0, from, |family| Ok(family.between(&from.place, &to.place)));
    let second = (to.second - from.second) / plane.span(1);
    place.map_or_else(|_| DVector::zeros(0), |own| own.numbers().push(second))
}

//! A step along a branch from a point that is known.

use crate::branch::corrector::{Attempt, Settled, attempted};
use crate::branch::equations::Equations;
use crate::branch::family::Family;
use crate::branch::place::{Direction, Place};
use crate::orbit::PeriodicOrbit;

/// A point that was accepted.
#[derive(Clone)]
pub(super) struct Point {
    pub place: Place,
    pub equations: Equations,
    pub tangent: Direction,
    pub orbit: PeriodicOrbit,
    /// From the beginning of the way.
    pub arclength: f64,
    /// A number whose sign changes where a multiplier passes through -1.
    pub doubling: f64,
}

/// Where a step is to lead.
#[derive(Clone, Copy)]
pub(super) enum Target {
    /// So far along the tangent.
    Length(f64),
    /// To a value of the parameter.
    Value(f64),
}

/// A step from a point.
pub(super) fn step_to(family: &Family<'_>, from: &Point, target: Target) -> Attempt<Settled> {
    let unknowns = from.tangent.loop_part.len();
    let (length, normal) = match target {
        Target::Length(length) => (length, from.tangent.clone()),
        Target::Value(value) => {
            let ahead = (value - from.place.value) / family.span();
            (
                ahead / from.tangent.value_part,
                Direction::of_value(unknowns),
            )
        }
    };
    let ahead = from.tangent.scaled(length);
    let moved = family.moved(&from.place, &from.equations, &ahead);
    let mut place = match attempted(moved, from.place.value)? {
        Ok(place) => place,
        Err(missed) => return Ok(Err(missed)),
    };
    if let Target::Value(value) = target {
        place.value = value;
    }
    let mut found = family.corrected(place, &normal)?;
    if let (Ok(settled), Target::Value(value)) = (&mut found, target) {
        settled.place.value = value;
    }
    Ok(found)
}

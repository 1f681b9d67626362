//! A step along a branch from a point that is known.

use crate::branch::corrector::{Attempt, Settled, attempted};
use crate::branch::equations::{Equations, Foot};
use crate::branch::family::Family;
use crate::branch::indicators::Indicators;
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
    pub indicators: Indicators,
}

/// Where a step is to lead.
#[derive(Clone, Copy)]
pub(super) enum Target {
    /// So far along the tangent.
    Length(f64),
    /// To a value of the parameter.
    Value(f64),
}

impl Point {
    /// A step from it.
    pub fn foot(&self) -> Foot<'_> {
        (&self.place, &self.equations, &self.tangent)
    }
}

/// A step along a branch.
pub(super) fn step_to(
    family: &Family<'_>,
    (place, equations, tangent): Foot<'_>,
    target: Target,
) -> Attempt<Settled> {
    let (length, normal) = match target {
        Target::Length(length) => (length, tangent.clone()),
        Target::Value(value) => {
            let ahead = (value - place.value) / family.span();
            let by_value = Direction::of_value(tangent.loop_part.len());
            (ahead / tangent.value_part, by_value)
        }
    };
    let moved = family.moved(place, equations, &tangent.scaled(length));
    let mut moved = match attempted(moved, place.value)? {
        Ok(place) => place,
        Err(missed) => return Ok(Err(missed)),
    };
    if let Target::Value(value) = target {
        moved.value = value;
    }
    let mut found = family.corrected(moved, &normal)?;
    if let (Ok(settled), Target::Value(value)) = (&mut found, target) {
        settled.place.value = value;
    }
    Ok(found)
}

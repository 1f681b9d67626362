//! An orbit followed from one set of numbers of its scene to another.

use crate::branch::{ContinuationOptions, EndReason, Heading, Virtual, continuation_of};
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{PeriodicOrbit, find_orbit};
use crate::tolerance::{FOLLOWING_HALVINGS, TRACKED_PHASE_SHIFT, TRACKED_SPEED_CHANGE};
use std::f64::consts::{PI, TAU};

/// An orbit of the scene of some numbers, followed along a straight way to that of others: at once by Newton's method, by halves of the
/// way where that fails or comes to an orbit far off, at last by continuation.
///
/// # Errors
/// `Error::NoConvergence` where the orbit does not reach the end of the way; what `make` says; `Error::Interrupted` when the observer breaks
/// off.
pub fn follow_orbit(
    orbit: &PeriodicOrbit,
    make: &dyn Fn(&[f64]) -> Result<Scene>,
    (from, to): (&[f64], &[f64]),
) -> Result<PeriodicOrbit> {
    let at = |part: f64| {
        if part == 1.0 {
            return make(to);
        }
        let between = from.iter().zip(to).map(|(a, b)| a + part * (b - a));
        make(&between.collect::<Vec<f64>>())
    };
    let by_newton = by_halves(orbit, &at, [0.0, 1.0], FOLLOWING_HALVINGS);
    let Err(failed @ Error::NoConvergence { .. }) = by_newton else {
        return by_newton;
    };
    let options = ContinuationOptions {
        heading: Heading::Up,
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    };
    let branch = continuation_of(orbit, &at, 0.0, (0.0, 1.0), &options)?;
    let has_arrived =
        branch.ends[1].reason == EndReason::Range && branch.parameter.last() == Some(&1.0);
    match branch.orbits.into_iter().next_back() {
        Some(last) if has_arrived => Ok(last),
        _ => Err(failed),
    }
}

fn by_halves(
    orbit: &PeriodicOrbit,
    at: &dyn Fn(f64) -> Result<Scene>,
    [from, to]: [f64; 2],
    halvings: usize,
) -> Result<PeriodicOrbit> {
    let found = find_orbit(&at(to)?, orbit, None);
    match found {
        Ok(found) if is_near(orbit, &found) => return Ok(found),
        Ok(_) if halvings == 0 => return Err(another_orbit()),
        Ok(_) => {}
        Err(Error::NoConvergence { .. }) if halvings > 0 => {}
        Err(error) => return Err(error),
    }
    let middle = 0.5 * (from + to);
    let half = by_halves(orbit, at, [from, middle], halvings - 1)?;
    by_halves(&half, at, [middle, to], halvings - 1)
}

/// What fails where Newton's method comes to an orbit that the followed one is not shown to become.
fn another_orbit() -> Error {
    Error::NoConvergence {
        stage: "Newton's method to the orbit that is followed to other numbers, which comes to one far from it,",
        iterations: FOLLOWING_HALVINGS,
        residual: f64::NAN,
    }
}

/// Whether an orbit may be another one in a scene nearby.
fn is_near(one: &PeriodicOrbit, other: &PeriodicOrbit) -> bool {
    let speeds = one.impacts().iter().map(|impact| impact.approach.abs());
    let fastest = speeds.fold(0.0, f64::max);
    let mut pairs = one.impacts().iter().zip(other.impacts());
    pairs.all(|(a, b)| {
        let turned = (a.phase - b.phase + PI).rem_euclid(TAU) - PI;
        turned.abs() <= TRACKED_PHASE_SHIFT
            && (a.approach - b.approach).abs() <= TRACKED_SPEED_CHANGE * fastest
    })
}

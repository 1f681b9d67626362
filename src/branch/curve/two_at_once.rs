//! Points of a curve at which something else happens too.

use crate::branch::curve::condition::Condition;
use crate::branch::curve::corrector::{Found, length, weighted};
use crate::branch::curve::one::CurvePoint;
use crate::branch::curve::plane::{Plane, Spot};
use crate::branch::curve::step::{chord, stepped};
use crate::branch::zero::{Tried, zero_between};
use crate::error::Result;
use nalgebra::DVector;

/// An impact of so small a part of the unit of velocities has no speed.
const NO_SPEED: f64 = 1e-5;

/// A point of a curve that was accepted.
#[derive(Clone)]
pub(super) struct Point {
    pub found: Found,
    pub arclength: f64,
    pub indicators: Vec<(&'static str, f64)>,
}

/// Numbers whose signs tell what else happens on a curve.
pub(super) fn indicators(plane: &Plane<'_>, spot: &Spot) -> Result<Vec<(&'static str, f64)>> {
    plane.along(0, spot, |family| {
        let test = |multiplier: f64| family.multiplier_test(&spot.place, multiplier);
        let slowest = || -> Result<f64> {
            let speeds = family.approaches(&spot.place)?.into_iter();
            let least = speeds.fold(f64::INFINITY, f64::min);
            Ok(least / family.units.velocity)
        };
        Ok(match plane.condition {
            // Of half a motion a multiplier is another one's square root.
            Condition::Multiplier(_) if plane.signature.images.is_some() => {
                vec![("resonant_graze", slowest()?)]
            }
            Condition::Multiplier(mu) => {
                vec![("fold_flip", test(-mu)?), ("resonant_graze", slowest()?)]
            }
            Condition::OnCircle => vec![("resonant_graze", slowest()?)],
            Condition::NoSpeed(_) => {
                vec![("graze_fold", test(1.0)?), ("resonant_graze", test(-1.0)?)]
            }
            Condition::Together => vec![("graze_corner", slowest()?)],
        })
    })
}

/// What else happens on a step.
pub(super) fn passed(
    plane: &Plane<'_>,
    from: &Point,
    to: &Point,
    tangent: &DVector<f64>,
) -> Result<Vec<CurvePoint>> {
    let mut found = Vec::new();
    let step = length(&chord(plane, &from.found.spot, &to.found.spot));
    let normal = &weighted(tangent);
    for (k, (kind, after)) in to.indicators.iter().enumerate() {
        let before = from.indicators[k].1;
        if before * after >= 0.0 {
            continue;
        }
        let mut seconds: Vec<f64> = Vec::new();
        let mut point = |along: f64| {
            let Ok(there) = stepped(plane, &from.found, tangent, along, normal)? else {
                return Ok(None);
            };
            seconds.push(there.spot.second);
            Ok(Some(Tried {
                parameter: there.spot.place.value,
                value: indicators(plane, &there.spot)?[k].1,
                point: there.spot,
            }))
        };
        let zero = zero_between([step, before, *after], plane.span(0), &mut point)?;
        let (spot, along, error) = match zero {
            Some(zero) => (zero.point, zero.along, zero.error),
            None => (to.found.spot.clone(), step, step * plane.span(0)),
        };
        // Where an impact has no speed both determinants vanish, and no multiplier is -1.
        let others = indicators(plane, &spot)?;
        let is_graze =
            |(other, value): &(&str, f64)| *other == "resonant_graze" && value.abs() < NO_SPEED;
        if *kind == "fold_flip" && others.iter().any(is_graze) {
            continue;
        }
        let last = seconds
            .windows(2)
            .last()
            .map_or(step * plane.span(1), |two| (two[1] - two[0]).abs());
        found.push(CurvePoint {
            kind,
            parameters: [spot.place.value, spot.second],
            error: [error, last],
            arclength: from.arclength + along,
            orbit: plane.orbit(&spot)?,
        });
    }
    found.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    Ok(found)
}

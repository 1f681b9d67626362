//! A point of a curve that was accepted, and numbers of it whose signs tell what else happens there.

use crate::branch::curve::condition::Condition;
use crate::branch::curve::corrector::Found;
use crate::branch::curve::plane::Plane;
use crate::branch::equations::Equations;
use crate::branch::family::Family;
use crate::branch::multipliers::{own_multipliers, pair_of_product_one};
use crate::branch::place::Place;
use crate::error::Result;
use crate::orbit::PeriodicOrbit;

/// A point of a curve that was accepted.
#[derive(Clone)]
pub(super) struct Point {
    pub found: Found,
    pub arclength: f64,
    pub orbit: PeriodicOrbit,
    /// Whether it breaks a rule of contact, but for the speed that an impact has not.
    pub is_virtual: bool,
    pub indicators: Vec<(&'static str, f64)>,
}

impl Point {
    pub fn at(plane: &Plane<'_>, found: Found, arclength: f64) -> Result<Self> {
        let orbit = plane.orbit(&found.spot)?;
        Ok(Self {
            arclength,
            is_virtual: plane.is_virtual(&found.spot, &orbit)?,
            indicators: indicators(plane, &found)?,
            orbit,
            found,
        })
    }
}

/// Numbers of a spot whose signs tell what else happens on a curve.
pub(super) fn indicators(plane: &Plane<'_>, found: &Found) -> Result<Vec<(&'static str, f64)>> {
    let spot = &found.spot;
    let place = &spot.place;
    let at = (place, Some(&found.conditions.first));
    plane.along(0, spot, |family| {
        let test = |multiplier: f64| family.multiplier_test(at, multiplier);
        let speeds = family.approaches(place)?.into_iter();
        let slowest = speeds.fold(f64::INFINITY, f64::min) / family.units.velocity;
        let is_half = plane.signature.images.is_some();
        let mut all = Vec::new();
        match plane.condition {
            Condition::Multiplier(mu) => {
                all.push(("resonant_graze", slowest));
                // Of half a motion a multiplier is another one's square root.
                if !is_half {
                    all.push(("fold_flip", test(-mu)?));
                }
                // One coordinate alone has two multipliers, and their product is below one.
                let is_alone = place.state.states[0].len() == 2;
                if !(is_alone || is_half && mu < 0.0) {
                    let kind = if mu > 0.0 { "strong_1_1" } else { "strong_1_2" };
                    all.push((kind, slope(family, at, mu)?));
                }
            }
            Condition::OnCircle => {
                all.push(("resonant_graze", slowest));
                let own = own_multipliers(&family.orbit(place)?)?.unwrap_or_default();
                let sum = pair_of_product_one(&own).map_or(f64::NAN, |pair| pair.sum);
                // On the circle it is twice the cosine of an angle.
                all.push(("strong_1_1", sum - 2.0));
                all.push(("strong_1_2", sum + 2.0));
                all.push(("strong_1_3", sum + 1.0));
                all.push(("strong_1_4", sum));
            }
            Condition::NoSpeed(instant) => {
                all.push(("graze_fold", test(1.0)?));
                all.push(("resonant_graze", test(-1.0)?));
                all.push(("degenerate_graze", family.opening(place, instant)?));
            }
            Condition::Together | Condition::Reached { .. } => all.push(("graze_corner", slowest)),
        }
        Ok(all)
    })
}

/// The step of [`slope`].
const STEP: f64 = 1e-3;

/// How fast the determinant that is zero at a multiplier changes with that; nothing where two are equal.
fn slope(family: &Family<'_>, at: (&Place, Option<&Equations>), mu: f64) -> Result<f64> {
    let unit = family.multiplier_determinant(at, mu)?.lengths;
    let beside = |steps: f64| -> Result<f64> {
        let own = family.multiplier_determinant(at, mu + steps * STEP)?;
        Ok(own.in_parts_of(unit))
    };
    let near = beside(1.0)? - beside(-1.0)?;
    let far = beside(2.0)? - beside(-2.0)?;
    Ok((8.0 * near - far) / (12.0 * STEP))
}

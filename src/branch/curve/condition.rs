//! What holds on a curve besides the equations of its loops.

use crate::branch::equations::Equations;
use crate::branch::family::Family;
use crate::branch::multipliers::{own_multipliers, pair_of_product_one};
use crate::branch::place::Place;
use crate::error::Result;

/// What holds on a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Condition {
    /// A multiplier of the loop is a number; of half a motion that of half a period.
    Multiplier(f64),
    /// Two conjugate multipliers of the orbit are on the unit circle: their product is 1.
    OnCircle,
    /// The impact of an instant has no speed.
    NoSpeed(usize),
    /// A stop is reached at an instant at which others are hit, and not hit.
    Reached { stop: usize, instant: usize },
    /// Stops are hit at one instant, which the equations of the loop say themselves.
    Together,
}

impl Condition {
    /// A smooth number that is zero where it holds, in a unit or its own, with the logarithm of that; none where nothing is to be said. The
    /// equations of the place serve where they are known.
    pub fn value(
        self,
        family: &Family<'_>,
        (place, equations): (&Place, Option<&Equations>),
        unit: Option<f64>,
    ) -> Result<Option<(f64, f64)>> {
        let value = match self {
            Self::Multiplier(mu) => {
                let own = family.multiplier_determinant((place, equations), mu)?;
                let unit = unit.unwrap_or(own.lengths);
                return Ok(Some((own.in_parts_of(unit), unit)));
            }
            Self::OnCircle => {
                let own = own_multipliers(&family.orbit(place)?)?.unwrap_or_default();
                pair_of_product_one(&own).map_or(f64::NAN, |pair| pair.product.ln())
            }
            Self::NoSpeed(instant) => family.approach(place, instant)? / family.units.velocity,
            Self::Reached { stop, instant } => family.gap_at(place, (stop, instant))?,
            Self::Together => return Ok(None),
        };
        Ok(Some((value, 0.0)))
    }
}

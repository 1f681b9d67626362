//! What holds on a curve besides the equations of its loops.

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
    /// Stops are hit at one instant, which the equations of the loop say themselves.
    Together,
}

impl Condition {
    /// A smooth number that is zero where it holds, and the logarithm of the unit that it has there; none where nothing is to be said.
    pub fn measured(self, family: &Family<'_>, place: &Place) -> Result<Option<(f64, f64)>> {
        if let Self::Multiplier(mu) = self {
            let own = family.multiplier_determinant(place, mu)?;
            let unit = own.lengths;
            return Ok(Some((own.in_parts_of(unit), unit)));
        }
        Ok(self.value(family, place, 0.0)?.map(|value| (value, 0.0)))
    }

    /// The same in a unit.
    pub fn value(self, family: &Family<'_>, place: &Place, unit: f64) -> Result<Option<f64>> {
        match self {
            Self::Multiplier(mu) => {
                let own = family.multiplier_determinant(place, mu)?;
                Ok(Some(own.in_parts_of(unit)))
            }
            Self::OnCircle => {
                let own = own_multipliers(&family.orbit(place)?)?.unwrap_or_default();
                let size = pair_of_product_one(&own).map_or(f64::NAN, |pair| pair.product.ln());
                Ok(Some(size))
            }
            Self::NoSpeed(instant) => {
                let speed = family.approach(place, instant)?;
                Ok(Some(speed / family.units.velocity))
            }
            Self::Together => Ok(None),
        }
    }
}

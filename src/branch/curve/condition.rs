//! What holds on a curve besides the equations of its loops.

use crate::branch::family::Family;
use crate::branch::multipliers::{own_multipliers, pair_at_circle};
use crate::branch::place::Place;
use crate::error::Result;

/// What holds on a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Condition {
    /// A multiplier of the loop is a number; of half a motion that of half a period.
    Multiplier(f64),
    /// Two conjugate multipliers of the orbit are on the unit circle.
    OnCircle,
    /// The impact of an instant has no speed.
    NoSpeed(usize),
    /// Stops are hit at one instant, which the equations of the loop say themselves.
    Together,
}

impl Condition {
    /// A number that is zero where it holds; none where nothing is to be said.
    pub fn value(self, family: &Family<'_>, place: &Place) -> Result<Option<f64>> {
        match self {
            Self::Multiplier(multiplier) => family.multiplier_test(place, multiplier).map(Some),
            Self::OnCircle => {
                let own = own_multipliers(&family.orbit(place)?)?.unwrap_or_default();
                Ok(Some(
                    pair_at_circle(&own).map_or(f64::NAN, |mu| mu.norm().ln()),
                ))
            }
            Self::NoSpeed(instant) => {
                let speed = family.approach(place, instant)?;
                Ok(Some(speed / family.units.velocity))
            }
            Self::Together => Ok(None),
        }
    }
}

//! The condition that holds on a curve of special points besides the equations of its loops (theory 20).

use crate::branch::equations::Equations;
use crate::branch::multipliers::{own_multipliers, pair_of_product_one};
use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::error::Result;

/// The condition of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Condition {
    /// A multiplier of the loop is a number; for a loop of half a period, a multiplier of that.
    Multiplier(f64),
    /// Two conjugate multipliers of the orbit are on the unit circle: their product is 1.
    OnCircle,
    /// The impact of an instant has no speed.
    NoSpeed(usize),
    /// A stop is reached at an instant at which others are hit, and not hit.
    Reached { stop: usize, instant: usize },
    /// Stops are hit at one instant: the equations of the loop imply it.
    Together,
}

impl Condition {
    /// A smooth function that is zero where the condition holds, and the unit in which it is taken (the logarithm of a size): the given
    /// one, else its own. None where the loop's equations imply the condition. The equations at the loop are used where they are known.
    pub fn value(
        self,
        problem: &BranchProblem<'_>,
        (place, equations): (&ParametricLoop, Option<&Equations>),
        unit: Option<f64>,
    ) -> Result<Option<(f64, f64)>> {
        let value = match self {
            Self::Multiplier(mu) => {
                let own = problem.multiplier_determinant((place, equations), mu)?;
                let unit = unit.unwrap_or(own.lengths);
                return Ok(Some((own.in_parts_of(unit), unit)));
            }
            Self::OnCircle => {
                let own = own_multipliers(&problem.orbit(place)?)?.unwrap_or_default();
                pair_of_product_one(&own).map_or(f64::NAN, |pair| pair.product.ln())
            }
            Self::NoSpeed(instant) => problem.approach(place, instant)? / problem.units.velocity,
            Self::Reached { stop, instant } => problem.gap_at(place, (stop, instant))?,
            Self::Together => return Ok(None),
        };
        Ok(Some((value, 0.0)))
    }
}

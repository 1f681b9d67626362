//! Where a function of a branch is zero on a step.

use crate::branch::corrector::Settled;
use crate::branch::family::Family;
use crate::branch::step::{Point, Target, step_to};
use crate::error::Result;

/// Evaluations of a search, and a part of a step below which it is over.
const MOST_TRIES: usize = 40;
const SHARP: f64 = 1e-13;
/// The search is over when the number of the branch moves by no more than this part of its range.
const KNOWN: f64 = 1e-12;
/// A zero on a step from a point.
pub(super) struct Zero {
    pub settled: Settled,
    pub along: f64,
    pub error: f64,
}

/// The zero of a function of the branch between a point, where it has a value, and another so far along the step from it, by the method
/// of the false position in its Illinois form; none where the branch cannot be reached between.
pub(super) fn zero_between(
    family: &Family<'_>,
    from: &Point,
    [length, at_start, at_end]: [f64; 3],
    of: &dyn Fn(&Settled) -> Result<f64>,
) -> Result<Option<Zero>> {
    let (mut low, mut high) = ((0.0, at_start), (length, at_end));
    let mut found: Option<Zero> = None;
    let mut side = 0;
    for _ in 0..MOST_TRIES {
        let wanted = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let along = if wanted > low.0 && wanted < high.0 {
            wanted
        } else {
            0.5 * (low.0 + high.0)
        };
        let Ok(settled) = step_to(family, from.foot(), Target::Length(along))? else {
            break;
        };
        let value = of(&settled)?;
        let before = found.as_ref().map_or(f64::INFINITY, |zero| {
            (zero.settled.place.value - settled.place.value).abs()
        });
        let is_over = before <= KNOWN * family.span() && high.0 - low.0 < 0.5 * length
            || high.0 - low.0 <= SHARP * length
            || value == 0.0;
        found = Some(Zero {
            settled,
            along,
            error: if value == 0.0 {
                0.0
            } else {
                before.min(length * family.span())
            },
        });
        if is_over {
            break;
        }
        if (value > 0.0) == (low.1 > 0.0) {
            low = (along, value);
            if side == -1 {
                high.1 *= 0.5;
            }
            side = -1;
        } else {
            high = (along, value);
            if side == 1 {
                low.1 *= 0.5;
            }
            side = 1;
        }
    }
    Ok(found)
}

//! Where a branch comes to a boundary, beyond which its orbits break a rule of contact: between a point that keeps them and one that does
//! not, by halves.

use crate::branch::corrector::{Attempt, Settled};
use crate::branch::family::Family;
use crate::branch::step::{Point, Target, step_to};
use crate::error::Result;
use crate::orbit::PeriodicOrbit;

/// Halvings of a step.
const MOST_HALVINGS: usize = 60;
/// A boundary is known when it lies between points no farther apart than this, in arclength.
const KNOWN: f64 = 1e-11;

/// The last point found before a boundary, and the orbit behind it.
pub(super) struct Boundary {
    pub last: Option<(Settled, PeriodicOrbit)>,
    pub beyond: PeriodicOrbit,
    /// By how much the number of the branch differs between them.
    pub width: f64,
    /// How much of the step is left between them where the branch was lost there: from the last point it may be found again.
    pub left: Option<f64>,
}

/// Comes nearer to a boundary that lies within a step from a point.
pub(super) fn located(
    family: &Family<'_>,
    from: &Point,
    (step, value, beyond): (f64, f64, PeriodicOrbit),
) -> Result<Boundary> {
    let (mut low, mut high) = (0.0, step);
    let (mut before, mut behind) = (from.place.value, value);
    let mut found = Boundary {
        last: None,
        beyond,
        width: 0.0,
        left: None,
    };
    for _ in 0..MOST_HALVINGS {
        if high - low <= KNOWN {
            break;
        }
        let middle = 0.5 * (low + high);
        let there: Attempt<Settled> = step_to(family, from.foot(), Target::Length(middle));
        let Ok(settled) = there? else {
            found.left = Some(high - low);
            break;
        };
        let orbit = family.orbit(&settled.place)?;
        let value = settled.place.value;
        if orbit.is_admissible() == Some(false) {
            (high, behind, found.beyond) = (middle, value, orbit);
        } else {
            (low, before, found.last) = (middle, value, Some((settled, orbit)));
        }
    }
    found.width = (before - behind).abs();
    Ok(found)
}

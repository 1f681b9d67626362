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

/// What lies on both sides of a boundary on a step: the point nearest to it on the side of the step's beginning, the orbit on the other.
pub(super) struct Boundary {
    pub last: Option<(Settled, PeriodicOrbit)>,
    pub other: PeriodicOrbit,
    /// By how much the number of the branch differs between them.
    pub width: f64,
    /// How much of the step is left between them where the branch was lost there: from the last point it may be found again.
    pub left: Option<f64>,
}

/// Whether an orbit breaks a rule of contact.
pub(super) fn is_broken(orbit: &PeriodicOrbit) -> bool {
    orbit.is_admissible() == Some(false)
}

/// Comes nearer to a boundary that lies within a step from a point.
pub(super) fn located(
    family: &Family<'_>,
    from: &Point,
    (step, value, other): (f64, f64, PeriodicOrbit),
) -> Result<Boundary> {
    let was_broken = is_broken(&from.orbit);
    let (mut low, mut high) = (0.0, step);
    let (mut before, mut behind) = (from.place.value, value);
    let mut found = Boundary {
        last: None,
        other,
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
        if is_broken(&orbit) == was_broken {
            (low, before, found.last) = (middle, value, Some((settled, orbit)));
        } else {
            (high, behind, found.other) = (middle, value, orbit);
        }
    }
    found.width = (before - behind).abs();
    Ok(found)
}

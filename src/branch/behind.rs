//! Orbits behind a boundary that have other instants: built from the virtual ones into which the branch goes on there.

use crate::branch::candidate::Candidate;
use crate::branch::corrector::directions;
use crate::branch::equations::Foot;
use crate::branch::family::Family;
use crate::branch::place::{Direction, Place};
use crate::branch::special::Special;
use crate::branch::step::{Target, step_to};
use crate::error::Result;

/// How far behind the boundary it is looked for at first, in arclength, and how often half as far.
const BEHIND: f64 = 1e-2;
const MOST_HALVINGS: usize = 8;

/// Makes of a loop one with other instants; none where it cannot.
pub(super) type Rebuilt<'a, 'b> = &'a dyn Fn(&Place) -> Result<Option<(Family<'b>, Place)>>;

/// The orbit behind a boundary at the value of a loop there, which another is made of: one that keeps the rules of contact, if there is one.
pub(super) fn behind<'a>(
    family: &Family<'a>,
    place: &Place,
    special: &Special,
    rebuilt: Rebuilt<'_, 'a>,
) -> Result<Option<Candidate>> {
    let equations = family.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    let ahead = Direction::of(&special.direction);
    let same = tangent.loop_part.len() == ahead.loop_part.len();
    let sign = if same {
        tangent.dot(&ahead)
    } else {
        tangent.value_part * ahead.value_part
    };
    let tangent = &tangent.scaled(if sign < 0.0 { -1.0 } else { 1.0 });
    // Past a further boundary an orbit breaks a rule that it keeps nearer to this one.
    let mut broken = None;
    let mut length = BEHIND;
    for _ in 0..MOST_HALVINGS {
        let from: Foot<'_> = (place, &equations, tangent);
        if let Ok(behind) = step_to(family, from, Target::Length(length))?
            && let Some((other, at)) = rebuilt(&behind.place)?
        {
            let by_value = Direction::of_value(other.n_unknowns(&at));
            if let Ok(settled) = other.corrected(at, &by_value)? {
                let own = Candidate::at(&other, &settled.place, special.parameter)?;
                if own.orbit.is_admissible() != Some(false) {
                    return Ok(Some(own));
                }
                broken.get_or_insert(own);
            }
        }
        length *= 0.5;
    }
    Ok(broken)
}

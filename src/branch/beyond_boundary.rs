//! Orbits beyond a boundary that have other instants: made of the virtual ones with which the branch goes on there.

use crate::branch::candidate::Candidate;
use crate::branch::equations::BasePoint;
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::special::Special;
use crate::branch::zero_problem::directions;
use crate::continuation::{ScaledDirection, corrected};
use crate::error::Result;
use crate::tolerance::BEYOND_BOUNDARY_LENGTH;

/// Halvings of the distance from the boundary at which an orbit is looked for. `[work]`
const MOST_BEYOND_HALVINGS: usize = 8;

/// Makes a loop with other instants of a virtual one, and its problem; none where it cannot.
pub(super) type LoopRebuilder<'a, 'b> =
    &'a dyn Fn(&ParametricLoop) -> Result<Option<(BranchProblem<'b>, ParametricLoop)>>;

/// An orbit beyond a boundary, made of a virtual one some arclength beyond: one that keeps the rules of contact, if there is one.
pub(super) fn orbit_beyond_boundary<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
    special: &Special,
    rebuilt: LoopRebuilder<'_, 'a>,
) -> Result<Option<Candidate>> {
    let equations = problem.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    let ahead = BranchDirection::of(&special.direction);
    let same = tangent.loop_part.len() == ahead.loop_part.len();
    let sign = if same {
        tangent.dot(&ahead)
    } else {
        tangent.value_part * ahead.value_part
    };
    let tangent = &tangent.scaled(if sign < 0.0 { -1.0 } else { 1.0 });
    // Beyond a further boundary an orbit breaks a rule that it keeps nearer to this one.
    let mut broken = None;
    let mut length = BEYOND_BOUNDARY_LENGTH;
    for _ in 0..MOST_BEYOND_HALVINGS {
        let from: BasePoint<'_> = (place, &equations, tangent);
        if let Ok(beyond) = step_to(problem, from, StepTarget::Length(length))?
            && let Some((other, at)) = rebuilt(&beyond.iterate)?
        {
            let by_value = BranchDirection::of_value(other.n_unknowns(&at));
            if let Ok(settled) = corrected(&other, at, &by_value)? {
                let own = Candidate::at(&other, &settled.iterate, special.parameter)?;
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

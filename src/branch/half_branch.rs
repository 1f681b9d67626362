//! Both halves of a branch or a curve from its first point, joined.

use crate::branch::options::Heading;
use crate::continuation::{BranchEnd, EndReason, HalfBranch};
use crate::error::Result;

/// Both halves as one, each point with the sign of its arclength.
pub(super) struct JoinedBranch<P, S> {
    pub points: Vec<(P, f64)>,
    pub special: Vec<(S, f64)>,
    pub ends: [BranchEnd; 2],
    pub is_closed: bool,
}

/// Follows both halves from a point, or one, `half` being given the sign of the tangent; one that closes, or is interrupted, is the only one.
pub(super) fn both_halves<P: Clone, S>(
    first: &P,
    heading: Heading,
    mut half: impl FnMut(f64) -> Result<HalfBranch<P, S>>,
) -> Result<JoinedBranch<P, S>> {
    let none = || HalfBranch {
        points: Vec::new(),
        special: Vec::new(),
        end: BranchEnd::new(EndReason::Start, "it was followed the other way".to_owned()),
    };
    let up = if heading == Heading::Down {
        none()
    } else {
        half(1.0)?
    };
    let is_closed = up.end.reason == EndReason::Closed;
    let is_over = is_closed || up.end.reason == EndReason::Interrupted;
    let down = if heading == Heading::Up || is_over {
        none()
    } else {
        half(-1.0)?
    };
    let low = down.points.into_iter().rev().map(|point| (point, -1.0));
    let high = [first.clone()].into_iter().chain(up.points);
    let before = down.special.into_iter().rev().map(|own| (own, -1.0));
    let after = up.special.into_iter().map(|own| (own, 1.0));
    Ok(JoinedBranch {
        points: low.chain(high.map(|point| (point, 1.0))).collect(),
        special: before.chain(after).collect(),
        ends: [if is_closed { up.end.clone() } else { down.end }, up.end],
        is_closed,
    })
}

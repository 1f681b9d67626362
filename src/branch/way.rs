//! Both ways along a branch or a curve from a point, joined.

use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::options::Heading;
use crate::error::Result;

/// A way from a point, which is not among its points, and why it ended.
pub(super) struct Way<P, S> {
    pub points: Vec<P>,
    pub special: Vec<S>,
    pub end: BranchEnd,
}

/// Both ways as one, each thing with the sign of its arclength.
pub(super) struct Joined<P, S> {
    pub points: Vec<(P, f64)>,
    pub special: Vec<(S, f64)>,
    pub ends: [BranchEnd; 2],
    pub is_closed: bool,
}

/// Goes both ways from a point, or one, for a sign of its direction; what closes on the way up, or is broken off, is not gone down.
pub(super) fn both_ways<P: Clone, S>(
    first: &P,
    heading: Heading,
    mut way: impl FnMut(f64) -> Result<Way<P, S>>,
) -> Result<Joined<P, S>> {
    let none = || Way {
        points: Vec::new(),
        special: Vec::new(),
        end: BranchEnd::new(EndReason::Start, "it was followed the other way".to_owned()),
    };
    let up = if heading == Heading::Down {
        none()
    } else {
        way(1.0)?
    };
    let is_closed = up.end.reason == EndReason::Closed;
    let is_over = is_closed || up.end.reason == EndReason::Interrupted;
    let down = if heading == Heading::Up || is_over {
        none()
    } else {
        way(-1.0)?
    };
    let low = down.points.into_iter().rev().map(|point| (point, -1.0));
    let high = [first.clone()].into_iter().chain(up.points);
    let behind = down.special.into_iter().rev().map(|own| (own, -1.0));
    let ahead = up.special.into_iter().map(|own| (own, 1.0));
    Ok(Joined {
        points: low.chain(high.map(|point| (point, 1.0))).collect(),
        special: behind.chain(ahead).collect(),
        ends: [if is_closed { up.end.clone() } else { down.end }, up.end],
        is_closed,
    })
}

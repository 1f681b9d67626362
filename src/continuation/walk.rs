//! One half of a curve of zeros, step by step from its first point to its end (theory 19): where steps are refused they are halved, and
//! the curve ends where it comes back to its first point.

use crate::continuation::end::{BranchEnd, EndReason};
use crate::continuation::failure::StepFailure;
use crate::continuation::zero_problem::ScaledDirection;
use crate::error::Result;
use crate::tolerance::CLOSED_BRANCH_DIRECTION;

/// One half of a branch or a curve, without its first point, and why it ended.
pub(crate) struct HalfBranch<P, S> {
    pub points: Vec<P>,
    pub special: Vec<S>,
    pub end: BranchEnd,
}

/// The outcome of a step.
pub(crate) enum StepOutcome<P, S> {
    /// A point, the special points before it, and the factor on the next step.
    Accepted(Box<P>, Vec<S>, f64),
    /// An end: the last point, where there is one, and the special points before it.
    End(Option<Box<P>>, Vec<S>, BranchEnd),
    /// Why there is no point: a shorter step may succeed.
    Refused(StepFailure),
    /// The problem was changed, and the step is to be made again.
    Changed,
}

impl<P, S> StepOutcome<P, S> {
    /// An end at the point before the step.
    pub fn end(end: BranchEnd) -> Self {
        Self::End(None, Vec::new(), end)
    }
}

/// A curve that is followed: what is done at each of its steps.
pub(crate) trait Walk {
    type Point;
    type Iterate;
    type Direction: ScaledDirection;
    type Special;

    /// Makes a step of some arclength \[-\] from the last of the points, from the first one if there are none, and judges it.
    fn step(
        &mut self,
        first: &mut Self::Point,
        points: &mut [Self::Point],
        length: f64,
    ) -> Result<StepOutcome<Self::Point, Self::Special>>;

    /// The tangent at a point.
    fn tangent<'p>(&self, own: &'p Self::Point) -> &'p Self::Direction;

    /// The iterate of the first point in the round of another one, and the chord from there to that.
    fn from_first(
        &self,
        first: &Self::Point,
        own: &Self::Point,
    ) -> (Self::Iterate, Self::Direction);

    /// An accepted point as one of the curve.
    fn kept(&mut self, own: Self::Point) -> Result<Self::Point>;

    /// Whether the curve ends at an accepted point; with the special point there.
    fn ended(&self, own: &Self::Point) -> Result<Option<(Option<Self::Special>, BranchEnd)>>;

    /// The first point again, behind the last one of a closed curve, and the special points between; `passed` are those of the step that
    /// led past it.
    fn closed(
        &self,
        from: &Self::Point,
        first: (&Self::Point, Self::Iterate),
        passed: Vec<Self::Special>,
    ) -> Result<(Self::Point, Vec<Self::Special>)>;

    /// The end at a point from which the shortest step is refused, with the special point there.
    fn refused(
        &self,
        from: (&Self::Point, &[Self::Point]),
        failure: StepFailure,
        length: f64,
    ) -> Result<(Option<Self::Special>, BranchEnd)>;
}

/// Follows a curve from a point, which is not among the points returned, along its tangent; with the smallest, the first and the largest
/// step \[-\].
pub(crate) fn walk<W: Walk>(
    walker: &mut W,
    mut first: W::Point,
    [smallest, usual, largest]: [f64; 3],
    most_points: usize,
) -> Result<HalfBranch<W::Point, W::Special>> {
    let mut points: Vec<W::Point> = Vec::new();
    let mut special = Vec::new();
    let (mut step, mut farthest) = (usual, 0.0f64);
    let end = loop {
        if points.len() >= most_points {
            let detail = format!("{most_points} points were asked for");
            break BranchEnd::new(EndReason::Points, detail);
        }
        let failure = match walker.step(&mut first, &mut points, step)? {
            StepOutcome::Accepted(own, found, factor) => {
                let (begun, home) = walker.from_first(&first, &own);
                let (away, tangent) = (home.length(), walker.tangent(&first));
                let has_closed = farthest > 2.0 * step
                    && away < step
                    && tangent.dot(walker.tangent(&own)) > CLOSED_BRANCH_DIRECTION;
                farthest = farthest.max(away);
                let mut passed = Vec::new();
                if has_closed && tangent.dot(&home) > 0.0 {
                    passed = found;
                } else {
                    special.extend(found);
                    points.push(walker.kept(*own)?);
                }
                if has_closed {
                    let from = points.last().unwrap_or(&first);
                    let (last, found) = walker.closed(from, (&first, begun), passed)?;
                    special.extend(found);
                    points.push(last);
                    let detail = "it came back to where it began".to_owned();
                    break BranchEnd::new(EndReason::Closed, detail);
                }
                let ended = points.last().map_or(Ok(None), |own| walker.ended(own))?;
                if let Some((found, end)) = ended {
                    special.extend(found);
                    break end;
                }
                step = (step * factor).clamp(smallest, largest);
                continue;
            }
            StepOutcome::End(last, found, end) => {
                special.extend(found);
                points.extend(last.map(|last| *last));
                break end;
            }
            StepOutcome::Changed => continue,
            StepOutcome::Refused(failure) => failure,
        };
        if step <= smallest {
            let from = points.last().unwrap_or(&first);
            let (found, end) = walker.refused((from, &points), failure, step)?;
            special.extend(found);
            break end;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(HalfBranch {
        points,
        special,
        end,
    })
}

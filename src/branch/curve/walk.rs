//! What is done at each step of a curve (theory 20).

use crate::branch::curve::codimension_two::passed;
use crate::branch::curve::condition::Condition;
use crate::branch::curve::direction::CurveDirection;
use crate::branch::curve::point::AcceptedCurvePoint;
use crate::branch::curve::predictor::{chord, step_to_number, turned_to};
use crate::branch::curve::problem::{CurveProblem, TwoParameterLoop};
use crate::branch::curve::result::CurvePoint;
use crate::branch::curve::zero_problem::CorrectedCurvePoint;
use crate::continuation::{
    Attempt, BranchEnd, EndReason, ScaledDirection, StepFailure, StepOutcome, Walk, step_factor,
    stepped,
};
use crate::error::{Error, Result, digits};
use crate::observer::report;

/// A curve that is followed.
pub(super) struct CurveWalk<'a, 'o> {
    pub plane: &'o CurveProblem<'a>,
}

/// The outcome of a step along a curve.
type CurveOutcome = StepOutcome<AcceptedCurvePoint, CurvePoint>;

impl Walk for CurveWalk<'_, '_> {
    type Point = AcceptedCurvePoint;
    type Iterate = TwoParameterLoop;
    type Direction = CurveDirection;
    type Special = CurvePoint;

    fn step(
        &mut self,
        first: &mut AcceptedCurvePoint,
        points: &mut [AcceptedCurvePoint],
        length: f64,
    ) -> Result<CurveOutcome> {
        let plane = self.plane;
        let from = points.last().unwrap_or(first);
        let at = [from.found.iterate.place.value, from.found.iterate.second];
        if report(at[0]).is_err() {
            return Ok(StepOutcome::end(broken_off(at)));
        }
        let end = reached(plane, &from.found, length);
        if let Some((axis, value)) = end.filter(|&(axis, value)| at[axis] == value) {
            return Ok(StepOutcome::end(range_end(axis, value)));
        }
        let (point, factor) = match advance(plane, from, (length, end)) {
            Err(Error::Interrupted) => {
                return Ok(StepOutcome::end(broken_off(at)));
            }
            Err(error) => return Err(error),
            Ok(Err(failure)) => return Ok(StepOutcome::Refused(failure)),
            Ok(Ok(accepted)) => accepted,
        };
        let mut special = passed(plane, from, &point)?;
        let mut last = None;
        if let Some(k) = special.iter().position(|own| is_last(plane, &own.0)) {
            special.truncate(k + 1);
            last = Some(special[k].clone());
        }
        let special = special.into_iter().map(|own| own.0).collect();
        if let Some((last, found)) = last {
            let detail = format!("{}: beyond it the two multipliers are real", last.kind);
            let point = AcceptedCurvePoint::at(plane, found, last.arclength)?;
            let end = BranchEnd::new(EndReason::Boundary, detail);
            return Ok(StepOutcome::End(Some(Box::new(point)), special, end));
        }
        if plane.condition == Condition::OnCircle && is_real(&point) {
            let detail = "beyond it the two multipliers are real".to_owned();
            let end = BranchEnd::new(EndReason::Boundary, detail);
            return Ok(StepOutcome::End(None, special, end));
        }
        Ok(StepOutcome::Accepted(point, special, factor))
    }

    fn tangent<'p>(&self, own: &'p AcceptedCurvePoint) -> &'p CurveDirection {
        &own.found.tangent
    }

    fn home_from(
        &self,
        first: &AcceptedCurvePoint,
        own: &AcceptedCurvePoint,
    ) -> (TwoParameterLoop, CurveDirection) {
        let iterate = &own.found.iterate;
        let begun = turned_to(self.plane, &first.found.iterate, iterate);
        let home = chord(self.plane, &begun, iterate);
        (begun, home)
    }

    fn kept(&mut self, own: AcceptedCurvePoint) -> Result<AcceptedCurvePoint> {
        Ok(own)
    }

    fn ended(&self, _: &AcceptedCurvePoint) -> Result<Option<(Option<CurvePoint>, BranchEnd)>> {
        Ok(None)
    }

    fn closed(
        &self,
        from: &AcceptedCurvePoint,
        (first, iterate): (&AcceptedCurvePoint, TwoParameterLoop),
        passed: Vec<CurvePoint>,
    ) -> Result<(AcceptedCurvePoint, Vec<CurvePoint>)> {
        let covered = chord(self.plane, &from.found.iterate, &iterate).length();
        let mut last = first.clone();
        last.arclength = from.arclength + covered;
        last.found.iterate = iterate;
        Ok((last, passed))
    }

    fn refused(
        &self,
        _: (&AcceptedCurvePoint, &[AcceptedCurvePoint]),
        failure: StepFailure,
        _: f64,
    ) -> Result<(Option<CurvePoint>, BranchEnd)> {
        Ok((None, failure.end()))
    }
}

/// Makes a step from a point and judges it: a point and the factor on the next step, or why there is none.
fn advance(
    plane: &CurveProblem<'_>,
    from: &AcceptedCurvePoint,
    ahead: (f64, Option<(usize, f64)>),
) -> Attempt<(Box<AcceptedCurvePoint>, f64)> {
    let mut found = match within(plane, &from.found, ahead)? {
        Ok(found) => found,
        Err(failure) => return Ok(Err(failure)),
    };
    let side = from.found.tangent.dot(&found.tangent);
    found.tangent = found.tangent.scaled(side.signum());
    let factor = match step_factor(found.contraction, side) {
        Ok(factor) => factor,
        Err(reason) => return Ok(Err(StepFailure::distrusted(reason.to_owned()))),
    };
    let covered = chord(plane, &from.found.iterate, &found.iterate).length();
    let point = AcceptedCurvePoint::at(plane, found, from.arclength + covered)?;
    let least = [plane.units.position, plane.units.velocity];
    Ok(match point.orbit.closure_defect(least)? {
        None => Ok((Box::new(point), factor)),
        Some(by) => {
            let detail = format!(
                "the motion, followed once more by another route, misses its beginning by {}",
                digits(by)
            );
            Err(StepFailure::distrusted(detail))
        }
    })
}

/// Whether a curve ends at a point: two multipliers on the circle meet where it crosses the real axis.
fn is_last(plane: &CurveProblem<'_>, own: &CurvePoint) -> bool {
    plane.condition == Condition::OnCircle && matches!(own.kind, "strong_1_1" | "strong_1_2")
}

/// Whether the two multipliers of a point whose product is 1 are real.
fn is_real(point: &AcceptedCurvePoint) -> bool {
    point.test_values.iter().any(|(kind, value)| match *kind {
        "strong_1_1" => *value > 0.0,
        "strong_1_2" => *value < 0.0,
        _ => false,
    })
}

/// The end of a curve that the observer interrupts.
fn broken_off([x, y]: [f64; 2]) -> BranchEnd {
    let detail = format!("broken off at ({}, {})", digits(x), digits(y));
    BranchEnd::new(EndReason::Interrupted, detail)
}

/// The end of a curve at an end of a range.
fn range_end(axis: usize, value: f64) -> BranchEnd {
    let name = ["first", "second"][axis];
    let detail = format!("the range of the {name} number ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

/// The number whose range ends within a step, by its axis, and the value there.
fn reached(
    plane: &CurveProblem<'_>,
    from: &CorrectedCurvePoint,
    step: f64,
) -> Option<(usize, f64)> {
    let at = [from.iterate.place.value, from.iterate.second];
    let ahead = (0..2).filter_map(|axis| {
        let (low, high) = plane.between[axis];
        let rate = from.tangent.numbers()[axis] * plane.span(axis);
        let end = if rate > 0.0 { high } else { low };
        // A number that does not change has no end.
        let ahead = (end - at[axis]) / rate;
        (rate != 0.0 && ahead <= step).then_some((axis, end, ahead))
    });
    let first = ahead.min_by(|a, b| a.2.total_cmp(&b.2));
    first.map(|(axis, end, _)| (axis, end))
}

/// A step, to the end of a range if one is reached, or if it leads out of one.
fn within(
    plane: &CurveProblem<'_>,
    from: &CorrectedCurvePoint,
    (step, end): (f64, Option<(usize, f64)>),
) -> Attempt<CorrectedCurvePoint> {
    if let Some(end) = end {
        return step_to_number(plane, from, step, end);
    }
    let found = stepped(plane, from.base(), step)?;
    let Ok(there) = &found else {
        return Ok(found);
    };
    let values = [there.iterate.place.value, there.iterate.second];
    let is_out = |axis: &usize| {
        let (low, high) = plane.between[*axis];
        !(low..=high).contains(&values[*axis])
    };
    match (0..2).find(is_out) {
        Some(axis) => {
            let (low, high) = plane.between[axis];
            let end = values[axis].clamp(low, high);
            step_to_number(plane, from, step, (axis, end))
        }
        None => Ok(found),
    }
}

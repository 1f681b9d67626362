//! What is done at each step of a branch (theory 19).

use crate::branch::advance::{BranchOutcome, advance};
use crate::branch::bifurcations::bifurcations;
use crate::branch::collapse::{ended, meeting, named};
use crate::branch::options::{ContinuationOptions, Virtual};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{AcceptedPoint, StepTarget};
use crate::branch::problem::BranchProblem;
use crate::branch::special::Special;
use crate::branch::test_functions::TestFunctionValues;
use crate::branch::through_touch::{PassedTouch, is_passed, off_contact, onto_contact};
use crate::branch::zero_problem::directions;
use crate::continuation::{
    BranchEnd, EndReason, ScaledDirection, StepFailure, StepOutcome, Walk, tangent,
};
use crate::error::{Error, Result, digits};
use crate::observer::report;
use crate::tolerance::OUTGROWN_UNITS;

/// A branch that is followed.
pub(super) struct BranchWalk<'a, 'o> {
    pub problem: BranchProblem<'a>,
    /// That of its first point: behind a touch motions have other instants.
    pub home: BranchProblem<'a>,
    /// Where it goes on behind a touch, if the last point is beside one.
    pub passed: Option<PassedTouch<'a>>,
    pub options: &'o ContinuationOptions,
    /// The end of the range, if the last step was to lead there.
    pub reached: Option<f64>,
}

impl Walk for BranchWalk<'_, '_> {
    type Point = AcceptedPoint;
    type Iterate = ParametricLoop;
    type Direction = BranchDirection;
    type Special = Special;

    fn step(
        &mut self,
        first: &mut AcceptedPoint,
        points: &mut [AcceptedPoint],
        length: f64,
    ) -> Result<BranchOutcome> {
        if let Some(PassedTouch { problem, point }) = self.passed.take() {
            self.problem = problem;
            return Ok(StepOutcome::Accepted(Box::new(point), Vec::new(), 1.0));
        }
        let from = points.last().unwrap_or(first);
        if report(from.place.value).is_err() {
            return Ok(StepOutcome::end(broken_off(from)));
        }
        self.reached = reaches(&self.problem, from, length);
        if let Some(end) = self.reached.filter(|&end| end == from.place.value) {
            return Ok(StepOutcome::end(at_end(end)));
        }
        let target = self
            .reached
            .map_or(StepTarget::Length(length), StepTarget::Value);
        match advance(&self.problem, from, target, self.options.beyond) {
            Err(Error::Interrupted) => Ok(StepOutcome::end(broken_off(from))),
            // Where the mirror image of half the motion is not its other half any more, the branch goes on with the whole period.
            Ok(StepOutcome::Refused(StepFailure::NotOdd { .. }))
                if self.options.symmetric.is_none() =>
            {
                let end = self.go_on_whole(first, points)?;
                Ok(end.map_or(StepOutcome::Changed, StepOutcome::end))
            }
            outcome if self.options.beyond == Virtual::Stop => {
                let from = points.last().unwrap_or(first);
                self.through_touches(from, outcome?, length)
            }
            outcome => outcome,
        }
    }

    fn tangent<'p>(&self, own: &'p AcceptedPoint) -> &'p BranchDirection {
        &own.tangent
    }

    fn home_from(
        &self,
        first: &AcceptedPoint,
        own: &AcceptedPoint,
    ) -> (ParametricLoop, BranchDirection) {
        if !self.is_at_home() {
            // Motions with other instants are far.
            let away = BranchDirection::of_value(0).scaled(f64::INFINITY);
            return (first.place.clone(), away);
        }
        let turns = self.problem.turns(&first.place, &own.place);
        let begun = first.place.turned(turns);
        let home = self.problem.between(&begun, &own.place);
        (begun, home)
    }

    fn kept(&mut self, own: AcceptedPoint) -> Result<AcceptedPoint> {
        rescaled(&mut self.problem, own)
    }

    fn ended(&self, own: &AcceptedPoint) -> Result<Option<(Option<Special>, BranchEnd)>> {
        if let Some((end, met)) = ended(&self.problem, own)? {
            return Ok(Some((met, end)));
        }
        // A step that ended at a boundary before has not reached the end of the range.
        let reached = self.reached.filter(|&end| end == own.place.value);
        Ok(reached.map(|end| (None, at_end(end))))
    }

    fn closed(
        &self,
        from: &AcceptedPoint,
        (first, place): (&AcceptedPoint, ParametricLoop),
        _: Vec<Special>,
    ) -> Result<(AcceptedPoint, Vec<Special>)> {
        let chord = self.problem.between(&from.place, &place);
        let last = AcceptedPoint {
            arclength: from.arclength + chord.length(),
            place,
            ..first.clone()
        };
        let special = bifurcations(&self.problem, from, &last, from.tangent.dot(&chord))?;
        Ok((last, special))
    }

    fn refused(
        &self,
        (from, points): (&AcceptedPoint, &[AcceptedPoint]),
        failure: StepFailure,
        length: f64,
    ) -> Result<(Option<Special>, BranchEnd)> {
        let problem = &self.problem;
        let instant = failed_instant(problem, from, &failure);
        let end = failure.end();
        let met = meeting(problem, (from, points), instant, length * problem.span())?;
        let end = match &met {
            Some(_) => BranchEnd::new(EndReason::Boundary, end.detail),
            None => end,
        };
        let end = named(end, met.as_ref());
        Ok((met, end))
    }
}

impl BranchWalk<'_, '_> {
    /// Whether motions have the instants of the first point.
    fn is_at_home(&self) -> bool {
        let [home, here] = [&self.home, &self.problem].map(|own| &own.signature);
        home.stages == here.stages && home.images.is_some() == here.images.is_some()
    }

    /// The outcome of a step of some length that leads to a touch of a stop that gives way: the branch goes on behind it.
    fn through_touches(
        &mut self,
        from: &AcceptedPoint,
        outcome: BranchOutcome,
        length: f64,
    ) -> Result<BranchOutcome> {
        match outcome {
            StepOutcome::End(last, mut special, end) => {
                let touch = special.last_mut().filter(|own| is_passed(own));
                let passed = touch.map_or(Ok(None), |own| onto_contact(&self.problem, own))?;
                let Some(passed) = passed else {
                    return Ok(StepOutcome::End(last, special, end));
                };
                let first = if let Some(last) = last {
                    self.passed = Some(passed);
                    last
                } else {
                    self.problem = passed.problem;
                    Box::new(passed.point)
                };
                Ok(StepOutcome::Accepted(first, special, 1.0))
            }
            StepOutcome::Refused(failure) => {
                let Some((special, passed)) = off_contact(&self.problem, from, length)? else {
                    return Ok(StepOutcome::Refused(failure));
                };
                if !is_passed(&special) {
                    let value = digits(special.parameter);
                    let detail = format!("at {value} a contact has no duration");
                    let end = BranchEnd::new(EndReason::Boundary, detail);
                    let end = named(end, Some(&special));
                    return Ok(StepOutcome::End(None, vec![special], end));
                }
                self.problem = passed.problem;
                Ok(StepOutcome::Accepted(
                    Box::new(passed.point),
                    vec![special],
                    1.0,
                ))
            }
            outcome => Ok(outcome),
        }
    }

    /// Replaces the loops of half a period by whole ones from the last point on; the end of the branch where these have no tangent.
    fn go_on_whole(
        &mut self,
        first: &mut AcceptedPoint,
        points: &mut [AcceptedPoint],
    ) -> Result<Option<BranchEnd>> {
        let from = points.last().unwrap_or(first);
        let Some((whole, there)) = unfolded(&self.problem, from)? else {
            let value = from.place.value;
            return Ok(Some(StepFailure::NotOdd { value }.end()));
        };
        if let Some((home, begun)) = unfolded(&self.home, first)? {
            (self.home, *first) = (home, begun);
        }
        self.problem = whole;
        if let Some(last) = points.last_mut() {
            *last = there;
        }
        Ok(None)
    }
}

/// The instant whose flight or stick has no duration left, if that is why the corrector failed.
fn failed_instant(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    failure: &StepFailure,
) -> Option<usize> {
    match failure {
        StepFailure::Met { instant, .. } => Some(*instant),
        StepFailure::NoRest { .. } => problem.last_stick(&from.place),
        StepFailure::Stalled { .. }
        | StepFailure::NotOdd { .. }
        | StepFailure::NoScene(_)
        | StepFailure::Distrusted(_) => None,
    }
}

/// A point of half a period as one of the whole, and its problem; none where that has no tangent.
fn unfolded<'a>(
    problem: &BranchProblem<'a>,
    own: &AcceptedPoint,
) -> Result<Option<(BranchProblem<'a>, AcceptedPoint)>> {
    let (whole, place) = problem.whole(&own.place)?;
    let equations = whole.equations(&place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    // The first state, the instants of the first half and the parameter are the unknowns of the half.
    let unknowns = tangent.loop_part.len();
    let mut half = own.tangent.clone();
    half.loop_part = half.loop_part.resize_vertically(unknowns, 0.0);
    let side = tangent.dot(&half).signum();
    let tangent = tangent.scaled(side);
    let test_values = TestFunctionValues::at(&whole, (&place, &equations, &tangent), &own.orbit)?;
    let point = AcceptedPoint {
        place,
        equations,
        tangent,
        test_values,
        ..own.clone()
    };
    Ok(Some((whole, point)))
}

/// A point in units that fit it: the problem takes those of the point where the motion has outgrown its units.
fn rescaled(problem: &mut BranchProblem<'_>, own: AcceptedPoint) -> Result<AcceptedPoint> {
    if problem.size(&own.place.state) <= OUTGROWN_UNITS {
        return Ok(own);
    }
    let there = problem.in_units_of(&own.place)?;
    let unit = |of: &BranchProblem<'_>, i: usize| of.unit_before_times(&own.place, i);
    let mut border = own.tangent.clone();
    for i in 0..own.place.before_times().len() {
        border.loop_part[i] /= unit(&there, i) / unit(problem, i);
    }
    let equations = there.equations(&own.place)?;
    let Some(tangent) = tangent(&equations, &border) else {
        return Ok(own);
    };
    *problem = there;
    Ok(AcceptedPoint {
        equations,
        tangent,
        ..own
    })
}

/// The end of a branch that the observer interrupts.
fn broken_off(at: &AcceptedPoint) -> BranchEnd {
    let detail = format!("broken off at {}", digits(at.place.value));
    BranchEnd::new(EndReason::Interrupted, detail)
}

/// The end of a branch at an end of its range.
fn at_end(value: f64) -> BranchEnd {
    let detail = format!("the range ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

/// The end of the range, if a step goes there or beyond.
fn reaches(problem: &BranchProblem<'_>, from: &AcceptedPoint, step: f64) -> Option<f64> {
    let (low, high) = problem.range;
    let ahead = from.place.value + step * from.tangent.value_part * problem.span();
    if ahead >= high {
        Some(high)
    } else if ahead <= low {
        Some(low)
    } else {
        None
    }
}

//! Points of a curve at which a second thing happens (codimension two): zeros of test functions, cusps, and rules of contact that begin to
//! be broken (theory 20).

use crate::branch::curve::condition::Condition;
use crate::branch::curve::point::{AcceptedCurvePoint, test_values};
use crate::branch::curve::predictor::chord;
use crate::branch::curve::problem::CurveProblem;
use crate::branch::curve::result::CurvePoint;
use crate::branch::curve::zero_problem::CorrectedCurvePoint;
use crate::branch::special::{SpecialKind, breach_kind};
use crate::continuation::{
    ChangeBracket, ScaledDirection, evaluated, locate_change, locate_zero, stepped,
};
use crate::error::Result;
use crate::orbit::{Breach, Rule};
use crate::tolerance::{
    BRANCH_BOUNDARY_LENGTH, CUSP_RATE, RESONANT_GRAZE_SPEED, SAME_CURVE_POINT, SHALLOW_PASSAGE,
    TEST_FUNCTION_JUMP,
};

/// A step of a curve from a point to another.
struct CurveStep<'a> {
    plane: &'a CurveProblem<'a>,
    from: &'a AcceptedCurvePoint,
    to: &'a AcceptedCurvePoint,
    length: f64,
}

/// A point of a step, its arclength on the step, and the errors of both numbers.
type CurveZero = (CorrectedCurvePoint, f64, [f64; 2]);

/// The codimension-two points on a step, in their order, each with its corrected point.
pub(super) fn passed(
    plane: &CurveProblem<'_>,
    from: &AcceptedCurvePoint,
    to: &AcceptedCurvePoint,
) -> Result<Vec<(CurvePoint, CorrectedCurvePoint)>> {
    let step = CurveStep {
        plane,
        from,
        to,
        length: chord(plane, &from.found.iterate, &to.found.iterate).length(),
    };
    let mut found = Vec::new();
    for (k, (kind, after)) in to.test_values.iter().enumerate() {
        let before = from.test_values[k].1;
        if before * after >= 0.0 {
            continue;
        }
        let value = |there: &CorrectedCurvePoint| Ok(test_values(plane, there)?[k].1);
        let there = step.zero([before, *after], &value)?;
        // Where an impact has no speed all determinants vanish, and no multipliers meet.
        let is_graze = |(other, own): &(&str, f64)| {
            *other == "resonant_graze" && own.abs() < RESONANT_GRAZE_SPEED
        };
        let at = test_values(plane, &there.0)?;
        let is_of_multipliers = *kind == "fold_flip" || kind.starts_with("strong");
        // A jump is no zero: another pair of multipliers is the nearest to the circle from there on.
        let is_jump = at[k].1.abs() > TEST_FUNCTION_JUMP * before.abs().max(after.abs());
        if is_jump || is_of_multipliers && at.iter().any(is_graze) {
            continue;
        }
        found.push(step.special(kind, there)?);
    }
    found.extend(step.cusp()?);
    if from.is_virtual != to.is_virtual {
        let broken = step.broken()?;
        let off = |own: &CurvePoint, other: &CurvePoint| (own.arclength - other.arclength).abs();
        let is_known = |own: &(CurvePoint, CorrectedCurvePoint)| {
            let is_other = |(other, _): &(CurvePoint, CorrectedCurvePoint)| {
                off(&own.0, other) > SAME_CURVE_POINT
            };
            !found.iter().all(is_other)
        };
        let new = broken.filter(|own| !is_known(own));
        found.extend(new);
    }
    found.sort_by(|(a, _), (b, _)| a.arclength.total_cmp(&b.arclength));
    Ok(found)
}

impl CurveStep<'_> {
    /// The zero of a test function with the given values at both ends; the end of the step if it is not located.
    fn zero(
        &self,
        [before, after]: [f64; 2],
        value: &dyn Fn(&CorrectedCurvePoint) -> Result<f64>,
    ) -> Result<CurveZero> {
        let mut point = |along: f64| {
            evaluated(self.plane, self.from.found.base(), along, |there| {
                Ok(Some((along, value(there)?)))
            })
        };
        let zero = locate_zero([self.length, before, after], 1.0, &mut point)?;
        let (found, along, error) = match zero {
            Some(zero) => (zero.point, zero.along, zero.error),
            None => (self.to.found.clone(), self.length, self.length),
        };
        // The errors of both numbers follow from the error in arclength by their rates along the step.
        let tangents = [&self.from.found.tangent, &found.tangent];
        let rates = tangents.map(|tangent| tangent.numbers().abs());
        let rates = rates[0].sup(&rates[1]);
        let known = |axis: usize| error * rates[axis] * self.plane.span(axis);
        Ok((found, along, [known(0), known(1)]))
    }

    /// A point of a kind, at a located zero.
    fn special(
        &self,
        kind: &'static str,
        there: CurveZero,
    ) -> Result<(CurvePoint, CorrectedCurvePoint)> {
        let (found, along, error) = there;
        let special = CurvePoint {
            kind,
            parameters: [found.iterate.place.value, found.iterate.second],
            error,
            arclength: self.from.arclength + along,
            orbit: self.plane.orbit(&found.iterate)?,
        };
        Ok((special, found))
    }

    /// The cusp on the step, where two folds meet: both numbers stand still there, and go back.
    fn cusp(&self) -> Result<Option<(CurvePoint, CorrectedCurvePoint)>> {
        let before = self.from.found.tangent.numbers();
        let after = self.to.found.tangent.numbers();
        if self.plane.condition != Condition::Multiplier(1.0) || before.dot(&after) >= 0.0 {
            return Ok(None);
        }
        let direction = before.normalize();
        let value = |there: &CorrectedCurvePoint| Ok(there.tangent.numbers().dot(&direction));
        let there = self.zero([before.norm(), after.dot(&direction)], &value)?;
        let left = there.0.tangent.numbers().norm();
        if left > CUSP_RATE * before.norm().max(after.norm()) {
            return Ok(None);
        }
        self.special("cusp", there).map(Some)
    }

    /// The point on the step at which orbits begin to break a rule of contact, or cease to; its kind is that of the boundary.
    fn broken(&self) -> Result<Option<(CurvePoint, CorrectedCurvePoint)>> {
        let plane = self.plane;
        let beyond = if self.from.is_virtual {
            self.from
        } else {
            self.to
        };
        // Where an orbit consists of rounds of a shorter one that touches a stop, passages by rounding are no breach.
        let breach = plane.judged(&beyond.found.iterate)?.breach();
        let is_passed = |own: &Breach| own.rule == Rule::Passed;
        if breach.is_some_and(|own| {
            is_passed(&own) && own.depth <= SHALLOW_PASSAGE * plane.units.position
        }) {
            return Ok(None);
        }
        let mut aim =
            |own: &ChangeBracket<CorrectedCurvePoint>| Ok(0.5 * (own.ends[0] + own.ends[1]));
        let mut at = |along: f64| {
            let Ok(there) = stepped(plane, self.from.found.base(), along)? else {
                return Ok(None);
            };
            let orbit = plane.orbit(&there.iterate)?;
            let is_before = plane.is_virtual(&there.iterate, &orbit)? == self.from.is_virtual;
            Ok(Some((there, is_before)))
        };
        let bracket = locate_change(self.length, BRANCH_BOUNDARY_LENGTH, &mut aim, &mut at)?;
        let [before, after] = bracket.points;
        let before = before.unwrap_or_else(|| self.from.found.clone());
        let after = after.unwrap_or_else(|| self.to.found.clone());
        let (kept, broken) = if self.from.is_virtual {
            (&after, &before)
        } else {
            (&before, &after)
        };
        let (kept, broken) = (plane.judged(&kept.iterate)?, plane.judged(&broken.iterate)?);
        let Some(breach) = breach_kind(&broken, &kept, plane.units.velocity) else {
            return Ok(None);
        };
        let kind = match (plane.condition, breach.kind) {
            (Condition::NoSpeed(_), SpecialKind::Graze) => "double_graze",
            (Condition::NoSpeed(_), SpecialKind::Corner)
            | (Condition::Together, SpecialKind::Graze) => "graze_corner",
            (_, kind) => kind.name(),
        };
        let off = |a: f64, b: f64| (a - b).abs();
        let error = [
            off(before.iterate.place.value, after.iterate.place.value),
            off(before.iterate.second, after.iterate.second),
        ];
        self.special(kind, (before, bracket.ends[0], error))
            .map(Some)
    }
}

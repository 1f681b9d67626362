//! Where something else happens on a curve too.

use crate::branch::curve::condition::Condition;
use crate::branch::curve::corrector::{Found, length, weighted};
use crate::branch::curve::one::CurvePoint;
use crate::branch::curve::plane::Plane;
use crate::branch::curve::point::{Point, indicators};
use crate::branch::curve::step::{chord, stepped};
use crate::branch::special::{SpecialKind, breach_kind};
use crate::branch::zero::{Tried, zero_between};
use crate::error::Result;
use crate::orbit::{Breach, Rule};
use nalgebra::{DVector, Vector2};

/// An impact of so small a part of the unit of velocities has no speed.
const NO_SPEED: f64 = 1e-5;
/// A number that is no smaller than this part of what it is beside jumps.
const JUMP: f64 = 1e-2;
/// A curve has a cusp where its numbers change by no more than this part of what they do beside it.
const STANDS: f64 = 1e-4;
/// A rule is broken where something else happens if that is no farther along the curve.
const AT_ONCE: f64 = 1e-6;
/// A stop that is passed by no more than this part of the unit of positions is not seen to be.
const SHALLOW: f64 = 1e-10;
/// A change of a rule is known when it lies between points no farther apart than this, in arclength.
const KNOWN: f64 = 1e-11;
const MOST_HALVINGS: usize = 60;

/// A step of a curve from a point to another.
struct Step<'a> {
    plane: &'a Plane<'a>,
    from: &'a Point,
    to: &'a Point,
    length: f64,
}

/// A point of a step: what is there, how far along it is, how far both numbers are known.
type There = (Found, f64, [f64; 2]);

/// What else happens on a step, and the points.
pub(super) fn passed(
    plane: &Plane<'_>,
    from: &Point,
    to: &Point,
) -> Result<Vec<(CurvePoint, Found)>> {
    let step = Step {
        plane,
        from,
        to,
        length: length(&chord(plane, &from.found.spot, &to.found.spot)),
    };
    let mut found = Vec::new();
    for (k, (kind, after)) in to.indicators.iter().enumerate() {
        let before = from.indicators[k].1;
        if before * after >= 0.0 {
            continue;
        }
        let value = |there: &Found| Ok(indicators(plane, there)?[k].1);
        let there = step.zero([before, *after], &value)?;
        // Where an impact has no speed all determinants vanish, and no multipliers meet.
        let is_graze =
            |(other, own): &(&str, f64)| *other == "resonant_graze" && own.abs() < NO_SPEED;
        let at = indicators(plane, &there.0)?;
        let is_of_multipliers = *kind == "fold_flip" || kind.starts_with("strong");
        // Nor is it a zero where another pair is the nearest to the circle from there on.
        let is_jump = at[k].1.abs() > JUMP * before.abs().max(after.abs());
        if is_jump || is_of_multipliers && at.iter().any(is_graze) {
            continue;
        }
        found.push(step.special(kind, there)?);
    }
    found.extend(step.cusp()?);
    if from.is_virtual != to.is_virtual {
        let broken = step.broken()?;
        let off = |own: &CurvePoint, other: &CurvePoint| (own.arclength - other.arclength).abs();
        let is_known = |own: &(CurvePoint, Found)| {
            let is_other = |(other, _): &(CurvePoint, Found)| off(&own.0, other) > AT_ONCE;
            !found.iter().all(is_other)
        };
        let new = broken.filter(|own| !is_known(own));
        found.extend(new);
    }
    found.sort_by(|(a, _), (b, _)| a.arclength.total_cmp(&b.arclength));
    Ok(found)
}

/// How the numbers change along a curve.
fn of_numbers(tangent: &DVector<f64>) -> Vector2<f64> {
    let last = tangent.len() - 1;
    Vector2::new(tangent[last - 1], tangent[last])
}

impl Step<'_> {
    /// A point on the step, if the curve is reached there.
    fn at(&self, along: f64) -> Result<Option<Found>> {
        let (from, normal) = (&self.from.found, &weighted(&self.from.found.tangent));
        Ok(stepped(self.plane, from, &from.tangent, along, normal)?.ok())
    }

    /// Where a number is zero that has these values at the ends.
    fn zero(
        &self,
        [before, after]: [f64; 2],
        value: &dyn Fn(&Found) -> Result<f64>,
    ) -> Result<There> {
        let mut point = |along: f64| {
            let Some(there) = self.at(along)? else {
                return Ok(None);
            };
            Ok(Some(Tried {
                parameter: along,
                value: value(&there)?,
                point: there,
            }))
        };
        let zero = zero_between([self.length, before, after], 1.0, &mut point)?;
        let (found, along, error) = match zero {
            Some(zero) => (zero.point, zero.along, zero.error),
            None => (self.to.found.clone(), self.length, self.length),
        };
        // By the numbers' rates along the step.
        let tangents = [&self.from.found.tangent, &found.tangent];
        let rates = tangents.map(|tangent| of_numbers(tangent).abs());
        let rates = rates[0].sup(&rates[1]);
        let known = |axis: usize| error * rates[axis] * self.plane.span(axis);
        Ok((found, along, [known(0), known(1)]))
    }

    fn special(&self, kind: &'static str, there: There) -> Result<(CurvePoint, Found)> {
        let (found, along, error) = there;
        let special = CurvePoint {
            kind,
            parameters: [found.spot.place.value, found.spot.second],
            error,
            arclength: self.from.arclength + along,
            orbit: self.plane.orbit(&found.spot)?,
        };
        Ok((special, found))
    }

    /// Where two folds meet: both numbers stand still there, and go back.
    fn cusp(&self) -> Result<Option<(CurvePoint, Found)>> {
        let before = of_numbers(&self.from.found.tangent);
        let after = of_numbers(&self.to.found.tangent);
        if self.plane.condition != Condition::Multiplier(1.0) || before.dot(&after) >= 0.0 {
            return Ok(None);
        }
        let way = before.normalize();
        let value = |there: &Found| Ok(of_numbers(&there.tangent).dot(&way));
        let there = self.zero([before.norm(), after.dot(&way)], &value)?;
        let left = of_numbers(&there.0.tangent).norm();
        if left > STANDS * before.norm().max(after.norm()) {
            return Ok(None);
        }
        self.special("cusp", there).map(Some)
    }

    /// Where its motions come to break a rule of contact, or to keep it; named by the boundary that is met.
    fn broken(&self) -> Result<Option<(CurvePoint, Found)>> {
        let plane = self.plane;
        let beyond = if self.from.is_virtual {
            self.from
        } else {
            self.to
        };
        // Along orbits that touch a stop in every round of a shorter one, what is passed is rounding.
        let breach = plane.judged(&beyond.found.spot)?.breach();
        let is_passed = |own: &Breach| own.rule == Rule::Passed;
        if breach.is_some_and(|own| is_passed(&own) && own.depth <= SHALLOW * plane.units.position)
        {
            return Ok(None);
        }
        let (mut low, mut high) = (0.0, self.length);
        let (mut before, mut behind) = (self.from.found.clone(), self.to.found.clone());
        for _ in 0..MOST_HALVINGS {
            if high - low <= KNOWN {
                break;
            }
            let middle = 0.5 * (low + high);
            let Some(there) = self.at(middle)? else {
                break;
            };
            let orbit = plane.orbit(&there.spot)?;
            if plane.is_virtual(&there.spot, &orbit)? == self.from.is_virtual {
                (low, before) = (middle, there);
            } else {
                (high, behind) = (middle, there);
            }
        }
        let (kept, broken) = if self.from.is_virtual {
            (&behind, &before)
        } else {
            (&before, &behind)
        };
        let (kept, broken) = (plane.judged(&kept.spot)?, plane.judged(&broken.spot)?);
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
            off(before.spot.place.value, behind.spot.place.value),
            off(before.spot.second, behind.spot.second),
        ];
        self.special(kind, (before, low, error)).map(Some)
    }
}

//! Borders that are extrapolated by a power law: where lasting contact has no duration left, and where the impacts that accumulate before
//! it have no speed left (theory 19, "Chatter border", "Vanishing impacts"). Values are of the parameter, in its unit.

use crate::branch::predictor::AcceptedPoint;
use crate::branch::problem::BranchProblem;
use crate::error::Result;
use crate::orbit::with_maps;
use crate::root::{Bracket, bisected};
use crate::tolerance::{
    EXTRAPOLATION_ERROR, KNOWN_IMPACT_SPEED, KNOWN_STICK, VANISHING_IMPACT_SPEED,
    VANISHING_IMPACT_STICK,
};
use nalgebra::{Matrix3, Vector3};
use std::convert::Infallible;

/// The time from the first of the impacts that vanish to their end goes like the root of their speed, and the distance from where they
/// vanish like the cube of that time. `[exact]`
const VANISHING_POWER: f64 = 3.0;

/// Bounces near a release that just come to rest. They are alike in all scales; their speeds are those of the unstable fixed point of their
/// map.
pub(super) struct CriticalBounces {
    /// The factor by which a deviation from them grows at a bounce \[-\].
    pub growth: f64,
    /// The power of the distance from the border by which the duration of a stick goes \[-\].
    pub power: f64,
}

impl CriticalBounces {
    /// The bounces of a restitution in (0, 1).
    pub fn of(restitution: f64) -> Self {
        let e = restitution;
        let off = |s: f64| e * (3.0 - 2.0 * s) - (1.0 - s) * (1.0 - s) * (3.0 - s);
        let between = Bracket::new([0.0, 1.0]);
        let Ok(found) = bisected(between, 0.0, |s| Ok::<_, Infallible>(off(s) < 0.0));
        let s = found.middle();
        // Derivatives of the next speed e (s/2 - s^2/3)/(1 - s)^2 and of this one, s/2 - s^2/6, by s.
        let next = e
            * ((0.5 - 2.0 * s / 3.0) / (1.0 - s).powi(2)
                + 2.0 * (0.5 * s - s * s / 3.0) / (1.0 - s).powi(3));
        let growth = next / (0.5 - s / 3.0);
        Self {
            growth,
            power: -(1.0 - s).ln() / growth.ln(),
        }
    }
}

/// The value at which the stick of an instant has no duration, and how far that is known, from the last points whose stick is long enough:
/// the value is `p_b + (a + b tau) tau^(1/nu)` of a stick tau. None for a stop that is not reached by chatter.
pub(super) fn border(
    problem: &BranchProblem<'_>,
    points: &[AcceptedPoint],
    instant: usize,
) -> Result<Option<(f64, f64)>> {
    let accumulation = problem.signature.stages.accumulation(instant);
    let (Some(stop), Some(last)) = (accumulation, points.last()) else {
        return Ok(None);
    };
    let scene = problem.scene(last.place.value)?;
    let restitution = with_maps(&scene, &problem.signature, |motion| {
        Ok(motion.law(stop).restitution)
    })?;
    let inverse = CriticalBounces::of(restitution).power.recip();
    let stick = |point: &AcceptedPoint| {
        let state = &point.place.state;
        let whole = state.times[state.states.len()] - state.times[0];
        let tau = (state.times[instant + 1] - state.starts[instant]) / whole;
        (tau > KNOWN_STICK).then_some((tau, point.place.value))
    };
    let known = points.iter().rev().filter_map(stick);
    Ok(extrapolated(known, inverse, problem.span()))
}

/// The value at which all impacts of the period have lost their speed at once, and its error, extrapolated from the last points: it is
/// `p_v + (a + b theta) theta^3`, theta the root of the speed of the fastest impact. None where impacts are faster, do not accumulate, or
/// vanish together with the contact after them.
pub(super) fn vanishing(
    problem: &BranchProblem<'_>,
    points: &[AcceptedPoint],
) -> Option<(f64, f64)> {
    let fastest = |point: &AcceptedPoint| {
        let each = point.orbit.impacts().iter().map(|impact| impact.approach);
        each.fold(0.0, f64::max) / problem.units.velocity
    };
    let last = points.last()?;
    let state = &last.place.state;
    let whole = state.times[state.states.len()] - state.times[0];
    let stages = &problem.signature.stages;
    let chatters = (0..stages.len()).filter(|&k| stages.accumulation(k).is_some());
    let stick = |k: usize| (state.times[k + 1] - state.starts[k]) / whole;
    let shortest = chatters.map(stick).reduce(f64::min)?;
    let slower = points.iter().rev().map(fastest).take(2);
    if !(shortest > VANISHING_IMPACT_STICK
        && fastest(last) <= VANISHING_IMPACT_SPEED
        && slower.is_sorted())
    {
        return None;
    }
    let root = |point: &AcceptedPoint| {
        let speed = fastest(point);
        (speed > KNOWN_IMPACT_SPEED).then_some((speed.sqrt(), point.place.value))
    };
    let known = points.iter().rev().filter_map(root);
    extrapolated(known, VANISHING_POWER, problem.span())
}

/// The limit p of values `p + (a + b x) x^power` as x goes to zero, by the first three, and how far it is known: by how much b changes it.
fn extrapolated(
    mut known: impl Iterator<Item = (f64, f64)>,
    power: f64,
    span: f64,
) -> Option<(f64, f64)> {
    let all = [known.next()?, known.next()?, known.next()?];
    let row = |(x, _): (f64, f64)| [1.0, x.powf(power), x.powf(1.0 + power)];
    let matrix = Matrix3::from_fn(|i, j| row(all[i])[j]);
    let values = Vector3::from_fn(|i, _| all[i].1);
    let found = matrix.lu().solve(&values)?;
    let (x, y) = (row(all[0])[1], row(all[1])[1]);
    let without = (all[0].1 * y - all[1].1 * x) / (y - x);
    let error = (found[0] - without).abs().max(EXTRAPOLATION_ERROR * span);
    Some((found[0], error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_continued_to_its_limit() {
        let law = |x: f64| (x, 0.7 + (0.3 - 0.2 * x) * x.powf(1.66));
        let (limit, error) =
            extrapolated([0.01, 0.02, 0.05].map(law).into_iter(), 1.66, 1.0).expect("three");
        assert!((limit - 0.7).abs() < 1e-14, "{limit}");
        assert!((1e-6..1e-4).contains(&error), "{error:e}");
        assert!(extrapolated([0.01, 0.02].map(law).into_iter(), 1.66, 1.0).is_none());
    }
}

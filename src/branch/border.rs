//! Where lasting contact has no duration left, and where impacts that accumulate before it have no speed left (theory 19, "Chatter border",
//! "Vanishing impacts").

use crate::branch::family::Family;
use crate::branch::step::Point;
use crate::error::Result;
use crate::orbit::{Event, with_shooting};
use nalgebra::{Matrix3, Vector3};

/// A stick shorter than this part of the period has the rounding of its chatter's completion in it.
const SHORT: f64 = 1e-4;
/// A border is known no better than this part of the range.
const KNOWN: f64 = 3e-9;
/// Impacts vanish if the fastest one has no more than this part of the unit of velocities, and the contact behind them lasts for this part of
/// the period at least.
const SLOW: f64 = 0.02;
const LASTING: f64 = 0.01;
/// The time from their first one to their end goes like the root of their speed, and the distance from where they vanish like its cube.
const POWER: f64 = 3.0;
/// Speeds below this part of the unit of velocities are not known to enough digits.
const KNOWN_SPEED: f64 = 1e-7;
/// Halvings of an interval down to neighbouring doubles.
const HALVINGS: usize = 60;

/// Bounces near a release that just come to rest: they are alike in all scales, and these are those of the unstable fixed point of their
/// map.
pub(super) struct Bounces {
    /// The factor by which deviations from them grow at a bounce.
    pub growth: f64,
    /// The power with which a stick grows with the distance from the border.
    pub power: f64,
}

impl Bounces {
    /// Those of a restitution in (0, 1).
    pub fn of(restitution: f64) -> Self {
        let e = restitution;
        let off = |s: f64| e * (3.0 - 2.0 * s) - (1.0 - s) * (1.0 - s) * (3.0 - s);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if off(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let s = 0.5 * (low + high);
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
/// the value is `p_b + (a + b tau) tau^(1/nu)` of a stick tau. None of a stop that is not reached by chatter.
pub(super) fn border(
    family: &Family<'_>,
    points: &[Point],
    instant: usize,
) -> Result<Option<(f64, f64)>> {
    let stage = &family.signature.stages[instant];
    let (Event::Chatter(stop), Some(last)) = (&stage.event, points.last()) else {
        return Ok(None);
    };
    let scene = family.scene(last.place.value)?;
    let restitution = with_shooting(&scene, &family.signature, |shooting, _| {
        Ok(shooting.motion.restitution(*stop))
    })?;
    let inverse = Bounces::of(restitution).power.recip();
    let stick = |point: &Point| {
        let state = &point.place.state;
        let whole = state.times[state.states.len()] - state.times[0];
        let tau = (state.times[instant + 1] - state.starts[instant]) / whole;
        (tau > SHORT).then_some((tau, point.place.value))
    };
    let known = points.iter().rev().filter_map(stick);
    Ok(extrapolated(known, inverse, family.span()))
}

/// The value at which all impacts of the period have lost their speed at once, and how far that is known, from the last points: it is
/// `p_v + (a + b theta) theta^3`, theta the root of the speed of the fastest impact. None where impacts are faster, do not accumulate, or come to
/// nothing with the contact behind them.
pub(super) fn vanishing(family: &Family<'_>, points: &[Point]) -> Option<(f64, f64)> {
    let fastest = |point: &Point| {
        let each = point.orbit.impacts().iter().map(|impact| impact.approach);
        each.fold(0.0, f64::max) / family.units.velocity
    };
    let last = points.last()?;
    let state = &last.place.state;
    let whole = state.times[state.states.len()] - state.times[0];
    let stages = family.signature.stages.iter().enumerate();
    let chatters = stages.filter(|(_, stage)| matches!(stage.event, Event::Chatter(_)));
    let stick = |k: usize| (state.times[k + 1] - state.starts[k]) / whole;
    let shortest = chatters.map(|(k, _)| stick(k)).reduce(f64::min)?;
    let slower = points.iter().rev().map(fastest).take(2);
    if !(shortest > LASTING && fastest(last) <= SLOW && slower.is_sorted()) {
        return None;
    }
    let root = |point: &Point| {
        let speed = fastest(point);
        (speed > KNOWN_SPEED).then_some((speed.sqrt(), point.place.value))
    };
    let known = points.iter().rev().filter_map(root);
    extrapolated(known, POWER, family.span())
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
    let error = (found[0] - without).abs().max(KNOWN * span);
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

//! Where lasting contact has no duration left (theory 19, "Chatter border").

use crate::branch::family::Family;
use crate::branch::step::Point;
use crate::error::Result;
use crate::orbit::{Event, with_shooting};
use nalgebra::{Matrix3, Vector3};

/// A stick shorter than this part of the period has the rounding of its chatter's completion in it.
const SHORT: f64 = 1e-4;
/// A border is known no better than this part of the range.
const KNOWN: f64 = 3e-9;
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
    let mut known = points.iter().rev().filter_map(stick);
    let (Some(one), Some(two), Some(three)) = (known.next(), known.next(), known.next()) else {
        return Ok(None);
    };
    let all = [one, two, three];
    let row = |(tau, _): (f64, f64)| [1.0, tau.powf(inverse), tau.powf(1.0 + inverse)];
    let matrix = Matrix3::from_fn(|i, j| row(all[i])[j]);
    let values = Vector3::from_fn(|i, _| all[i].1);
    let Some(found) = matrix.lu().solve(&values) else {
        return Ok(None);
    };
    let (x, y) = (row(one)[1], row(two)[1]);
    let without = (one.1 * y - two.1 * x) / (y - x);
    let error = (found[0] - without).abs().max(KNOWN * family.span());
    Ok(Some((found[0], error)))
}

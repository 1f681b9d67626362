//! The phase of the forcing at each impact.

use crate::runs::case::Case;
use crate::runs::compare::Difference;
use crate::runs::double_double::Dd;
use std::f64::consts::{PI, TAU};
use vibroimpact::Trajectory;

/// Roundings of an angle within half a turn of zero: of the time since the last whole turn, its product with the frequency, the sum with
/// the scene's own phase and the way of that to [0, 2 pi).
const ROUNDINGS: f64 = 4.0;

/// Without forcing there is no phase, and zero is written; of several forces without a common period there is none either, and it is no
/// number.
pub fn phases_follow_the_forcing(case: &Case, run: &Trajectory) -> Option<Difference> {
    run.impacts().iter().find_map(|impact| {
        let off = match &case.force {
            None => impact.phase.abs(),
            Some(f) => phase_error(f.frequency, f.phase, impact.time, impact.phase),
        };
        let is_right = if case.more.is_empty() {
            (0.0..TAU).contains(&impact.phase) && off <= allowed(case, impact.time)
        } else {
            impact.phase.is_nan() || (0.0..TAU).contains(&impact.phase)
        };
        (!is_right).then(|| Difference {
            class: "phase of an impact".to_string(),
            detail: format!(
                "{impact:?}, off {off:e} of {:e}",
                allowed(case, impact.time)
            ),
        })
    })
}

/// How far a phase is from `frequency time + own`, whole turns left out.
fn phase_error(frequency: f64, own: f64, time: f64, phase: f64) -> f64 {
    let angle = Dd::from(frequency) * Dd::from(time) + Dd::from(own);
    let (cos, sin) = (angle - Dd::from(phase)).cos_sin();
    sin.to_f64().atan2(cos.to_f64()).abs()
}

/// The motion has its times in twice the precision; the one that is written is off by half a unit of its last place.
fn allowed(case: &Case, time: f64) -> f64 {
    case.force.as_ref().map_or(0.0, |f| {
        let read = 0.5 * f64::EPSILON * f.frequency * time.abs();
        read + ROUNDINGS * f64::EPSILON * (PI + f.phase.abs())
    })
}

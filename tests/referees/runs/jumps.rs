//! What impacts do to the velocity: the impulses of all stops that are hit at one instant, those of stops held among them, make its jump.

use crate::runs::case::Case;
use crate::runs::compare::Difference;
use crate::runs::invariants::{difference, inverse_mass, reaction};
use crate::runs::reference::Reference;
use nalgebra::DVector;
use vibroimpact::{Impact, ImpactSide, Motion, Segment, SegmentKind, Trajectory};

/// Instants nearer to each other than this, in radians of the fastest motion, are too near to tell the sides of each.
const NEAR: f64 = 1e-9;

/// The jump of the velocity at every instant of impacts that is alone.
pub fn impulses_move_the_motion(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    let inverse = inverse_mass(case);
    let tick = 2.0 * f64::EPSILON * case.span.0.abs().max(case.span.1.abs());
    let near = 4.0 * tick + NEAR / reference.model.rate;
    let segments = run.segments().expect("kept");
    let mut before: Option<f64> = None;
    let mut instants = run.impacts().chunk_by(|a, b| a.time == b.time).peekable();
    while let Some(impacts) = instants.next() {
        let time = impacts[0].time;
        let next = instants.peek().map(|next| next[0].time);
        let is_apart = |other: Option<f64>| other.is_none_or(|t| (t - time).abs() > near);
        let last = before.replace(time);
        let is_alone = is_apart(last) && is_apart(next);
        if !is_alone || begins_chatter(&segments, time, near) {
            continue;
        }
        let sides = [ImpactSide::Before, ImpactSide::After].map(|side| run.state(time, side));
        let [Ok((place, into)), Ok((_, out))] = sides else {
            return difference("state refused", format!("{:?}", impacts[0]));
        };
        let pushed = |impact: &Impact| reaction(case, &inverse, impact.stop) * impact.impulse;
        let pushes: Vec<DVector<f64>> = impacts.iter().map(pushed).collect();
        let push = pushes.iter().map(DVector::amax).sum::<f64>();
        let jump = pushes.iter().fold(&out - &into, |left, push| left + push);
        // A time in doubles is off by a tick, and the motion there by as much as it moves; a flight by one matrix exponential is off by
        // rounding times the radians that it turns (N. Higham, SIAM J. Matrix Anal. Appl. 26 (2005) 1179).
        let rate = reference.model.rate;
        let speed = reference.v_unit.max(into.amax());
        let turned = 1.0 + rate * (time - last.unwrap_or(case.span.0));
        let unsteady = 4.0 * tick * rate * speed + f64::EPSILON * rate * turned * place.amax();
        let relative = case.by_method(1e-12, 1e-12 + 10.0 * case.rtol);
        if jump.amax() > relative * speed.max(push) + unsteady {
            return difference(
                "jump of the velocity",
                format!("{:e} left at {impacts:?}", jump.amax()),
            );
        }
    }
    None
}

/// Whether accumulating impacts are completed at a time: what that takes away is no impact's.
pub fn begins_chatter(segments: &[Segment], time: f64, near: f64) -> bool {
    let mut chatters = segments.iter().filter(|s| s.kind == SegmentKind::Chatter);
    chatters.any(|s| (s.start - time).abs() <= near)
}

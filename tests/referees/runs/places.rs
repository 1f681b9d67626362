//! Where the library's answer has its contacts: the gap of a stop is closed where it is struck and as long as it is held, and the
//! segments of a run follow each other from its start to its end.

use crate::runs::case::Case;
use crate::runs::compare::Difference;
use crate::runs::reference::Reference;
use vibroimpact::{ImpactSide, Motion, Segment, SegmentKind, Trajectory};

/// To how many times what a gap is known to its stop is closed.
const ROUNDINGS: f64 = 1e2;

/// Times looked at in each lasting contact.
const POINTS: usize = 8;

fn difference(class: &str, detail: String) -> Difference {
    let class = class.to_string();
    Difference { class, detail }
}

/// The size of the gap of a stop at a time, over what is allowed of one that is closed.
fn openness(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
    (t, stop): (f64, usize),
) -> (f64, f64) {
    let (q, v) = run
        .state(t, ImpactSide::Before)
        .expect("a time of the motion");
    let counting = reference.counting(case);
    let gap = case.stops[stop].gap(q.as_slice());
    let reach = counting.reach(stop);
    // A step knows its positions by the largest of them, which velocities are on their way from or to.
    let swing = case.by_method(0.0, v.amax() / reference.model.rate);
    let terms = counting.size(stop) + reach * (q.amax() + swing + reference.way);
    let relative = case.by_method(4e-15, 10.0 * case.rtol);
    let moved = counting.tick() * reach * v.amax();
    // A start counts as in contact within its tolerance.
    let start = if case.starts_within_tolerance(stop) {
        case.start_tolerance(stop)
    } else {
        0.0
    };
    (gap, ROUNDINGS * relative * terms + moved + start)
}

/// The gap of a stop is closed at its impacts.
pub fn impacts_are_at_stops(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    run.impacts().iter().find_map(|impact| {
        let (gap, allowed) = openness(case, run, reference, (impact.time, impact.stop));
        let detail = || format!("{impact:?}: gap {gap:e}, allowed {allowed:e}");
        (gap.abs() > allowed).then(|| difference("an impact at an open gap", detail()))
    })
}

/// The gap of a stop is closed while it is held; impacts that accumulate end off it by what is left of their gap.
pub fn held_stops_are_closed(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    let segments = run.segments().expect("motion is kept");
    let is_completed = |s: &Segment| s.kind == SegmentKind::Chatter;
    let n_completed = segments.iter().filter(|s| is_completed(s)).count();
    let left = |stop: usize| {
        let size = reference.counting(case).size(stop);
        40.0 * case.rtol.max(1e-14) * size * n_completed.min(1) as f64
    };
    let sticks = segments.iter().filter(|s| s.kind == SegmentKind::Stick);
    sticks
        .filter_map(|s| Some((s, s.stop?)))
        .find_map(|(s, stop)| {
            (1..=POINTS).find_map(|k| {
                let t = s.start + (s.end - s.start) * k as f64 / POINTS as f64;
                let (gap, allowed) = openness(case, run, reference, (t, stop));
                let allowed = allowed + left(stop);
                let detail = || format!("{s:?} at {t:?}: gap {gap:e}, allowed {allowed:e}");
                (gap.abs() > allowed).then(|| difference("held away from a stop", detail()))
            })
        })
}

/// Segments fill the span of a run to the last bit, and each begins where the one before ends.
pub fn segments_fill_the_span(run: &Trajectory) -> Option<Difference> {
    let (start, end) = run.span();
    let segments = run.segments().expect("motion is kept");
    for segment in &segments {
        let is_inside = segment.start >= start.next_down() && segment.end <= end.next_up();
        if !is_inside || segment.end < segment.start {
            let detail = format!("{segment:?} in {:?}", run.span());
            return Some(difference("segment outside the run", detail));
        }
    }
    let ends = segments
        .first()
        .map(|s| s.start)
        .zip(segments.last().map(|s| s.end));
    if ends != Some((start, end)) {
        let detail = format!("{ends:?}");
        return Some(difference("segments that leave something out", detail));
    }
    // Several stops in lasting contact have a row each.
    let follow = |pair: &&[Segment]| pair[1].start != pair[0].end && pair[1].start != pair[0].start;
    let apart = segments.windows(2).find(follow)?;
    Some(difference("segments apart", format!("{apart:?}")))
}

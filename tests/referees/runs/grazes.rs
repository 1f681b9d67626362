//! Touches without impact, against the motion that was kept.

use crate::runs::case::{Case, StopCase};
use crate::runs::compare::Difference;
use crate::runs::hits::Counting;
use crate::runs::reference::Reference;
use nalgebra::DVector;
use vibroimpact::{Graze, ImpactSide, Method, Motion, Segment, SegmentKind, Trajectory};

/// A minimum nearer to zero than this part of its terms is zero to anybody: the library's own rounding is eight times as much.
const ZERO: f64 = 2.0 * f64::EPSILON;
/// Its neighbours are as many times as far away.
const CLEAR: f64 = 1e3;
/// Looks at a gap per radian of the fastest motion, and the most of them in one flight.
const LOOKS: f64 = 4.0;
const MOST_LOOKS: f64 = 4000.0;
/// Flights of so small a part of the fastest motion's time are not looked at.
const SHORT: f64 = 1e-3;
/// Thirds of a stretch left out on the way to its minimum.
const THIRDS: usize = 90;

pub fn grazes_touch(case: &Case, run: &Trajectory, reference: &Reference) -> Option<Difference> {
    let segments = run.segments().expect("motion is kept");
    let counting = reference.counting(case);
    run.grazes().iter().find_map(|graze| {
        let wrong = not_in_flight(graze, run, &segments, &counting).or_else(|| {
            let (q, v) = run.state(graze.time, ImpactSide::After).ok()?;
            // The motion may have grown since the slow simulator ended.
            let grown = Counting {
                q_unit: counting.q_unit.max(q.amax()),
                v_unit: counting.v_unit.max(v.amax()),
                ..reference.counting(case)
            };
            let stop = &case.stops[graze.stop];
            let normal = stop.outward();
            let speed = -normal.iter().zip(v.iter()).map(|(n, v)| n * v).sum::<f64>();
            not_a_touch(graze, stop.gap(q.as_slice()), speed, &grown)
        })?;
        Some(Difference {
            class: format!("graze {}", wrong.0),
            detail: format!("{graze:?} {}", wrong.1),
        })
    })
}

type Wrong = Option<(&'static str, String)>;

/// A touch is in the span, where its stop is neither struck nor held.
fn not_in_flight(
    graze: &Graze,
    run: &Trajectory,
    segments: &[Segment],
    counting: &Counting<'_>,
) -> Wrong {
    let (time, (start, end)) = (graze.time, run.span());
    if !(start..=end).contains(&time) {
        return Some(("outside the run", format!("{:?}", run.span())));
    }
    // Slower than the motion is known an impact is a touch.
    let is_struck = |i: &&vibroimpact::Impact| {
        let is_known = i.approach > counting.speed_floor(i.stop);
        i.stop == graze.stop && i.time == time && is_known
    };
    // Of several events within a few units of the last place of their time nobody knows the order.
    let tick = 4.0 * f64::EPSILON * time.abs();
    let near = run.impacts().iter();
    let is_alone = near.filter(|i| (i.time - time).abs() <= tick).count() < 2;
    if let Some(impact) = run.impacts().iter().find(is_struck).filter(|_| is_alone) {
        return Some(("at an impact", format!("{impact:?}")));
    }
    let is_kept = |s: &&Segment| {
        s.kind != SegmentKind::Flight
            && s.stop == Some(graze.stop)
            && s.start < time
            && time < s.end
    };
    let segment = segments.iter().find(is_kept)?;
    Some(("of a stop in contact", format!("{segment:?}")))
}

/// What is unknown of a gap: the rounding of its terms, those that turn with a fast forcing among them; complex modes, of a body free but
/// for dashpots above all, lose three digits, those of the way that their slowest would go too.
fn known_to(stop: usize, counting: &Counting<'_>) -> f64 {
    let terms = counting.gap_rounding(stop);
    if counting.case.has_real_modes() {
        10.0 * terms
    } else {
        1e3 * (terms + f64::EPSILON * counting.reach(stop) * counting.way)
    }
}

/// The gap is zero as far as it is known, the depth is that of the gap, and the speed such that the gap falls no further.
fn not_a_touch(graze: &Graze, gap: f64, speed: f64, counting: &Counting<'_>) -> Wrong {
    let reach = counting.reach(graze.stop);
    let bend = reach * counting.rate * counting.v_unit.max(counting.rate * counting.q_unit);
    // Half a unit of the last place of its time.
    let tick = 0.5 * f64::EPSILON * graze.time.abs();
    let known = known_to(graze.stop, counting);
    let fall = (4.0 * bend * known).sqrt() + bend * tick;
    let read = tick * (fall + bend * tick);
    if graze.depth.is_nan() || graze.depth.abs() > known {
        return Some(("away from its stop", format!("known to {known:e}")));
    }
    if (gap + graze.depth).abs() > known + read {
        return Some((
            "against the motion",
            format!("gap {gap:e}, known to {known:e}"),
        ));
    }
    (speed.abs() > fall).then(|| ("that moves", format!("at {speed:e}, allowed {fall:e}")))
}

/// Touches of exact flights that the motion shows and the list has not. While stops are held the library knows the gaps of others better
/// than positions in doubles show them.
pub fn grazes_are_listed(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    if case.method != Method::Exact {
        return None;
    }
    let rate = reference.model.rate;
    let segments = run.segments().expect("motion is kept");
    let is_long = |s: &&Segment| (s.end - s.start) * rate > SHORT;
    let flights = (segments.iter()).filter(|s| s.kind == SegmentKind::Flight);
    flights.filter(is_long).find_map(|flight| {
        let looks = Looks::new(run, flight, rate);
        // Of a gap to a stop at zero the terms vanish with it.
        let is_judged = |&stop: &usize| case.stops[stop].clearance != 0.0;
        (0..case.stops.len()).filter(is_judged).find_map(|stop| {
            let is_listed = |time: f64| {
                let mut listed = run.grazes().iter().filter(|g| g.stop == stop);
                listed.any(|g| (g.time - time).abs() <= looks.apart)
            };
            let missed = looks
                .touches(&case.stops[stop])
                .find(|&time| !is_listed(time))?;
            Some(Difference {
                class: "graze missed".to_string(),
                detail: format!("stop {stop} at {missed:?}, {flight:?}"),
            })
        })
    })
}

/// Positions along a part of a run, at times of one distance.
struct Looks<'a> {
    run: &'a Trajectory,
    start: f64,
    apart: f64,
    positions: Vec<DVector<f64>>,
}

impl<'a> Looks<'a> {
    fn new(run: &'a Trajectory, part: &Segment, rate: f64) -> Self {
        let span = part.end - part.start;
        let count = (span * rate * LOOKS).ceil().clamp(4.0, MOST_LOOKS);
        let mut looks = Self {
            run,
            start: part.start,
            apart: span / count,
            positions: Vec::new(),
        };
        let places = (0..=count as usize).map(|k| looks.time(k).min(part.end));
        looks.positions = places.map(|t| position(run, t)).collect();
        looks
    }

    fn time(&self, k: usize) -> f64 {
        self.start + self.apart * k as f64
    }

    /// The times of the minima of a gap that are zero and clear of all else.
    fn touches(&self, stop: &StopCase) -> impl Iterator<Item = f64> {
        let size = 2.0 * stop.clearance.abs();
        let gaps: Vec<f64> = (self.positions.iter())
            .map(|q| stop.gap(q.as_slice()))
            .collect();
        let gap = |t: f64| stop.gap(position(self.run, t).as_slice());
        let is_dip = move |k: &usize| {
            let [before, here, after] = [gaps[k - 1], gaps[*k], gaps[k + 1]];
            let beside = before.min(after);
            here <= beside && beside > CLEAR * ZERO * size
        };
        let dips = (1..self.positions.len() - 1).filter(is_dip);
        dips.map(move |k| lowest(&gap, (self.time(k - 1), self.time(k + 1))))
            .filter(move |&time| gap(time).abs() <= ZERO * size)
    }
}

fn position(run: &Trajectory, time: f64) -> DVector<f64> {
    let state = run.state(time, ImpactSide::After);
    state.expect("inside the span").0
}

/// Where a function of one minimum is lowest.
fn lowest(f: &dyn Fn(f64) -> f64, (mut left, mut right): (f64, f64)) -> f64 {
    for _ in 0..THIRDS {
        let third = (right - left) / 3.0;
        let (a, b) = (left + third, right - third);
        if f(a) <= f(b) {
            right = b;
        } else {
            left = a;
        }
    }
    0.5 * (left + right)
}

//! The ends of accumulating impacts that the library completes, against impacts gone through one by one from where it begins.

use crate::runs::case::{Case, MOST_IMPACTS};
use crate::runs::compare::Difference;
use crate::runs::double_double::{Dd, dot};
use crate::runs::invariants::rounding;
use crate::runs::motion::{Model, Motion};
use crate::runs::record::Stretch;
use crate::runs::reference::Reference;
use crate::runs::simulator::follow;
use vibroimpact::Motion as _;
use vibroimpact::{Impact, ImpactSide, Segment, SegmentKind, Trajectory};

/// A change of the acceleration by more than this part is none of first order.
const MOST_CHANGE: f64 = 0.5;
/// Gaps of this part of their terms are open to anybody.
const OPEN: f64 = 1e-12;
/// How many times the rest of the impacts is waited for.
const PATIENCE: f64 = 4.0;

/// A stop about to be struck by impacts that accumulate: its approach speed, the acceleration that draws it back, how long the
/// impacts take to first order, and to what part of itself that is known.
struct Rest {
    stop: usize,
    speed: f64,
    pull: f64,
    span: f64,
    change: f64,
}

pub fn chatters_end_where_impacts_accumulate(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    let segments = run.segments().expect("motion is kept");
    let chatters = segments.iter().filter(|s| s.kind == SegmentKind::Chatter);
    let mut lasting = chatters.filter(|s| s.end > s.start);
    let beside = |chatter: &Segment| -> Vec<usize> {
        let starts = |s: &&Segment| s.kind == SegmentKind::Stick && s.start == chatter.start;
        segments
            .iter()
            .filter(starts)
            .filter_map(|s| s.stop)
            .collect()
    };
    lasting.find_map(|s| match beside(s).as_slice() {
        [] => judge(case, run, reference, s),
        held => judge_beside(case, run, reference, (s, held)),
    })
}

/// Of impacts beside stops that are held nothing but flights in rounding is left: they take the time of the first order, drawn by what
/// the others leave of the acceleration.
fn judge_beside(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
    (chatter, held): (&Segment, &[usize]),
) -> Option<Difference> {
    let model = &reference.model;
    let stop = chatter.stop?;
    let x = on_stop(model, stop, state(case, run, model, chatter.start));
    let motion = Motion::new(model, held)?;
    let (plane, speed) = (&model.stops[stop], -model.opening(stop, &x));
    let pull = dot(&plane.normal, &motion.acceleration(&x));
    let e = plane.restitution;
    let rest = Rest {
        stop,
        speed: speed.to_f64(),
        pull: pull.to_f64(),
        span: (speed * 2.0 * e / (pull * (1.0 - e))).to_f64(),
        change: 0.0,
    };
    let tick = 4.0 * f64::EPSILON * chatter.start.abs().max(chatter.end.abs());
    let known = tick + known(case, &rest, reference, &x).abs() * rest.span.abs();
    let took = chatter.end - chatter.start;
    let is_cut = chatter.end >= run.span().1;
    let off = if is_cut {
        took - rest.span
    } else {
        (took - rest.span).abs()
    };
    (off.is_nan() || off > known).then(|| Difference {
        class: "span of impacts beside stops that are held".to_string(),
        detail: format!(
            "{chatter:?} beside {held:?}: {off:e} off the first order {:e}, allowed {known:e}",
            rest.span
        ),
    })
}

fn judge(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
    chatter: &Segment,
) -> Option<Difference> {
    let model = &reference.model;
    let stop = chatter.stop?;
    let difference = |class: &str, detail: String| {
        let class = class.to_string();
        let detail = format!("{chatter:?}: {detail}");
        Some(Difference { class, detail })
    };
    // Both ends are sums of doubles.
    let tick = 4.0 * f64::EPSILON * chatter.start.abs().max(chatter.end.abs());
    // With an impact elsewhere within roundings of that time, none of the states there is the one from which it began.
    let elsewhere = |i: &Impact| i.stop != stop && (i.time - chatter.start).abs() <= tick;
    if run.impacts().iter().any(elsewhere) {
        return None;
    }
    let x = on_stop(model, stop, state(case, run, model, chatter.start));
    let rest = Rest::new(model, stop, &x);
    let took = chatter.end - chatter.start;
    let is_cut = chatter.end >= run.span().1;
    let off = |span: f64| {
        if is_cut {
            (took - span).max(0.0)
        } else {
            (took - span).abs()
        }
    };
    let known = tick + known(case, &rest, reference, &x) * rest.span;
    let by_formula = off(rest.span);
    if by_formula.is_nan() || by_formula > known {
        let detail = format!("{by_formula:e} off the first order, allowed {known:e}");
        return difference("span of accumulating impacts", detail);
    }
    // A span that doubles do not show begins at another phase than is read.
    let is_read = rest.span > tick;
    if !is_read || rest.change > MOST_CHANGE || !others_are_open(case, model, stop, &x) {
        return None;
    }
    let duration = Dd::from(PATIENCE * rest.span);
    let slow = follow(model, x, duration, &[], None, MOST_IMPACTS);
    if slow.stopped.is_some() {
        return None;
    }
    let of_stop = |stretches: &[Stretch], end: fn(&Stretch) -> f64| {
        stretches.iter().find(|s| s.stop == stop).map(end)
    };
    // Impacts too slow to rebound at all are the last, too.
    let completed = of_stop(&slow.chatters, |c| c.end);
    let Some(end) = completed.or_else(|| of_stop(&slow.sticks, |s| s.start)) else {
        return difference("impacts that do not accumulate", format!("{slow:?}"));
    };
    let (off, allowed) = (off(end), known + rest.change * rest.span);
    if off.is_nan() || off > allowed {
        let detail = format!("{off:e} off their end {end:e}, allowed {allowed:e}");
        return difference("end of accumulating impacts", detail);
    }
    None
}

/// The library's motion just before a time, in the referee's numbers.
fn state(case: &Case, run: &Trajectory, model: &Model, time: f64) -> Vec<Dd> {
    let (q, v) = run
        .state(time, ImpactSide::Before)
        .expect("inside the span");
    let mut x: Vec<Dd> = q.iter().chain(v.iter()).map(|&x| Dd::from(x)).collect();
    x.extend(model.forcing_at(case, time));
    x
}

/// Whether all other stops are farther away than what the slow simulator takes for contact where it begins.
fn others_are_open(case: &Case, model: &Model, stop: usize, x: &[Dd]) -> bool {
    let q: Vec<f64> = x[..model.n].iter().map(|q| q.abs().to_f64()).collect();
    let size = |normal: &[f64]| normal.iter().zip(&q).map(|(n, q)| n.abs() * q).sum::<f64>();
    let mut others = case.stops.iter().enumerate().filter(|(i, _)| *i != stop);
    others.all(|(i, other)| {
        let size = other.clearance.abs() + size(&other.normal);
        model.gap(i, x).to_f64() > OPEN * size
    })
}

/// A motion at a stop without what rounding has left of its gap.
fn on_stop(model: &Model, stop: usize, mut x: Vec<Dd>) -> Vec<Dd> {
    let plane = &model.stops[stop];
    let left = model.gap(stop, &x) / dot(&plane.normal, &plane.reaction);
    for (q, &b) in x.iter_mut().zip(&plane.reaction) {
        *q += b * left;
    }
    x
}

/// To what part of itself the time of the rest is known: as its speed and acceleration are, beside the motion's own, which may have
/// grown since the slow simulator ended.
fn known(case: &Case, rest: &Rest, reference: &Reference, x: &[Dd]) -> f64 {
    let n = reference.model.n;
    let speeds = x[n..2 * n].iter().map(|v| v.abs().to_f64());
    let size = reference.counting(case).reach(rest.stop) * speeds.fold(reference.v_unit, f64::max);
    rounding(case) * size * (1.0 / rest.speed + reference.model.rate / rest.pull)
}

impl Rest {
    fn new(model: &Model, stop: usize, x: &[Dd]) -> Self {
        let (plane, n) = (&model.stops[stop], model.n);
        let e = plane.restitution;
        let speed = -model.opening(stop, x);
        let acceleration = model.free.times(x);
        let pull = dot(&plane.normal, &acceleration);
        // What the stop gives to speeds with one of its own.
        let give = dot(&plane.normal, &plane.reaction);
        let along: Vec<Dd> = plane.reaction.iter().map(|&b| b / give).collect();
        let span = (speed * 2.0 * e / (pull * (1.0 - e))).to_f64();
        // Meanwhile the motion goes on as if the stop were held, and speeds are off that by the stop's own.
        let part = |x: &[Dd], own: Dd| -> Vec<Dd> {
            x.iter().zip(&along).map(|(&x, &b)| x - b * own).collect()
        };
        let mut rate = part(&x[n..2 * n], speed);
        rate.extend(part(&acceleration, pull));
        rate.extend(model.turning(x));
        let drift = dot(&plane.normal, &model.free.times(&rate)).to_f64().abs() * span;
        // A fast forcing may turn meanwhile.
        let turns = model.frequencies.iter().enumerate().map(|(k, w)| {
            let (mut forcing, place) = (vec![Dd::ZERO; model.size()], 2 * n + 1 + 2 * k);
            forcing[place..place + 2].copy_from_slice(&x[place..place + 2]);
            let forced = dot(&plane.normal, &model.free.times(&forcing));
            0.5 * forced.to_f64().abs() * (w.to_f64() * span).powi(2)
        });
        let turn = turns.sum::<f64>();
        let of_stop = |place: usize| {
            let mut y = vec![Dd::ZERO; model.size()];
            y[place..place + n].copy_from_slice(&along);
            dot(&plane.normal, &model.free.times(&y)).to_f64().abs()
        };
        let (speed, pull) = (speed.to_f64(), pull.to_f64());
        let jolt = of_stop(n) * speed + of_stop(0) * 0.5 * speed * speed / pull;
        Self {
            stop,
            speed,
            pull,
            span,
            // A flight is wrong by its part of the drift, and so is the speed of the next one; what dampers take of the speeds of one
            // flight the next ones lack too.
            change: 2.0 * (drift + turn + jolt / (1.0 - e)) / pull,
        }
    }
}

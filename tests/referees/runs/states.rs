//! States of the library's run beside the referee's, at times between the impacts.

use crate::runs::case::Case;
use crate::runs::compare::{First, biased};
use crate::runs::double_double::Dd;
use crate::runs::record::{Hit, Record};
use crate::runs::reference::{Reference, allowance};
use vibroimpact::{ImpactSide, Motion, Trajectory};

/// What the library saw, and the impacts of the referee that count.
pub struct Sides<'a> {
    pub run: &'a Trajectory,
    pub theirs: &'a Record,
    pub hits: &'a [Hit],
    /// From some times on, what rounding of the gaps has done to speeds.
    pub drifts: &'a [(f64, f64)],
}

/// Positions and velocities up to a time; `completed` is what accumulating impacts that were completed may have cost by a time.
pub fn compare_states(
    case: &Case,
    reference: &Reference,
    sides: &Sides<'_>,
    until: f64,
    completed: &dyn Fn(f64) -> f64,
    first: &mut First,
) {
    let (main, counting) = (&reference.main, reference.counting(case));
    let (tick, slack) = (counting.tick(), counting.slack());
    for (k, &t) in reference.times.iter().enumerate() {
        let since = (Dd::from(t) - Dd::from(case.span.0)).to_f64();
        let is_at =
            |h: &Hit| (h.time.to_f64() - since).abs() <= slack + 10.0 * counting.time_rounding(h);
        let mut chatters = sides.theirs.chatters.iter().chain(&main.chatters);
        let is_beside = sides.hits.iter().any(is_at)
            || chatters.any(|c| since > c.start - slack && since < c.end + slack)
            || (sides.theirs.sticks.iter()).any(|c| (since - c.end).abs() < tick);
        if since >= until || is_beside || k >= main.samples.len() {
            continue;
        }
        let Ok((q, v)) = sides.run.state(t, ImpactSide::After) else {
            first.report(since, "state refused", &format!("at {t:?}"));
            break;
        };
        let x: Vec<f64> = q.iter().chain(v.iter()).copied().collect();
        let off = reference.distance(&main.samples[k], &x);
        let drift = sides
            .drifts
            .iter()
            .rev()
            .find(|d| d.0 <= since)
            .map_or(0.0, |d| d.1);
        let base = allowance(case).base + completed(since) + drift / reference.v_unit;
        // A state is asked for at a double: the motion there goes on by as much in half a unit of its last place.
        let (q, v) = (reference.q_unit, reference.v_unit);
        let fastest = reference.model.rate * (reference.model.rate * q / v).max(1.0);
        let read = f64::EPSILON * t.abs() * fastest;
        let n_impacts = main.hits.partition_point(|h| h.time.to_f64() < since);
        let allowed =
            biased(case, reference, n_impacts, since) * (reference.deviation(k) + base) + read;
        if off > reference.wide * allowed || off.is_nan() {
            let mine = &main.samples[k];
            let detail =
                format!("{off:e} off, allowed {allowed:e}: referee {mine:?}, library {x:?}");
            first.report(since, "state", &detail);
            break;
        }
    }
}

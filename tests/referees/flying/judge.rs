//! What the library says of a case, held against ballistic flights: each from the library's own state behind the last impact, so that
//! no error of a flight before counts.

use crate::flying::draw::{Barrier, Case};
use nalgebra::DVector;
use vibroimpact::{ImpactSide, Motion, SegmentKind, Status, Trajectory, simulate};

/// Places at which gaps are looked at for each radian that the body, or what moves, turns by, and each size that it goes.
const LOOKS: f64 = 25.0;
const LEAST_LOOKS: usize = 300;
const MOST_LOOKS: usize = 30_000;
/// Tolerances of a gap by which it may be off.
const OFF: f64 = 20.0;

/// What was looked at.
#[derive(Debug, Default, Clone, Copy)]
pub struct Count {
    pub flights: usize,
    pub impacts: usize,
}

/// A flight in closed form.
struct Flight<'a> {
    case: &'a Case,
    start: f64,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Flight<'_> {
    fn at(&self, s: f64) -> (Vec<f64>, Vec<f64>) {
        let a = |i: usize| self.case.load[i] / self.case.mass[i];
        let n = self.q.len();
        let q = (0..n).map(|i| self.q[i] + s * (self.v[i] + 0.5 * s * a(i)));
        let v = (0..n).map(|i| self.v[i] + s * a(i));
        (q.collect(), v.collect())
    }

    fn gap(&self, barrier: &Barrier, s: f64) -> f64 {
        barrier.gap(&self.at(s).0) + barrier.moved(self.start + s)[0]
    }

    /// How fast a gap opens at a state.
    fn opening(barrier: &Barrier, t: f64, q: &[f64], v: &[f64]) -> f64 {
        let slopes = barrier.slopes(q);
        slopes.iter().zip(v).map(|(g, v)| g * v).sum::<f64>() + barrier.moved(t)[1]
    }

    /// By what a gap may be off: tolerances of the state, and the rounding of a time far from zero.
    fn allowed(&self, barrier: &Barrier, s: f64) -> f64 {
        let (q, v) = self.at(s);
        let slopes = barrier.slopes(&q);
        let size = |x: &[f64]| -> f64 { slopes.iter().zip(x).map(|(g, x)| (g * x).abs()).sum() };
        let steep: f64 = slopes.iter().map(|g| g.abs()).sum();
        let began = size(&self.q) + s * size(&self.v);
        let known = self.case.atol * steep + self.case.rtol.max(1e-14) * (size(&q) + began);
        let moved = barrier.motion.map_or(0.0, |[a, w, _]| (a * w).abs());
        OFF * known + 8.0 * f64::EPSILON * self.start.abs().max(1.0) * (size(&v) + moved)
    }

    /// The lowest place of a gap among those looked at, each minimum sharpened; the first that is lower than allowed, if one is.
    fn first_passed(&self, barrier: &Barrier, span: f64) -> Option<(f64, f64)> {
        let n = self.looks(barrier, span);
        let time = |k: usize| span * k as f64 / n as f64;
        let mut last = [f64::INFINITY; 2];
        for k in 0..=n {
            let gap = self.gap(barrier, time(k));
            let dips = k > 1 && last[1] < last[0] && last[1] <= gap;
            if dips {
                let (s, least) = self.lowest(barrier, time(k - 2), time(k));
                if least < -self.allowed(barrier, s) {
                    return Some((s, least));
                }
            }
            if gap < -self.allowed(barrier, time(k)) {
                return Some((time(k), gap));
            }
            last = [last[1], gap];
        }
        None
    }

    fn looks(&self, barrier: &Barrier, span: f64) -> usize {
        let size = barrier.scale();
        let n = self.q.len();
        let ends = [self.at(0.0).1, self.at(span).1];
        let fast = |i: usize| ends.iter().map(|v| v[i].abs()).fold(0.0, f64::max);
        let is_turned = |i: usize| barrier.turns() == Some(i);
        let rates = (0..n).map(|i| {
            if is_turned(i) {
                fast(i)
            } else {
                fast(i) / size
            }
        });
        let own = barrier.motion.map_or(0.0, |m| m[1]);
        let wanted = LOOKS * span * (rates.sum::<f64>() + own);
        (wanted as usize).clamp(LEAST_LOOKS, MOST_LOOKS)
    }

    /// A minimum by golden sections.
    fn lowest(&self, barrier: &Barrier, mut a: f64, mut b: f64) -> (f64, f64) {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..50 {
            let (c, d) = (b - golden * (b - a), a + golden * (b - a));
            if self.gap(barrier, c) < self.gap(barrier, d) {
                b = d;
            } else {
                a = c;
            }
        }
        let s = 0.5 * (a + b);
        (s, self.gap(barrier, s))
    }
}

fn parted((q, v): (DVector<f64>, DVector<f64>)) -> (Vec<f64>, Vec<f64>) {
    (q.as_slice().to_vec(), v.as_slice().to_vec())
}

/// What is wrong with the library's run of a case, if anything.
pub fn wrong(case: &Case, count: &mut Count) -> Option<String> {
    let (q0, v0) = [&case.q, &case.v]
        .map(|x| DVector::from_column_slice(x))
        .into();
    match simulate(&case.scene(), &q0, &v0, case.span, &case.options()) {
        Err(error) => Some(format!("{error}")),
        Ok(run) => judged(case, &run, count),
    }
}

fn judged(case: &Case, run: &Trajectory, count: &mut Count) -> Option<String> {
    if !matches!(run.status(), Status::Finished | Status::MaxImpacts) {
        return Some(format!("{:?}: {}", run.status(), run.message()));
    }
    let state = |t: f64, side: ImpactSide| parted(run.state(t, side).expect("kept"));
    let segments = run.segments().expect("kept");
    // What accumulates or lasts is no flight.
    let lasting = segments.iter().filter(|s| s.kind != SegmentKind::Flight);
    let until = lasting.map(|s| s.start).fold(run.t_end(), f64::min);
    let mut start = case.span.0;
    let mut impacts = run.impacts().iter().peekable();
    loop {
        let next = impacts.peek().filter(|i| i.time <= until).map(|i| i.time);
        let end = next.unwrap_or(until);
        let (q, v) = state(start, ImpactSide::After);
        let flight = Flight { case, start, q, v };
        let span = end - start;
        count.flights += 1;
        for (stop, barrier) in case.barriers.iter().enumerate() {
            if let Some((s, gap)) = flight.first_passed(barrier, span) {
                return Some(format!(
                    "stop {stop} is passed by {:e} at {} on the flight from {start} to {end}",
                    -gap,
                    start + s
                ));
            }
        }
        let time = next?;
        let mut struck = Vec::new();
        while let Some(impact) = impacts.next_if(|i| i.time == time) {
            struck.push(*impact);
        }
        let (before, after) = (
            state(time, ImpactSide::Before),
            state(time, ImpactSide::After),
        );
        for impact in &struck {
            count.impacts += 1;
            let barrier = &case.barriers[impact.stop];
            let gap = flight.gap(barrier, span);
            if gap.abs() > flight.allowed(barrier, span) {
                return Some(format!(
                    "impact on stop {} at {time}: its gap is {gap:e}",
                    impact.stop
                ));
            }
        }
        if let [impact] = struck[..]
            && let Some(broken) = law(case, (impact.stop, time), &before, &after)
        {
            return Some(format!(
                "impact on stop {} at {time}: {broken}",
                impact.stop
            ));
        }
        start = time;
    }
}

/// How the impact of one stop breaks its law, if it does: the velocity changes along `M^-1 grad h`, and the gap opens e times as fast as
/// it closed.
fn law(
    case: &Case,
    (stop, time): (usize, f64),
    before: &(Vec<f64>, Vec<f64>),
    after: &(Vec<f64>, Vec<f64>),
) -> Option<String> {
    let barrier = &case.barriers[stop];
    let (q, v) = before;
    let slopes = barrier.slopes(q);
    let closing = -Flight::opening(barrier, time, q, v);
    let direction: Vec<f64> = slopes.iter().zip(&case.mass).map(|(g, m)| g / m).collect();
    let give: f64 = slopes.iter().zip(&direction).map(|(g, d)| g * d).sum();
    let impulse = (1.0 + barrier.restitution) * closing / give;
    let fast = |i: usize| v[i].abs() + (direction[i] * impulse).abs();
    let moved = barrier.motion.map_or(0.0, |[a, w, _]| (a * w).abs());
    for i in 0..v.len() {
        let expected = v[i] + direction[i] * impulse;
        // The stop moves on by its acceleration while a time far from zero is rounded.
        let late = 8.0 * f64::EPSILON * time.abs() * barrier.motion.map_or(0.0, |m| m[1]);
        let allowed = 1e-9 * fast(i) + 2.0 * late * moved * (direction[i] / give).abs();
        if (after.1[i] - expected).abs() > allowed {
            return Some(format!(
                "velocity {i} after it is {:e}, by the law {expected:e}",
                after.1[i]
            ));
        }
    }
    (closing <= 0.0).then(|| format!("it is left, by {closing:e}"))
}

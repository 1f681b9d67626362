//! The library's run of a pendulum beside the referee's, as far as its runs from starts next to each other tell the same.

use crate::pendulums::run::{Hit, Record, run};
use crate::pendulums::scenes::Case;
use vibroimpact::{ImpactSide, Motion, SegmentKind, Status, Trajectory};

/// How far starts are moved to see what the answer is sensitive to, and what error is allowed besides, in tolerances.
const MOVED: f64 = 1e2;
const BASE: f64 = 1e3;
/// From this difference on the runs beside the referee's tell another story.
const APART: f64 = 1e-3;

/// Times at which gaps are looked at.
const LOOKS: usize = 2000;

/// The runs of the referee: its own, and those from starts that are moved by a little.
pub struct Reference {
    pub main: Record,
    aside: Vec<Record>,
    /// Up to here all tell the same.
    pub until: f64,
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter()
        .zip(y)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

pub fn reference(case: &Case, times: &[f64]) -> Reference {
    let main = run(&case.chain, case.start.clone(), case.end, times, case.rtol);
    let aside: Vec<Record> = (0..4)
        .map(|k: usize| {
            let sign = |i: usize| {
                if (k + i * (k + 1)).is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }
            };
            // What starts on a face stays there.
            let touches = (0..case.chain.faces.len())
                .any(|face| case.chain.gap(face, &case.start[..case.chain.n()]).abs() < 1e-9);
            let by = |i: usize| {
                let is_kept = touches && (i < case.chain.n() || case.start[i] == 0.0);
                if is_kept {
                    0.0
                } else {
                    sign(i) * MOVED * case.rtol
                }
            };
            let start = case
                .start
                .iter()
                .enumerate()
                .map(|(i, x)| x + by(i))
                .collect();
            let mut chain = case.chain.clone();
            chain.gravity *= 1.0 + sign(7) * MOVED * case.rtol;
            run(&chain, start, case.end, times, case.rtol)
        })
        .collect();
    let mut until = aside.iter().fold(main.end, |end, run| end.min(run.end));
    for other in &aside {
        let hits = main.hits.iter().zip(&other.hits);
        let off = hits
            .clone()
            .find(|(a, b)| a.face != b.face || (a.time - b.time).abs() > APART);
        let more = main.hits.len().min(other.hits.len());
        let extra = main
            .hits
            .get(more)
            .or(other.hits.get(more))
            .map(|hit| hit.time);
        let first = off.map(|(a, b)| a.time.min(b.time));
        until = [first, extra].into_iter().flatten().fold(until, f64::min);
        let samples = times.iter().zip(main.samples.iter().zip(&other.samples));
        for (&t, (x, y)) in samples {
            let beside = main.hits.iter().any(|hit| (hit.time - t).abs() < APART);
            if !beside && distance(x, y) > APART {
                until = until.min(t);
            }
        }
        for (a, b) in main.held.iter().zip(&other.held) {
            if (a.start - b.start).abs() > APART {
                until = until.min(a.start.min(b.start));
            } else if (a.end - b.end).abs() > APART {
                until = until.min(a.end.min(b.end));
            }
        }
    }
    Reference { main, aside, until }
}

/// What the library says otherwise, if anything.
pub fn difference(
    case: &Case,
    times: &[f64],
    reference: &Reference,
    run: &Trajectory,
) -> Option<String> {
    let until = reference.until - 2.0 * APART;
    if run.status() != Status::Finished && run.t_end() < until {
        return Some(format!("{:?}: {}", run.status(), run.message()));
    }
    impacts(case, reference, run, until)
        .or_else(|| contacts(reference, run, until))
        .or_else(|| states(case, times, reference, run, until))
        .or_else(|| gaps(case, run))
}

fn impacts(case: &Case, reference: &Reference, run: &Trajectory, until: f64) -> Option<String> {
    let base = BASE * case.rtol;
    let theirs: Vec<_> = run.impacts().iter().filter(|i| i.time < until).collect();
    let mine = reference.main.hits.iter().filter(|hit| hit.time < until);
    let mine: Vec<_> = mine.collect();
    for (k, (a, b)) in mine.iter().zip(&theirs).enumerate() {
        if a.face != b.stop {
            return Some(format!("impact {k}: referee {a:?}, library {b:?}"));
        }
        let aside = |of: &dyn Fn(&Hit) -> f64| {
            let others = reference.aside.iter().filter_map(|r| r.hits.get(k));
            others.fold(0.0, |most: f64, hit| most.max((of(hit) - of(a)).abs()))
        };
        let late = base * (1.0 + 1.0 / a.approach);
        let strong = base + 10.0 * late * swing(case);
        let found: [(&str, &dyn Fn(&Hit) -> f64, f64, f64); 3] = [
            ("time", &|hit| hit.time, b.time, late),
            ("speed", &|hit| hit.approach, b.approach, strong),
            ("impulse", &|hit| hit.impulse, b.impulse, strong),
        ];
        for (what, of, theirs, least) in found {
            let (mine, allowed) = (of(a), 10.0 * aside(of) + least);
            if (mine - theirs).abs() > allowed {
                return Some(format!(
                    "{what} of impact {k}: {mine:e}, library {theirs:e}, allowed {allowed:e}"
                ));
            }
        }
    }
    let (mine, theirs) = (mine.len(), theirs.len());
    (mine != theirs).then(|| format!("{mine} impacts before {until}, library {theirs}"))
}

fn contacts(reference: &Reference, run: &Trajectory, until: f64) -> Option<String> {
    let segments = run.segments().expect("kept");
    let holds = |face: usize, t: f64| {
        let mut sticks = segments.iter().filter(|s| s.kind == SegmentKind::Stick);
        sticks.any(|s| s.stop == Some(face) && s.start <= t && t <= s.end)
    };
    for held in &reference.main.held {
        let length = held.end.min(until) - held.start;
        let inside = [0.01, 0.5, 0.99].map(|part| held.start + part * length);
        let missed = inside.into_iter().find(|&t| !holds(held.face, t));
        if let Some(t) = missed.filter(|_| length > APART) {
            return Some(format!("{held:?} is not held at {t}"));
        }
    }
    None
}

fn states(
    case: &Case,
    times: &[f64],
    reference: &Reference,
    run: &Trajectory,
    until: f64,
) -> Option<String> {
    let main = &reference.main;
    for (k, (&t, x)) in times.iter().zip(&main.samples).enumerate() {
        let is_beside = main.hits.iter().any(|hit| (hit.time - t).abs() < APART);
        if t >= until || is_beside {
            continue;
        }
        let (q, v) = run.state(t, ImpactSide::After).expect("kept");
        let y: Vec<f64> = q.iter().chain(v.iter()).copied().collect();
        let near = k.saturating_sub(1)..k + 2;
        let spread = reference.aside.iter().flat_map(|other| {
            let pairs = near
                .clone()
                .filter_map(|j| Some((other.samples.get(j)?, main.samples.get(j)?)));
            pairs.map(|(a, b)| distance(a, b))
        });
        let size = x.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
        // A neighbour on the other side of an impact says nothing.
        let spread = spread.filter(|d| *d < 1.0).fold(0.0, f64::max);
        let (off, allowed) = (
            distance(x, &y),
            10.0 * spread + BASE * case.rtol * size * swing(case),
        );
        if off > allowed {
            return Some(format!(
                "at {t}: {off:e} off, allowed {allowed:e}: {x:?}, library {y:?}"
            ));
        }
    }
    None
}

/// No gap may be below the tolerance, whoever else is right.
fn gaps(case: &Case, run: &Trajectory) -> Option<String> {
    for k in 0..=LOOKS {
        let t = run.t_end() * k as f64 / LOOKS as f64;
        let (q, _) = run.state(t, ImpactSide::After).expect("kept");
        for face in 0..case.chain.faces.len() {
            let gap = case.chain.gap(face, q.as_slice());
            if gap < -1e2 * case.rtol {
                return Some(format!("behind face {face} at {t}: {gap:e}"));
            }
        }
    }
    None
}

/// How fast the chain swings, at least one.
fn swing(case: &Case) -> f64 {
    let lengths = case.chain.lengths.iter().copied();
    let shortest = lengths.fold(f64::INFINITY, f64::min);
    (case.chain.gravity / shortest).sqrt().max(1.0)
}

//! A referee for pendulums with large motions, in steps and along Taylor series: chains written down from the places of their
//! bobs, followed by extrapolated steps that are much shorter than the motion. The number of scenes is `VIBROIMPACT_CASES`
//! (default 100), their seed `VIBROIMPACT_SEED`; `VIBROIMPACT_CASE` picks one.

mod chain;
#[path = "../common/random.rs"]
mod random;
mod run;
mod scenes;

use nalgebra::DVector;
use random::{Random, number};
use run::{Record, run};
use scenes::Case;
use vibroimpact::{ImpactSide, SegmentKind, SimulateOptions, Status, Trajectory, simulate};

/// Times at which states are compared.
const SAMPLES: usize = 40;
/// How far starts are moved to see what the answer is sensitive to, and what error is allowed besides, in tolerances.
const MOVED: f64 = 1e2;
const BASE: f64 = 1e3;
/// From this difference on the runs beside the referee's tell another story.
const APART: f64 = 1e-3;

/// The runs of the referee: its own, and those from starts that are moved by a little.
struct Reference {
    main: Record,
    aside: Vec<Record>,
    /// Up to here all tell the same.
    until: f64,
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter()
        .zip(y)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

fn reference(case: &Case, times: &[f64]) -> Reference {
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

/// What the library says otherwise, if anything, before an impact or a sample hangs on less than the tolerance.
fn difference(
    case: &Case,
    times: &[f64],
    reference: &Reference,
    run: &Trajectory,
) -> Option<String> {
    let base = BASE * case.rtol;
    let (main, until) = (&reference.main, reference.until - 2.0 * APART);
    if run.status() != Status::Finished && run.t_end() < until {
        return Some(format!("{:?}: {}", run.status(), run.message()));
    }
    let theirs: Vec<_> = run.impacts().iter().filter(|i| i.time < until).collect();
    let mine: Vec<_> = main.hits.iter().filter(|hit| hit.time < until).collect();
    for (k, (a, b)) in mine.iter().zip(&theirs).enumerate() {
        let aside = |of: &dyn Fn(&run::Hit) -> f64| {
            let others = reference.aside.iter().filter_map(|r| r.hits.get(k));
            others
                .map(|hit| (of(hit) - of(a)).abs())
                .fold(0.0, f64::max)
        };
        let late = base * (1.0 + 1.0 / a.approach);
        let pairs = [
            ("time", a.time, b.time, aside(&|h| h.time), late),
            (
                "speed",
                a.approach,
                b.approach,
                aside(&|h| h.approach),
                base + 10.0 * late * aside_rate(case),
            ),
            (
                "impulse",
                a.impulse,
                b.impulse,
                aside(&|h| h.impulse),
                base + 10.0 * late * aside_rate(case),
            ),
        ];
        if a.face != b.stop {
            return Some(format!("impact {k}: referee {a:?}, library {b:?}"));
        }
        for (what, x, y, spread, allowed) in pairs {
            let allowed = 10.0 * spread + allowed;
            if (x - y).abs() > allowed {
                return Some(format!(
                    "{what} of impact {k}: {x:e}, library {y:e}, allowed {allowed:e}"
                ));
            }
        }
    }
    if mine.len() != theirs.len() {
        return Some(format!(
            "{} impacts before {until}, library {}",
            mine.len(),
            theirs.len()
        ));
    }
    let sticks: Vec<_> = run
        .segments()
        .expect("kept")
        .into_iter()
        .filter(|s| s.kind == SegmentKind::Stick)
        .collect();
    for held in main.held.iter().filter(|held| held.start < until) {
        let is_it = |t: f64| {
            sticks
                .iter()
                .any(|s| s.stop == Some(held.face) && s.start <= t && t <= s.end)
        };
        let inside =
            [0.01, 0.5, 0.99].map(|part| held.start + part * (held.end.min(until) - held.start));
        if let Some(t) = inside
            .into_iter()
            .find(|&t| held.end.min(until) - held.start > APART && !is_it(t))
        {
            return Some(format!("{held:?} is not held at {t}"));
        }
    }
    for (k, (&t, x)) in times.iter().zip(&main.samples).enumerate() {
        let beside = main.hits.iter().any(|hit| (hit.time - t).abs() < APART);
        if t >= until || beside {
            continue;
        }
        let (q, v) = run.state(t, ImpactSide::After).expect("kept");
        let y: Vec<f64> = q.iter().chain(v.iter()).copied().collect();
        let near = k.saturating_sub(1)..k + 2;
        let spread = reference.aside.iter().flat_map(|r| {
            near.clone()
                .filter_map(|j| Some(distance(r.samples.get(j)?, main.samples.get(j)?)))
        });
        let size = x.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
        let allowed =
            10.0 * spread.filter(|d| *d < 1.0).fold(0.0, f64::max) + base * size * aside_rate(case);
        if distance(x, &y) > allowed {
            return Some(format!(
                "at {t}: {:e} off, allowed {allowed:e}: {x:?}, library {y:?}",
                distance(x, &y)
            ));
        }
    }
    // No gap below its rounding, whoever else is right.
    let end = run.t_end();
    for k in 0..=2000 {
        let t = end * f64::from(k) / 2000.0;
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
fn aside_rate(case: &Case) -> f64 {
    let shortest = case
        .chain
        .lengths
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    (case.chain.gravity / shortest).sqrt().max(1.0)
}

#[test]
fn pendulums_move_as_the_referee_says() {
    let (count, seed) = (
        number("VIBROIMPACT_CASES", 100),
        number("VIBROIMPACT_SEED", 1) as u64,
    );
    let only = std::env::var("VIBROIMPACT_CASE")
        .ok()
        .and_then(|text| text.parse::<usize>().ok());
    let (mut parts, mut failed, mut hits) = (0.0, Vec::new(), 0);
    for number in (0..count).filter(|k| only.is_none_or(|only| only == *k)) {
        let mut random = Random((seed << 24) + 7919 * number as u64 + 1);
        for _ in 0..8 {
            random.unit();
        }
        let case = scenes::scene(&mut random);
        let times: Vec<f64> = (1..SAMPLES)
            .map(|k| case.end * k as f64 / SAMPLES as f64)
            .collect();
        let reference = reference(&case, &times);
        let n = case.chain.n();
        let options = SimulateOptions {
            method: case.method,
            rtol: case.rtol,
            atol: 1e-2 * case.rtol,
            ..Default::default()
        };
        let [q0, v0] = [&case.start[..n], &case.start[n..]].map(DVector::from_column_slice);
        let again = || simulate(&case.scene(), &q0, &v0, (0.0, case.end), &options);
        let wrong = match again() {
            Err(error) => Some(error.to_string()),
            Ok(run) => {
                let same = again().is_ok_and(|twice| twice.last() == run.last());
                let differs = difference(&case, &times, &reference, &run);
                differs.or_else(|| (!same).then(|| "two runs differ".to_owned()))
            }
        };
        parts += reference.until / case.end;
        hits += reference
            .main
            .hits
            .iter()
            .filter(|h| h.time < reference.until)
            .count();
        if only.is_some() {
            println!(
                "{case:?}\n{:?} until {} ({:?})",
                reference.main, reference.until, reference.main.why
            );
        }
        if let Some(wrong) = wrong {
            println!(
                "scene {number} of seed {seed}, {:?} {:e}: {wrong}",
                case.method, case.rtol
            );
            failed.push(number);
        }
    }
    println!(
        "{count} scenes, compared {:.3} of the spans, {hits} impacts",
        parts / count as f64
    );
    assert!(
        failed.is_empty(),
        "the library and the referee disagree: {failed:?}"
    );
    assert!(
        only.is_some() || parts > 0.4 * count as f64,
        "compared {parts} spans of {count}"
    );
}

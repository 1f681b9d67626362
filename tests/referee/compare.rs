//! The library's run beside the referee's: as far as the answer does not hang on rounding, which a second and a third run of
//! the referee with all numbers moved by `1e-13` tell, impacts, lasting contact and states must agree.

use crate::case::{Case, MOST_IMPACTS, StopCase};
use crate::double_double::Dd;
use crate::invariants;
use crate::motion::{Factors, Model};
use crate::record::{Hit, Record, Stretch};
use crate::simulator::{Roughness, follow};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use vibroimpact::{ImpactSide, Method, Scene, SegmentKind, Status, Trajectory, simulate_checked};

pub struct Difference {
    pub class: String,
    pub detail: String,
}

pub enum Verdict {
    /// Agreement up to a part of the span; why not further.
    Agree(f64, Option<&'static str>),
    Disagree(Vec<Difference>),
    /// The generator made what is no scene.
    NoScene(String),
}

/// After this time a run of the library counts as endless.
const PATIENCE: Duration = Duration::from_secs(5);
const SAMPLES: usize = 40;

/// How far the numbers are moved to see what the answer is sensitive to, and the error that is allowed besides.
struct Allowance {
    moved: f64,
    base: f64,
}

fn allowance(case: &Case) -> Allowance {
    if case.method == Method::Exact {
        Allowance {
            moved: 1e-13,
            base: 1e-12,
        }
    } else {
        Allowance {
            moved: 1e2 * case.rtol,
            base: 1e3 * case.rtol,
        }
    }
}

/// The referee's run, and two beside it.
pub struct Reference {
    pub main: Record,
    pub aside: [Record; 2],
    pub times: Vec<f64>,
    /// Up to where they tell the same story, and why not further.
    pub horizon: (f64, Option<&'static str>),
    pub model: Model,
    /// Sizes of positions and velocities, of steps at least those at which the absolute tolerance takes over.
    pub q_unit: f64,
    pub v_unit: f64,
}

pub fn reference(case: &Case) -> Reference {
    let duration = Dd::from(case.span.1) - Dd::from(case.span.0);
    let mut times: Vec<f64> = (0..SAMPLES)
        .map(|k| {
            let part = (k as f64 + 0.37 * (k as f64).sin().abs()) / SAMPLES as f64;
            case.span.0 + part * (case.span.1 - case.span.0)
        })
        .collect();
    times.dedup();
    let samples: Vec<Dd> = times
        .iter()
        .map(|&t| Dd::from(t) - Dd::from(case.span.0))
        .collect();
    let run = |factors: Factors, roughness: Option<Roughness>| {
        let model = Model::new(case, &factors);
        let start = model.start(case, &factors);
        (
            follow(&model, start, duration, &samples, roughness, MOST_IMPACTS),
            model,
        )
    };
    let touches = case.stops.iter().any(|s| {
        let gap = s.clearance
            - s.outward()
                .iter()
                .zip(&case.q0)
                .map(|(n, q)| n * q)
                .sum::<f64>();
        gap.abs() <= 1e-6 * (s.clearance.abs() + 1.0)
    });
    let moved = |sign: f64| {
        let by = sign * allowance(case).moved;
        let q = if touches { 1.0 } else { 1.0 - 0.7 * by };
        [
            1.0 + 0.4 * by,
            1.0 - by,
            1.0 - 0.6 * by,
            1.0 + by,
            1.0 + 0.8 * by,
            q,
            1.0 + 0.9 * by,
        ]
    };
    let rough = |sign: f64| {
        Some(Roughness {
            completion: case.rtol,
            gap: sign
                * if case.method == Method::Exact {
                    2e-15
                } else {
                    case.rtol
                },
        })
    };
    let (main, model) = run([1.0; 7], None);
    let aside = [
        run(moved(1.0), rough(1.0)).0,
        run(moved(-1.0), rough(-1.0)).0,
    ];
    let floor = if case.method == Method::Exact {
        1e-12
    } else {
        case.atol / case.rtol
    };
    let (q_terms, v_terms) = terms(case);
    let mut reference = Reference {
        q_unit: main.q_size.max(floor).max(q_terms),
        v_unit: main.v_size.max(floor).max(v_terms),
        horizon: (main.end, None),
        main,
        aside,
        times,
        model,
    };
    reference.horizon = horizon(&reference, case);
    reference
}

/// Sizes of the terms of a motion that is the sum of a steady and a free one: forces over the least stiffness, where they are
/// not faster than all modes. A motion from rest is at first the small difference of such terms, and known to their rounding.
fn terms(case: &Case) -> (f64, f64) {
    let values = case
        .mass
        .clone()
        .try_inverse()
        .map(|m| (m * &case.stiffness).complex_eigenvalues());
    let squares: Vec<f64> = values.map_or(Vec::new(), |v| v.iter().map(|z| z.norm()).collect());
    let (least, most) = squares
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(a, b), &x| (a.min(x), b.max(x)));
    if squares.is_empty() || least <= 1e-9 * most {
        return (0.0, 0.0);
    }
    let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let mut force = largest(&case.load);
    if let Some(f) = &case.force
        && f.frequency * f.frequency < 4.0 * most
    {
        force += largest(&f.re) + largest(&f.im);
    }
    let lightest = case.mass.diagonal().min();
    let q = force / lightest / least;
    (q, q * most.sqrt())
}

impl Reference {
    /// How far the runs aside are off at a sample and its neighbours, relative to the motion.
    fn deviation(&self, k: usize) -> f64 {
        (k.saturating_sub(2)..=k + 1)
            .map(|j| self.deviation_at(j))
            .fold(0.0, f64::max)
    }

    fn deviation_at(&self, k: usize) -> f64 {
        let Some(x) = self.main.samples.get(k) else {
            return 0.0;
        };
        self.aside
            .iter()
            .filter_map(|r| r.samples.get(k))
            .map(|y| self.distance(x, y))
            .fold(0.0, f64::max)
    }

    /// Largest difference of two states, relative to the largest position and velocity.
    pub fn distance(&self, x: &[f64], y: &[f64]) -> f64 {
        let n = x.len() / 2;
        let (q, v) = (self.q_unit, self.v_unit);
        x.iter()
            .zip(y)
            .enumerate()
            .map(|(i, (a, b))| (a - b).abs() / if i < n { q } else { v })
            .fold(0.0, f64::max)
    }
}

/// Impacts outside the ends of accumulating ones. What is known of the time of such an end is a small part of its length.
fn outside(hits: &[Hit], chatters: &[&[Stretch]], slack: f64) -> Vec<Hit> {
    let is_inside = |hit: &Hit| {
        let time = hit.time.to_f64();
        chatters.iter().flat_map(|c| c.iter()).any(|c| {
            let slack = slack + 3e-3 * (c.end - c.start);
            c.stop == hit.stop && time > c.start - slack && time < c.end + slack
        })
    };
    let outside = hits
        .iter()
        .filter(|hit| hit.approach > 0.0 && !is_inside(hit));
    outside.cloned().collect()
}

/// Sorts impacts at practically one time by their stops.
fn in_order(mut hits: Vec<Hit>, slack: f64) -> Vec<Hit> {
    let mut i = 0;
    while i < hits.len() {
        let start = hits[i].time.to_f64();
        let mut j = i + 1;
        while j < hits.len() && hits[j].time.to_f64() - start <= slack {
            j += 1;
        }
        hits[i..j].sort_by_key(|h| h.stop);
        i = j;
    }
    hits
}

fn horizon(reference: &Reference, case: &Case) -> (f64, Option<&'static str>) {
    let main = &reference.main;
    let mut end = (main.end, None);
    let mut cut = |time: f64, why: &'static str| {
        if time < end.0 {
            end = (time, Some(why));
        }
    };
    for record in std::iter::once(main).chain(&reference.aside) {
        for &(time, why) in &record.doubts {
            cut(time, why);
        }
        if let Some((time, why)) = record.stopped {
            cut(time, why);
        }
    }
    let slack = 1e-9 / reference.model.rate;
    for aside in &reference.aside {
        let chatters = [&main.chatters[..], &aside.chatters[..]];
        let mine = in_order(outside(&main.hits, &chatters, slack), slack);
        let theirs = in_order(outside(&aside.hits, &chatters, slack), slack);
        for (a, b) in mine.iter().zip(&theirs) {
            let (s, t) = (a.time.to_f64(), b.time.to_f64());
            if a.stop != b.stop || (s - t).abs() > 1e-3 / reference.model.rate {
                cut(s.min(t), "another order of impacts");
                break;
            }
        }
        if mine.len() != theirs.len() {
            let at = mine.len().min(theirs.len());
            let next = mine.get(at).or(theirs.get(at)).expect("the longer one");
            cut(next.time.to_f64(), "another number of impacts");
        }
        let (mine, theirs) = (
            long(&on_planes(case, &main.sticks), slack),
            long(&on_planes(case, &aside.sticks), slack),
        );
        for (a, b) in mine.iter().zip(&theirs) {
            if a.stop != b.stop || (a.start - b.start).abs() > 1e-3 / reference.model.rate {
                cut(a.start.min(b.start), "another order of lasting contacts");
                break;
            }
            if (a.end - b.end).abs() > 1e-3 / reference.model.rate {
                cut(a.end.min(b.end), "another end of lasting contact");
                break;
            }
        }
        if mine.len() != theirs.len() {
            let at = mine.len().min(theirs.len());
            let next = mine.get(at).or(theirs.get(at)).expect("the longer one");
            cut(next.start, "another number of lasting contacts");
        }
    }
    for k in 0..main.samples.len() {
        if reference.deviation_at(k) > 1e-4 {
            cut(reference.times[k] - case.span.0, "sensitive to rounding");
            break;
        }
    }
    end
}

/// Lasting contact by planes: stops at one place, on either side, are one, since which of them carries the force is nobody's.
fn on_planes(case: &Case, sticks: &[Stretch]) -> Vec<Stretch> {
    let plane = |stop: usize| {
        let unit = |stop: &StopCase| {
            let n = stop.outward();
            let size = n
                .iter()
                .fold(0.0, |m: f64, x| if x.abs() > m.abs() { *x } else { m });
            let place = stop.clearance / size;
            (n.iter().map(|x| x / size).collect::<Vec<f64>>(), place)
        };
        let (n, place) = unit(&case.stops[stop]);
        let is_same = |other: &StopCase| {
            let (m, there) = unit(other);
            (place - there).abs() <= 1e-14 * place.abs()
                && n.iter().zip(&m).all(|(a, b)| (a - b).abs() < 1e-14)
        };
        case.stops.iter().position(is_same).unwrap_or(stop)
    };
    let mut planes: Vec<Stretch> = Vec::new();
    for stick in sticks {
        let stick = Stretch {
            stop: if stick.stop < case.stops.len() {
                plane(stick.stop)
            } else {
                stick.stop
            },
            ..stick.clone()
        };
        let same = planes
            .iter_mut()
            .rev()
            .find(|s| s.stop == stick.stop && s.end >= stick.start);
        if let Some(same) = same {
            same.end = same.end.max(stick.end);
        } else {
            planes.push(stick);
        }
    }
    planes
}

fn long(sticks: &[Stretch], shortest: f64) -> Vec<Stretch> {
    let mut kept: Vec<Stretch> = Vec::new();
    for stick in sticks {
        // What goes on at the same stop is one.
        if let Some(last) = kept.iter_mut().rev().find(|s| s.stop == stick.stop)
            && stick.start - last.end <= shortest
        {
            last.end = stick.end;
        } else {
            kept.push(stick.clone());
        }
    }
    kept.retain(|s| s.end - s.start > 1e3 * shortest);
    kept.sort_by(|a, b| a.start.total_cmp(&b.start));
    let mut i = 0;
    while i < kept.len() {
        let mut j = i + 1;
        while j < kept.len() && kept[j].start - kept[i].start <= shortest {
            j += 1;
        }
        kept[i..j].sort_by_key(|s| s.stop);
        i = j;
    }
    kept
}

/// The library's run, in a thread that is left behind if it never ends.
fn library(case: &Case, scene: &Scene) -> Result<Trajectory, Difference> {
    let difference = |class: &str, detail: String| Difference {
        class: class.to_string(),
        detail,
    };
    let (sender, receiver) = channel();
    let (case, scene) = (case.clone(), scene.clone());
    std::thread::spawn(move || {
        let (q0, v0) = case.start();
        let began = Instant::now();
        let mut observer = |_| {
            if began.elapsed() > PATIENCE {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let run = catch_unwind(AssertUnwindSafe(|| {
            simulate_checked(&scene, &q0, &v0, case.span, &case.options(), &mut observer)
        }));
        let _ = sender.send(run);
    });
    match receiver.recv_timeout(2 * PATIENCE) {
        Err(_) => Err(difference("endless, and asks nobody", String::new())),
        Ok(Err(panic)) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or(panic.downcast_ref::<&str>().map(ToString::to_string));
            Err(difference("panic", text.unwrap_or_default()))
        }
        Ok(Ok(Err(vibroimpact::Error::Interrupted))) => {
            Err(difference("endless", format!("more than {PATIENCE:?}")))
        }
        Ok(Ok(Err(error))) => Err(difference("error", error.to_string())),
        Ok(Ok(Ok(run))) => Ok(run),
    }
}

pub fn judge(case: &Case) -> Verdict {
    let scene = match case.scene() {
        Ok(scene) => scene,
        Err(error) => return Verdict::NoScene(error.to_string()),
    };
    let began = Instant::now();
    let reference = reference(case);
    if began.elapsed().as_secs_f64() > 1.0 {
        println!(
            "the referee took {:.1} s: {}",
            began.elapsed().as_secs_f64(),
            case.label
        );
    }
    let part = reference.horizon.0 / (case.span.1 - case.span.0);
    let run = match library(case, &scene) {
        Ok(run) => run,
        Err(difference) => return Verdict::Disagree(vec![difference]),
    };
    let mut differences = invariants::check(case, &scene, &run, &reference);
    differences.extend(first_difference(case, &run, &reference));
    if differences.is_empty() {
        Verdict::Agree(part, reference.horizon.1)
    } else {
        Verdict::Disagree(differences)
    }
}

/// What the library saw, in the referee's form.
fn seen(case: &Case, run: &Trajectory) -> (Vec<Hit>, Vec<Stretch>, Vec<Stretch>) {
    let since = |t: f64| (Dd::from(t) - Dd::from(case.span.0)).to_f64();
    let hits = run
        .impacts()
        .iter()
        .map(|i| Hit {
            time: Dd::from(i.time) - Dd::from(case.span.0),
            stop: i.stop,
            approach: i.approach,
            departure: i.departure,
            impulse: i.impulse,
            curvature: f64::NAN,
            rounds: 1,
        })
        .collect();
    let of = |kind: SegmentKind| {
        let segments = run.segments().expect("kept");
        segments
            .iter()
            .filter(|s| s.kind == kind)
            .map(|s| Stretch {
                stop: s.stop.unwrap_or(usize::MAX),
                start: since(s.start),
                end: since(s.end),
            })
            .collect()
    };
    (hits, of(SegmentKind::Chatter), of(SegmentKind::Stick))
}

fn first_difference(case: &Case, run: &Trajectory, reference: &Reference) -> Option<Difference> {
    let allowance = allowance(case);
    let main = &reference.main;
    let tick = 4.0 * f64::EPSILON * case.span.0.abs().max(case.span.1.abs());
    let rate = reference.model.rate;
    let slack = 1e-9 / rate + 2.0 * tick;
    let (their_hits, their_chatters, their_sticks) = seen(case, run);
    // Up to here decisions are compared; an impact just before the horizon may be just behind it.
    let until = reference.horizon.0 * (1.0 - 1e-9) - 1e-6 / rate - 2.0 * tick;
    let mut found: Option<(f64, Difference)> = None;
    let mut report = |time: f64, class: String, detail: String| {
        if found.as_ref().is_none_or(|f| time < f.0) {
            found = Some((
                time,
                Difference {
                    class,
                    detail: format!("at {time:e}: {detail}"),
                },
            ));
        }
    };
    let reached = (Dd::from(run.span().1) - Dd::from(case.span.0)).to_f64();
    if !matches!(run.status(), Status::Finished | Status::MaxImpacts) && reached < until {
        report(
            reached,
            format!("status {}", run.status().name()),
            run.message().to_string(),
        );
    }
    let chatters = [&main.chatters[..], &their_chatters[..]];
    let mine = in_order(outside(&main.hits, &chatters, slack), slack);
    let theirs = in_order(outside(&their_hits, &chatters, slack), slack);
    // What the completion of accumulating impacts may cost: a few tolerances.
    let completed = |time: f64| {
        let has = their_chatters.iter().any(|c| c.start <= time);
        if has { 10.0 * case.rtol } else { 0.0 }
    };
    let beside: Vec<Vec<Hit>> = reference
        .aside
        .iter()
        .map(|r| in_order(outside(&r.hits, &chatters, slack), slack))
        .collect();
    let normal_size = |stop: usize| case.stops[stop].normal.iter().map(|x| x.abs()).sum::<f64>();
    for k in 0..mine.len().max(theirs.len()) {
        let (a, b) = (mine.get(k), theirs.get(k));
        let time = |h: Option<&Hit>| h.map_or(f64::INFINITY, |h| h.time.to_f64());
        if time(a).min(time(b)) >= until {
            break;
        }
        let apart = (time(a) - time(b)).abs();
        let aside = |f: &dyn Fn(&Hit) -> f64| {
            let a = a.map_or(0.0, f);
            beside
                .iter()
                .filter_map(|r| r.get(k))
                .map(|h| (f(h) - a).abs())
                .fold(0.0, f64::max)
        };
        let is_same = a.zip(b).is_some_and(|(a, b)| a.stop == b.stop)
            && apart < 1e-3 / rate + 1e2 * aside(&|h| h.time.to_f64()) + tick;
        if !is_same {
            let (class, hit) = if time(a) <= time(b) {
                ("impact missed", a)
            } else {
                ("impact extra", b)
            };
            let hit = hit.expect("the earlier one");
            let bend = if hit.curvature.is_finite() {
                hit.curvature
            } else {
                main.v_size * rate * normal_size(hit.stop)
            };
            let depth = hit.approach.powi(2) / (2.0 * bend.abs().max(1e-300));
            let margin = 20.0
                * (case.atol * normal_size(hit.stop)
                    + case.rtol.min(1e-9).max(1e-15) * normal_size(hit.stop) * main.q_size);
            let shallow = if depth < margin { ", shallow" } else { "" };
            report(
                hit.time.to_f64(),
                format!("{class}{shallow}"),
                format!("impact {k}: referee {}, library {}", show(a), show(b)),
            );
            break;
        }
        let (a, b) = (a.expect("same"), b.expect("same"));
        let base = allowance.base + completed(a.time.to_f64());
        let speed_allowed =
            10.0 * aside(&|h| h.approach) + base * reference.v_unit * normal_size(a.stop) * 10.0;
        let time_allowed = 10.0 * aside(&|h| h.time.to_f64())
            + tick
            + base * (reference.q_unit * normal_size(a.stop) * 10.0 / a.approach + 10.0 / rate);
        let push = reference.model.delassus.rows[a.stop][a.stop].to_f64();
        let impulse_allowed = 10.0 * aside(&|h| h.impulse) + 4.0 * speed_allowed / push;
        let details = || {
            format!(
                "impact {k}: referee {}, library {}",
                show(Some(a)),
                show(Some(b))
            )
        };
        if apart > time_allowed {
            report(
                a.time.to_f64(),
                "impact time".into(),
                format!("{:e} off, allowed {time_allowed:e}; {}", apart, details()),
            );
        } else if (a.approach - b.approach).abs() > speed_allowed {
            report(a.time.to_f64(), "speed before".into(), details());
        } else if (a.departure - b.departure).abs() > speed_allowed {
            report(a.time.to_f64(), "speed after".into(), details());
        } else if a.rounds == 1 && (a.impulse - b.impulse).abs() > impulse_allowed {
            report(a.time.to_f64(), "impulse".into(), details());
        }
    }
    compare_sticks(
        case,
        reference,
        &their_sticks,
        until,
        slack,
        !their_chatters.is_empty(),
        &mut report,
    );
    for (k, &t) in reference.times.iter().enumerate() {
        let since = (Dd::from(t) - Dd::from(case.span.0)).to_f64();
        let near = |time: f64| (time - since).abs() <= slack;
        let is_beside = mine.iter().any(|h| near(h.time.to_f64()))
            || their_chatters
                .iter()
                .chain(&main.chatters)
                .any(|c| since > c.start - slack && since < c.end + slack);
        if since >= until || since > reached || is_beside || k >= main.samples.len() {
            continue;
        }
        let Ok((q, v)) = run.state(t, ImpactSide::After) else {
            report(since, "state refused".into(), format!("at {t:?}"));
            break;
        };
        let theirs: Vec<f64> = q.iter().chain(v.iter()).copied().collect();
        let off = reference.distance(&main.samples[k], &theirs);
        let allowed = 10.0 * (reference.deviation(k) + allowance.base + completed(since));
        if off > allowed || off.is_nan() {
            report(
                since,
                "state".into(),
                format!(
                    "{off:e} off, allowed {allowed:e}: referee {:?}, library {theirs:?}",
                    main.samples[k]
                ),
            );
            break;
        }
    }
    found.map(|f| f.1)
}

fn compare_sticks(
    case: &Case,
    reference: &Reference,
    theirs: &[Stretch],
    until: f64,
    slack: f64,
    has_chatter: bool,
    report: &mut dyn FnMut(f64, String, String),
) {
    let by_plane = |sticks: &[Stretch]| long(&on_planes(case, sticks), slack);
    let (mine, theirs) = (by_plane(&reference.main.sticks), by_plane(theirs));
    let beside: Vec<Vec<Stretch>> = reference
        .aside
        .iter()
        .map(|r| by_plane(&r.sticks))
        .collect();
    let rate = reference.model.rate;
    for k in 0..mine.len().max(theirs.len()) {
        let (a, b) = (mine.get(k), theirs.get(k));
        let start = |s: Option<&Stretch>| s.map_or(f64::INFINITY, |s| s.start);
        if start(a).min(start(b)) >= until {
            return;
        }
        let details = format!("lasting contact {k}: referee {a:?}, library {b:?}");
        let is_same = a
            .zip(b)
            .is_some_and(|(a, b)| a.stop == b.stop && (a.start - b.start).abs() < 1e-3 / rate);
        if !is_same {
            let class = if start(a) <= start(b) {
                "lasting contact missed"
            } else {
                "lasting contact extra"
            };
            return report(start(a).min(start(b)), class.into(), details);
        }
        let (a, b) = (a.expect("same"), b.expect("same"));
        let aside = |f: &dyn Fn(&Stretch) -> f64| {
            beside
                .iter()
                .filter_map(|r| r.get(k))
                .map(|s| (f(s) - f(a)).abs())
                .fold(0.0, f64::max)
        };
        // A force that falls slowly ends at a time as uncertain as the force is over its slope: the runs aside know.
        let tolerance = if case.method == Method::Exact && !has_chatter {
            1e-10
        } else {
            case.rtol
        };
        let allowed =
            |f: &dyn Fn(&Stretch) -> f64| 100.0 * (aside(f) + tolerance / rate) + 10.0 * slack;
        // Where impacts that accumulate are completed early, their end is known to the root of the tolerance, the motion to it.
        let early = if has_chatter {
            (10.0 * case.rtol).sqrt() / rate
        } else {
            0.0
        };
        if (a.start - b.start).abs() > allowed(&|s| s.start) + early {
            return report(a.start, "start of lasting contact".into(), details);
        }
        if (a.end - b.end).abs() > allowed(&|s| s.end) && a.end.min(b.end) < until {
            return report(a.end.min(b.end), "end of lasting contact".into(), details);
        }
    }
}

fn show(hit: Option<&Hit>) -> String {
    hit.map_or("none".to_string(), |h| {
        format!(
            "[stop {} t {:.17e} in {:.15e} out {:.15e} p {:.15e}]",
            h.stop,
            h.time.to_f64(),
            h.approach,
            h.departure,
            h.impulse
        )
    })
}

/// Both runs in full, for one scene that is looked at.
pub fn print(case: &Case) {
    let reference = reference(case);
    println!(
        "horizon {:?}, rate {:e}, sizes {:e} {:e}",
        reference.horizon, reference.model.rate, reference.main.q_size, reference.main.v_size
    );
    for hit in reference.main.hits.iter().take(400) {
        println!("  referee {}", show(Some(hit)));
    }
    println!("  referee sticks {:?}", reference.main.sticks);
    println!("  referee chatters {:?}", reference.main.chatters);
    println!(
        "  referee doubts {:?}, stopped {:?}",
        reference.main.doubts, reference.main.stopped
    );
    match library(case, &case.scene().expect("a scene")) {
        Err(difference) => println!("library: {} {}", difference.class, difference.detail),
        Ok(run) => {
            for hit in seen(case, &run).0.iter().take(400) {
                println!("  library {}", show(Some(hit)));
            }
            for segment in run
                .segments()
                .expect("kept")
                .iter()
                .filter(|s| s.kind != SegmentKind::Flight)
            {
                println!("  library {segment:?}");
            }
            for graze in run.grazes().iter().take(20) {
                println!("  library {graze:?}");
            }
            println!("  library {}", run.message());
        }
    }
}

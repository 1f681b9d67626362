//! The library's run beside the referee's: as far as the answer does not hang on rounding, impacts, lasting contact and states
//! must agree.

use crate::runs::case::{Case, MOST_IMPACTS};
use crate::runs::double_double::Dd;
use crate::runs::hits::{Counting, Drift, put_first};
use crate::runs::invariants;
use crate::runs::labels::Labels;
use crate::runs::lasting::compare_sticks;
use crate::runs::library::{library, seen};
use crate::runs::record::{Hit, Record, Stretch};
use crate::runs::reference::{FEW, MANY, Reference, allowance, reference};
use crate::runs::states::{Sides, compare_states};
use std::collections::VecDeque;
use std::time::Instant;
use vibroimpact::{Motion, SegmentKind, Status, Trajectory};

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

pub fn judge(case: &Case) -> Verdict {
    let scene = match case.scene() {
        Ok(scene) => scene,
        Err(error) => return Verdict::NoScene(error.to_string()),
    };
    let began = Instant::now();
    let mut reference = reference(case, FEW);
    if began.elapsed().as_secs_f64() > 1.0 {
        println!(
            "the referee took {:.1} s: {}",
            began.elapsed().as_secs_f64(),
            case.label
        );
    }
    let run = match library(case, &scene) {
        Ok(run) => run,
        Err(difference) if is_beyond(&difference, &reference) => {
            return Verdict::Agree(0.0, Some("a motion that grows beyond the largest number"));
        }
        Err(difference) if grows(&difference) && reference.horizon.1.is_some() => {
            // It may grow after what can be compared: that much is judged alone.
            let mut short = case.clone();
            short.span.1 = case.span.0 + reference.horizon.0;
            return judge(&short);
        }
        Err(difference) if difference.detail.contains("is inside stop") && case.starts_inside() => {
            return Verdict::NoScene(difference.detail);
        }
        Err(difference) => return Verdict::Disagree(vec![difference]),
    };
    let mut differences = invariants::check(case, &scene, &run, &reference);
    let mut compared = compare(case, &run, &reference);
    if compared.difference.is_some() {
        // Two runs beside it may have been near by chance.
        reference = crate::runs::reference::reference(case, MANY);
        compared = compare(case, &run, &reference);
    }
    if compared.difference.is_some() {
        // An impact of one may be left out just where one of the other is not; and what some runs aside show is an estimate.
        reference.wide = 2.0;
        compared = compare(case, &run, &reference);
    }
    differences.extend(compared.difference);
    let (end, why) = compared.end.unwrap_or(reference.horizon);
    if differences.is_empty() {
        Verdict::Agree(end / (case.span.1 - case.span.0), why)
    } else {
        Verdict::Disagree(differences)
    }
}

/// Whether the library says of a motion that it is too large for doubles, and it is.
fn is_beyond(difference: &Difference, reference: &Reference) -> bool {
    grows(difference) && reference.main.v_size.max(reference.main.q_size) > 1e250
}

/// Whether the library says of a motion that it is too large for doubles.
fn grows(difference: &Difference) -> bool {
    let words = "grows beyond the largest number";
    difference.detail.contains(words)
}

/// The first difference found, by its time.
#[derive(Default)]
pub struct First(Option<(f64, Difference)>);

impl First {
    pub fn report(&mut self, time: f64, class: impl Into<String>, detail: &str) {
        if self.0.as_ref().is_none_or(|f| time < f.0) {
            let (class, detail) = (class.into(), format!("at {time:e}: {detail}"));
            self.0 = Some((time, Difference { class, detail }));
        }
    }
}

/// What a comparison found.
pub struct Compared {
    pub difference: Option<Difference>,
    /// Where it ended before the horizon, and why.
    end: Option<(f64, Option<&'static str>)>,
}

fn compare(case: &Case, run: &Trajectory, reference: &Reference) -> Compared {
    let theirs = seen(case, run, &reference.model);
    compare_with(case, run, reference, &theirs)
}

/// What the library saw beside what the referee did.
pub fn compare_with(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
    theirs: &Record,
) -> Compared {
    let main = &reference.main;
    let counting = reference.counting(case);
    let (tick, slack) = (counting.tick(), counting.slack());
    // Up to here decisions are compared; an impact just before the horizon may be just behind it.
    let (horizon, _) = reference.horizon;
    let apart = apart_before(reference) / reference.model.rate;
    let just_before = |end: f64| end * (1.0 - 1e-9) - apart - 2.0 * tick;
    let mut until = just_before(horizon);
    let mut end = None;
    let mut first = First::default();
    let is_short = match run.status() {
        Status::Finished => run.span().1 != case.span.1,
        Status::MaxImpacts => run.impacts().len() < MOST_IMPACTS,
        _ => false,
    };
    if is_short {
        first.report(0.0, "ends early", run.message());
    }
    let reached = (Dd::from(run.span().1) - Dd::from(case.span.0)).to_f64();
    if run.status() == Status::MaxImpacts {
        until = until.min(just_before(reached));
    }
    if !matches!(run.status(), Status::Finished | Status::MaxImpacts) && reached < until {
        let class = format!("status {}", run.status().name());
        first.report(reached, class, run.message());
    }
    let mut dark = theirs.chatters.iter();
    if let Some(chatter) = dark.find(|c| counting.ends_in_the_dark(c, &main.hits))
        && chatter.start < until
    {
        until = just_before(chatter.start);
        end = Some((chatter.start, Some("flights as low as gaps are known to")));
    }
    let chatters = [&main.chatters[..], &theirs.chatters[..]];
    let sticks = [&main.sticks[..], &theirs.sticks[..]];
    let my_hits = counting.counted(&main.hits, &chatters, &sticks);
    let their_hits = counting.counted(&theirs.hits, &chatters, &sticks);
    // What each completion of accumulating impacts may cost: a few tolerances.
    let completed = |time: f64| {
        let count = theirs.chatters.iter().filter(|c| c.start <= time).count();
        20.0 * case.rtol.max(1e-14) * count as f64
    };
    let hits = (&my_hits[..], &their_hits[..]);
    let ends = [chatters.concat(), sticks.concat()].concat();
    let (drifts, rounding) = compare_hits(
        case,
        reference,
        hits,
        (until, &ends),
        &completed,
        &mut first,
    );
    if let Some(time) = rounding {
        until = time;
        end = Some((time, Some("an impact that is one of rounding")));
    }
    let labels = Labels {
        case,
        run,
        reference,
        theirs: &theirs.sticks,
    };
    compare_sticks(
        case,
        reference,
        (&theirs.sticks, &theirs.chatters),
        (until, slack),
        &labels,
        &mut first,
    );
    let sides = Sides {
        run,
        theirs,
        hits: &my_hits,
        drifts: &drifts,
    };
    compare_states(
        case,
        reference,
        &sides,
        until.min(reached),
        &completed,
        &mut first,
    );
    Compared {
        difference: first.0.map(|f| f.1),
        end,
    }
}

/// How long before the horizon, in radians of the fastest motion, a run has parted that has a few times the errors of the runs aside: as
/// long as these parted before the impact at which they did.
fn apart_before(reference: &Reference) -> f64 {
    let (horizon, reason) = reference.horizon;
    if reason.is_none() {
        return 1e-6;
    }
    let times = reference.main.hits.iter().map(|hit| hit.time.to_f64());
    let parted = times.map(|time| time - horizon).find(|since| *since >= 0.0);
    let radians = reference.model.rate * parted.unwrap_or(0.0);
    (3.0 * radians.min(1e-2)).max(1e-3)
}

/// Impacts that count, the referee's and the library's. Returns their times, and what rounding of the gaps has done to speeds; and the
/// time of one of rounding, which ends the comparison.
fn compare_hits(
    case: &Case,
    reference: &Reference,
    (mine, theirs): (&[Hit], &[Hit]),
    (until, ends): (f64, &[Stretch]),
    completed: &dyn Fn(f64) -> f64,
    first: &mut First,
) -> (Vec<(f64, f64)>, Option<f64>) {
    let (counting, rate) = (reference.counting(case), reference.model.rate);
    let mut drift = Drift::new(case.stops.len());
    let mut recent = Recent::default();
    let mut drifts = Vec::new();
    let beside = Beside::new(reference, &counting);
    let slowness = |hit: &Hit| slowness(case, reference, &counting, hit);
    let is_graze = |hit: &Hit| is_graze(case, reference, &counting, hit);
    let (mut i, mut j) = (0, 0);
    let mut known = 0.0;
    let mut theirs = theirs.to_vec();
    while i < mine.len() || j < theirs.len() {
        if let Some(a) = mine.get(i) {
            put_first(&mut theirs[j..], a, counting.slack() + slowness(a));
        }
        let (a, b) = (mine.get(i), theirs.get(j));
        let time = |h: Option<&Hit>| h.map_or(f64::INFINITY, |h| h.time.to_f64());
        if time(a).min(time(b)) >= until {
            break;
        }
        let apart = (time(a) - time(b)).abs();
        let aside = |f: &dyn Fn(&Hit) -> f64| a.map_or(0.0, |a| beside.off(a, f));
        let window = 1e-3 / rate + counting.tick() + known + a.map_or(0.0, slowness);
        let is_same = a.zip(b).is_some_and(|(a, b)| a.stop == b.stop)
            && apart < window + 1e2 * aside(&|h| h.time.to_f64());
        let details = || format!("impact {i}: referee {}, library {}", show(a), show(b));
        if !is_same {
            let is_mine = time(a) <= time(b);
            let hit = if is_mine { a } else { b }.expect("the earlier one");
            // However slow, what an impact in a dip changes may grow; and of impacts nearer to each other than their times are known,
            // nobody knows how many there are.
            let earlier = if is_mine { &mine[..i] } else { &theirs[..j] };
            let since = |last: &Hit| (hit.time - last.time).to_f64();
            let are_near = earlier.last().is_some_and(|last| since(last) < known);
            if is_graze(hit) || are_near {
                return (drifts, Some(hit.time.to_f64()));
            }
            if hit.approach < 10.0 * counting.speed_floor(hit.stop)
                || counting.may_be_completed(hit, ends)
                || is_shared(mine, hit, counting.slack())
            {
                (i, j) = if is_mine { (i + 1, j) } else { (i, j + 1) };
                continue;
            }
            let what = if is_mine { "missed" } else { "extra" };
            let shallow = shallowness(case, reference, hit, counting.reach(hit.stop));
            let class = format!("impact {what}{shallow}");
            first.report(hit.time.to_f64(), class, &details());
            break;
        }
        // What one of them is about to do with others is not looked at.
        if time(a).max(time(b)) >= until {
            break;
        }
        let (a, b) = (a.expect("same"), b.expect("same"));
        if case.by_method(false, true) && is_graze(a) {
            return (drifts, Some(a.time.to_f64()));
        }
        let (late, fast) = drift.next(&counting, a, i.checked_sub(1).map(|k| &mine[k]));
        known = 10.0 * late;
        let base = allowance(case).base + completed(a.time.to_f64());
        let [speed_aside, time_aside, impulse_aside] = recent.most([
            aside(&|h| h.approach),
            aside(&|h| h.time.to_f64()),
            aside(&|h| h.impulse),
        ]);
        let times = biased(case, reference, i, a.time.to_f64());
        let speed_allowed = times * speed_aside
            + 4.0 * fast
            + base * reference.v_unit * counting.reach(a.stop) * 10.0;
        let time_allowed = times * time_aside
            + counting.tick()
            + 4.0 * late
            + 10.0 * base * (reference.q_unit * counting.reach(a.stop) / a.approach + 1.0 / rate);
        let near = |h: &&Hit| (h.time - a.time).abs().to_f64() <= counting.slack();
        let together = mine.iter().filter(near).map(|h| h.stop);
        let push = (reference.model).impulse_of_speeds(together.collect(), a.stop);
        let impulse_allowed = times * impulse_aside + 4.0 * speed_allowed * push;
        let time = a.time.to_f64();
        let mut differs = |class: &str, off: f64, allowed: f64| {
            if off > reference.wide * allowed {
                let detail = format!("{off:e} off, allowed {allowed:e}; {}", details());
                first.report(time, class, &detail);
            }
        };
        differs("impact time", apart, time_allowed);
        differs(
            "speed before",
            (a.approach - b.approach).abs(),
            speed_allowed,
        );
        differs(
            "speed after",
            (a.departure - b.departure).abs(),
            speed_allowed,
        );
        if is_comparable([&reference.main.hits, &theirs], [a, b], counting.slack()) {
            differs("impulse", (a.impulse - b.impulse).abs(), impulse_allowed);
        }
        drifts.push((time, 4.0 * fast));
        (i, j) = (i + 1, j + 1);
    }
    (drifts, None)
}

/// What is said of an impact that hardly goes beyond its stop.
fn shallowness(case: &Case, reference: &Reference, hit: &Hit, n: f64) -> &'static str {
    let relative = case.rtol.clamp(1e-15, 1e-9) * reference.main.q_size;
    let is_shallow = depth(reference, hit, n) < 20.0 * n * (case.atol + relative);
    if is_shallow { ", shallow" } else { "" }
}

/// Deviations of the last few impacts: one alone may be small by chance.
#[derive(Default)]
struct Recent(VecDeque<[f64; 3]>);

impl Recent {
    /// The largest of each kind, with those of one more impact.
    fn most(&mut self, deviations: [f64; 3]) -> [f64; 3] {
        self.0.push_back(deviations);
        if self.0.len() > 8 {
            self.0.pop_front();
        }
        [0, 1, 2].map(|k| self.0.iter().map(|d| d[k]).fold(0.0, f64::max))
    }
}

/// How many times farther than the runs aside an answer may be off after some impacts and time: their errors are at random and add
/// up as roots do, those of an answer, made at each impact and in each step, may all have one sign. Steps change the energy of a motion
/// beside the stop at which it began, which these runs keep.
pub fn biased(case: &Case, reference: &Reference, n_impacts: usize, since: f64) -> f64 {
    let n_steps = case.by_method(0.0, reference.model.rate * since);
    (n_impacts as f64 + n_steps)
        .sqrt()
        .max(case.by_method(10.0, 10.0 + 2.0 * n_impacts as f64))
}

/// The impacts of the runs aside.
struct Beside {
    hits: Vec<Vec<Hit>>,
    /// Impacts farther away from one than this are others: a run that has completed it earlier has none.
    near: f64,
}

impl Beside {
    fn new(reference: &Reference, counting: &Counting<'_>) -> Self {
        let main = &reference.main;
        let hits = reference.aside.iter().map(|r| {
            let chatters = [r.chatters.clone(), main.chatters.clone()].concat();
            counting.counted(&r.hits, &[&chatters], &[&r.sticks, &main.sticks])
        });
        Self {
            hits: hits.collect(),
            near: 2e-3 / counting.rate + counting.tick(),
        }
    }

    /// How far they are off an impact in some quantity.
    fn off(&self, a: &Hit, quantity: &dyn Fn(&Hit) -> f64) -> f64 {
        let apart = |h: &&Hit| (h.time.to_f64() - a.time.to_f64()).abs();
        let nearest = self.hits.iter().filter_map(|hits| {
            let same = hits.iter();
            let same = same.filter(|h| h.stop == a.stop && apart(h) < self.near);
            same.min_by(|x, y| apart(x).total_cmp(&apart(y)))
        });
        nearest.fold(0.0, |most: f64, h| {
            most.max((quantity(h) - quantity(a)).abs())
        })
    }
}

/// Whether dependent stops shared impulses at the instant of an impact: which of them carries it is nobody's, and the motion after
/// it shows whether all is carried.
fn is_shared(hits: &[Hit], hit: &Hit, slack: f64) -> bool {
    let is_at = |h: &&Hit| (h.time.to_f64() - hit.time.to_f64()).abs() <= slack;
    hits.iter().filter(is_at).any(|h| h.rounds == 0)
}

/// Whether the impulse of an impact is somebody's in both runs. Of several stops hit at one instant only the sum of what they do
/// is anybody's; of independent ones each, where both runs have them at one time.
fn is_comparable(all: [&[Hit]; 2], same: [&Hit; 2], slack: f64) -> bool {
    let since = same[0].time.to_f64();
    let near = |hits: &[Hit]| -> Vec<Hit> {
        let is_near = |h: &&Hit| (h.time.to_f64() - since).abs() <= slack;
        hits.iter().filter(is_near).cloned().collect()
    };
    let [mine, theirs] = all.map(near);
    let is_one = |hits: &[Hit], t: Dd| hits.iter().all(|h| h.rounds > 0 && h.time == t);
    let is_alone = same[0].rounds == 1 && mine.len() < 2 && theirs.len() < 2;
    let is_whole = same[0].rounds > 0
        && mine.len() == theirs.len()
        && is_one(&mine, same[0].time)
        && is_one(&theirs, same[1].time);
    is_alone || is_whole
}

/// To what the time of a slow impact is known.
pub fn slowness(case: &Case, reference: &Reference, counting: &Counting<'_>, hit: &Hit) -> f64 {
    10.0 * allowance(case).base * reference.q_unit * counting.reach(hit.stop) / hit.approach
}

/// Whether a dip is so shallow that it is one of the errors of the motion.
fn is_graze(case: &Case, reference: &Reference, counting: &Counting<'_>, hit: &Hit) -> bool {
    let depth = depth(reference, hit, counting.reach(hit.stop));
    hit.curvature > 0.0 && depth < allowance(case).base * counting.size(hit.stop)
}

/// How deep a stop is passed without its impact.
fn depth(reference: &Reference, hit: &Hit, normal_size: f64) -> f64 {
    let bend = if hit.curvature.is_finite() {
        hit.curvature
    } else {
        reference.main.v_size * reference.model.rate * normal_size
    };
    hit.approach.powi(2) / (2.0 * bend.abs().max(1e-300))
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
    let reference = reference(case, FEW);
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
    for aside in &reference.aside {
        println!("  aside sticks {:?}", aside.sticks);
        println!("  aside chatters {:?}", aside.chatters);
    }
    match library(case, &case.scene().expect("a scene")) {
        Err(difference) => println!("library: {} {}", difference.class, difference.detail),
        Ok(run) => {
            for hit in seen(case, &run, &reference.model).hits.iter().take(400) {
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
            if let (Ok(energy), Ok(times)) = (run.energy(), run.sample_times()) {
                for (k, w) in energy.impact_loss.windows(2).enumerate() {
                    if w[1] < w[0] {
                        let t = [times[k], times[k + 1]].map(|t| t - case.span.0);
                        println!("  library loses {:e} at impacts in {t:?}", w[1] - w[0]);
                    }
                }
            }
        }
    }
}

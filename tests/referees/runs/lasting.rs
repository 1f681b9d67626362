//! Lasting contact, the library's beside the referee's.

use crate::runs::case::{Case, StopCase};
use crate::runs::compare::{First, slowness};
use crate::runs::labels::Labels;
use crate::runs::motion::Model;
use crate::runs::record::{Hit, Stretch};
use crate::runs::reference::Reference;
use crate::runs::simulator::AHEAD;
use vibroimpact::Method;

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

/// Lasting contacts longer than rounding, by their starts; what goes on at the same plane is one. Between two stops that face
/// each other without room a flight is one of rounding, however long it takes: `breaks` are those that are overlooked.
fn long(sticks: &[Stretch], shortest: f64, breaks: &dyn Fn(usize) -> f64) -> Vec<Stretch> {
    let mut kept: Vec<Stretch> = Vec::new();
    for stick in sticks {
        if let Some(last) = kept.iter_mut().rev().find(|s| s.stop == stick.stop)
            && stick.start - last.end <= shortest.max(breaks(stick.stop))
        {
            last.end = last.end.max(stick.end);
        } else {
            kept.push(stick.clone());
        }
    }
    kept.retain(|s| s.end - s.start > 1e3 * shortest);
    put_in_order(&mut kept, shortest);
    kept
}

/// Puts lasting contacts in the order of their starts, those that begin together in that of their stops.
fn put_in_order(sticks: &mut [Stretch], together: f64) {
    sticks.sort_by(|a, b| a.start.total_cmp(&b.start));
    let begin_together = |a: &Stretch, b: &Stretch| b.start - a.start <= together;
    for group in sticks.chunk_by_mut(begin_together) {
        group.sort_by_key(|s| s.stop);
    }
}

/// Joins a lasting contact with the next one at its plane, where it breaks for hardly longer than what counts: the other run has had
/// less. Whether there is such a one.
fn go_on((sticks, place): (&mut Vec<Stretch>, usize), shortest: f64) -> bool {
    let Stretch { stop, end, .. } = sticks[place];
    let is_next = |s: &Stretch| s.stop == stop && s.start - end <= shortest;
    let Some(next) = sticks[place + 1..].iter().position(is_next) else {
        return false;
    };
    sticks[place].end = sticks.remove(place + 1 + next).end;
    true
}

/// Leaves out the first lasting contact of one of two runs up to a time.
fn begin_later(
    (mine, theirs): (&mut [Stretch], &mut [Stretch]),
    is_mine: bool,
    start: f64,
    together: f64,
) {
    let sticks = if is_mine { mine } else { theirs };
    sticks[0].start = start;
    put_in_order(sticks, together);
}

/// Lasting contacts by planes. The referee decides what stays in contact by what is so a little ahead: a contact that opens and
/// closes meanwhile is one that lasts, to it.
pub fn planes(case: &Case, sticks: &[Stretch], shortest: f64, model: &Model) -> Vec<Stretch> {
    let faces_another = |plane: usize| {
        let one = |stop: usize| Stretch {
            stop,
            start: 0.0,
            end: 0.0,
        };
        let same = |stop: usize| {
            plane < case.stops.len() && on_planes(case, &[one(stop)])[0].stop == plane
        };
        (0..case.stops.len()).filter(|&i| same(i)).count() > 1
    };
    let breaks = |plane: usize| {
        if faces_another(plane) {
            1e-4 / model.rate
        } else {
            AHEAD * model.step
        }
    };
    long(&on_planes(case, sticks), shortest, &breaks)
}

/// To what the time is known of the impacts with which a lasting contact begins.
fn slowness_at(reference: &Reference, case: &Case, stick: &Stretch) -> f64 {
    let counting = reference.counting(case);
    let is_there = |h: &&Hit| (h.time.to_f64() - stick.start).abs() <= counting.slack();
    let hits = reference.main.hits.iter().filter(is_there);
    hits.map(|h| slowness(case, reference, &counting, h))
        .fold(0.0, f64::max)
}

/// How long the impacts take that lead to a lasting contact and may be completed; in doubles flights as high as the gap is known to may
/// follow each other there.
fn rest_before(reference: &Reference, case: &Case, stick: &Stretch) -> f64 {
    let counting = reference.counting(case);
    let plane = on_planes(case, std::slice::from_ref(stick))[0].stop;
    let of_plane = |stop: usize| {
        let one = Stretch {
            stop,
            ..stick.clone()
        };
        on_planes(case, &[one])[0].stop == plane
    };
    let hits = reference.main.hits.iter().rev();
    let (mut first, mut unseen) = (stick.start, 0.0f64);
    for hit in
        hits.filter(|h| h.time.to_f64() <= stick.start + counting.slack() && of_plane(h.stop))
    {
        let Some(rest) = counting.rest(hit) else {
            break;
        };
        // A series ends where the flight that follows is one of its own.
        let flights = 3.0 * rest + counting.lowest(hit) + counting.slack();
        if first - hit.time.to_f64() > flights {
            break;
        }
        first = hit.time.to_f64();
        unseen = unseen.max(counting.lowest(hit));
    }
    (stick.start - first).max(unseen)
}

/// Lasting contacts of the referee's run, where those are one that part for a touch: a stop that closes again at no speed.
fn without_touches(case: &Case, reference: &Reference, sticks: Vec<Stretch>) -> Vec<Stretch> {
    let counting = reference.counting(case);
    let floor = |h: &Hit| 10.0 * counting.speed_floor(h.stop);
    let is_touched = |last: &Stretch, stick: &Stretch| {
        let (from, to) = (last.end - counting.slack(), stick.start + counting.slack());
        let is_between = |h: &&Hit| (from..=to).contains(&h.time.to_f64());
        let mut struck = reference.main.hits.iter().filter(is_between).peekable();
        struck.peek().is_some() && struck.all(|h| h.approach < floor(h))
    };
    let mut joined: Vec<Stretch> = Vec::new();
    for stick in sticks {
        let before = joined.iter_mut().rev().find(|s| s.stop == stick.stop);
        match before {
            Some(last)
                if stick.start - last.end < 1.0 / reference.model.rate
                    && is_touched(last, &stick) =>
            {
                last.end = stick.end;
            }
            _ => joined.push(stick),
        }
    }
    joined
}

/// The longest of the accumulations that end about a time: where they are completed early, their end is known to a part of that.
fn longest(chatters: &[Stretch], time: f64) -> f64 {
    let length = |c: &Stretch| c.end - c.start;
    let about = chatters
        .iter()
        .filter(|c| (c.end - time).abs() <= 2.0 * length(c));
    about.map(length).fold(0.0, f64::max)
}

/// Whether a time is one of a series of accumulating impacts that the library has completed, and might have.
fn is_completed(reference: &Reference, case: &Case, chatters: &[Stretch], time: f64) -> bool {
    let counting = reference.counting(case);
    let is_of_series = |h: &Hit| {
        let since = time - h.time.to_f64();
        let lasts = |rest: f64| since >= -counting.slack() && since <= 3.0 * rest;
        counting.rest(h).is_some_and(lasts) && counting.may_be_completed(h, chatters)
    };
    reference.main.hits.iter().any(is_of_series)
}

/// When another run has a stop in contact again within a span, if the contact up to there is nobody's.
fn nobodys_until(
    labels: &Labels<'_>,
    stop: usize,
    (from, to): (f64, f64),
    others: &[Stretch],
    is_mine: bool,
) -> Option<f64> {
    let is_again = |s: &&Stretch| s.stop == stop && s.start > from && s.start < to;
    let again = others.iter().find(is_again)?.start;
    let is_one = stop < labels.case.stops.len();
    (is_one && labels.is_nobodys(stop, (from, again), is_mine)).then_some(again)
}

/// The lasting contact of another run that is the same one: of those at its stop the one that begins nearest to it.
fn nearest<'a>(sticks: &'a [Stretch], one: &Stretch) -> Option<&'a Stretch> {
    let apart = |s: &Stretch| (s.start - one.start).abs();
    let same = sticks.iter().filter(|s| s.stop == one.stop);
    same.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// Whether another run has a lasting contact at the same stop among those that begin no later.
fn begins_with(one: &Stretch, sticks: &[Stretch], together: f64) -> bool {
    let mut first = sticks
        .iter()
        .take_while(|s| s.start - one.start <= together);
    first.any(|s| s.stop == one.stop)
}

/// To what part of a radian times are known: a series that is completed is known to the tolerance, and so is what follows it.
fn known_to(case: &Case, chatters: &[Stretch], time: f64) -> f64 {
    if case.method == Method::Exact && chatters.iter().all(|c| c.start > time) {
        1e-10
    } else {
        (10.0 * case.rtol).max(1e-10)
    }
}

pub fn compare_sticks(
    case: &Case,
    reference: &Reference,
    (theirs, chatters): (&[Stretch], &[Stretch]),
    (until, slack): (f64, f64),
    labels: &Labels<'_>,
    first: &mut First,
) {
    let by_plane = |sticks: &[Stretch]| planes(case, sticks, slack, &reference.model);
    let (mut mine, mut theirs) = (by_plane(&reference.main.sticks), by_plane(theirs));
    mine = without_touches(case, reference, mine);
    let beside: Vec<Vec<Stretch>> = reference
        .aside
        .iter()
        .map(|r| by_plane(&r.sticks))
        .collect();
    let rate = reference.model.rate;
    // What begins just before the horizon may go on behind it, in pieces that make one.
    let until = until - 1e2 * slack;
    let (mut k, mut j) = (0, 0);
    while k < mine.len() || j < theirs.len() {
        let (a, b) = (mine.get(k), theirs.get(j));
        let start = |s: Option<&Stretch>| s.map_or(f64::INFINITY, |s| s.start);
        if start(a).min(start(b)) >= until {
            return;
        }
        let details = format!("lasting contact {k}: referee {a:?}, library {b:?}");
        let is_same = a.zip(b).is_some_and(|(a, b)| {
            a.stop == b.stop
                && (a.start - b.start).abs() < 1e-3 / rate + rest_before(reference, case, a)
        });
        if !is_same {
            // Of two that begin together it is the one that the other run does not have.
            let is_theirs = a.is_some_and(|a| begins_with(a, &theirs[j..], slack));
            let is_mine = start(a) <= start(b) && !is_theirs;
            // One that is hardly longer than what counts at all may be shorter than that in the other run.
            let one = if is_mine { a } else { b }.expect("the earlier one");
            // Which of dependent stops are held where nothing moves is nobody's.
            let is_label = one.stop < case.stops.len()
                && labels.is_nobodys(one.stop, (one.start, one.end.min(until)), is_mine);
            // What is nobody's up to where the other run's begins leaves the rest to be compared.
            let others = if is_mine { &theirs[j..] } else { &mine[k..] };
            let span = (one.start, one.end.min(until));
            if let Some(start) = nobodys_until(labels, one.stop, span, others, is_mine) {
                begin_later((&mut mine[k..], &mut theirs[j..]), is_mine, start, slack);
                continue;
            }
            // Where impacts of several stops accumulate, what they throw off meanwhile rests with them in the run that completes them.
            let rests = |s: &Stretch| s.stop == one.stop && s.end >= one.end.min(until);
            let is_thrown = is_mine
                && theirs[..j].iter().any(rests)
                && is_completed(reference, case, chatters, one.start);
            if is_label || is_thrown || one.end - one.start < 1e4 * slack {
                (k, j) = if is_mine { (k + 1, j) } else { (k, j + 1) };
                continue;
            }
            let class = if is_mine {
                "lasting contact missed"
            } else {
                "lasting contact extra"
            };
            return first.report(start(a).min(start(b)), class, &details);
        }
        let (a, b) = (mine[k].clone(), theirs[j].clone());
        let aside = |f: &dyn Fn(&Stretch) -> f64| {
            beside
                .iter()
                .filter_map(|r| nearest(r, &a))
                .map(|s| (f(s) - f(&a)).abs())
                .fold(0.0, f64::max)
        };
        // A force that falls slowly ends at a time as uncertain as the force is over its slope: the runs aside know.
        let allowed = |f: &dyn Fn(&Stretch) -> f64| {
            reference.wide
                * (100.0 * (aside(f) + known_to(case, chatters, f(&a).max(f(&b))) / rate)
                    + 10.0 * slack)
        };
        let early = 0.1 * longest(chatters, a.start.max(b.start))
            + rest_before(reference, case, &a)
            + slowness_at(reference, case, &a);
        let is_late = (a.start - b.start).abs() > allowed(&|s| s.start) + early;
        let late = (a.start.min(b.start), a.start.max(b.start));
        if is_late && !labels.is_nobodys(a.stop, late, a.start < b.start) {
            return first.report(a.start, "start of lasting contact", &details);
        }
        let (sooner, later) = (a.end.min(b.end), a.end.max(b.end).min(until));
        let differs = later - sooner > allowed(&|s| s.end);
        let is_mine = a.end > b.end;
        let shorter = if is_mine {
            (&mut theirs, j)
        } else {
            (&mut mine, k)
        };
        if differs && go_on(shorter, 2.0 * slack) {
            continue;
        }
        if differs && !labels.is_nobodys(a.stop, (sooner, later), is_mine) {
            // The other run may have it again: only what lies between is nobody's then.
            let others = if is_mine {
                &theirs[j + 1..]
            } else {
                &mine[k + 1..]
            };
            let span = (sooner, later);
            if let Some(again) = nobodys_until(labels, a.stop, span, others, is_mine) {
                begin_later((&mut mine[k..], &mut theirs[j..]), is_mine, again, slack);
                (k, j) = if is_mine { (k, j + 1) } else { (k + 1, j) };
                continue;
            }
            return first.report(sooner, "end of lasting contact", &details);
        }
        (k, j) = (k + 1, j + 1);
    }
}

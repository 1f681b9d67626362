//! Wrong impacts put into what the library saw: the comparison must find each. What is small beside the motion, or lies where it
//! hangs on rounding, is left as it is.

use crate::runs::case::Case;
use crate::runs::compare::compare_with;
use crate::runs::double_double::Dd;
use crate::runs::hits::Counting;
use crate::runs::library::{library, seen};
use crate::runs::record::{Hit, Record};
use crate::runs::reference::{MANY, Reference, reference};
use vibroimpact::Trajectory;

/// By how much of itself, or of the fastest motion's time, a number is changed.
const CHANGE: f64 = 1e-3;
const SCENES: u64 = 80;
/// An impact is changed whose speed is this part of the motion's, and which is as far from others in the fastest motion's times.
const PLAIN: f64 = 1e-2;

type Alteration = (&'static str, fn(&mut Vec<Hit>, usize, f64));

/// Changes of the impact at a place, with a short time.
const OF_HITS: [Alteration; 7] = [
    ("later", |hits, k, by| hits[k].time += Dd::from(by)),
    ("earlier", |hits, k, by| hits[k].time += Dd::from(-by)),
    ("approach", |hits, k, _| hits[k].approach *= 1.0 + CHANGE),
    ("departure", |hits, k, _| {
        hits[k].departure += CHANGE * hits[k].approach;
    }),
    ("impulse", |hits, k, _| hits[k].impulse *= 1.0 - CHANGE),
    ("lost", |hits, k, _| {
        hits.remove(k);
    }),
    ("invented", |hits, k, by| {
        let mut other = hits[k].clone();
        other.time += Dd::from(10.0 * by);
        hits.insert(k + 1, other);
    }),
];

/// The first impact that is fast, alone and before anything hangs on rounding.
fn plain_hit(hits: &[Hit], counting: &Counting<'_>, until: f64) -> Option<usize> {
    let apart = |a: &Hit, b: &Hit| (a.time - b.time).abs().to_f64() * counting.rate > 10.0 * PLAIN;
    (0..hits.len()).find(|&k| {
        let hit = &hits[k];
        // One that is stopped is also the begin of its contact.
        let is_fast = hit.approach > PLAIN * counting.v_unit && hit.departure > 0.0;
        let mut others = hits.iter().enumerate().filter(|(i, _)| *i != k);
        hit.time.to_f64() < until && is_fast && others.all(|(_, h)| apart(h, hit))
    })
}

/// The alterations of an impact that are not found.
fn missed(
    case: &Case,
    (run, seen): (&Trajectory, &Record),
    reference: &Reference,
    k: usize,
) -> Vec<&'static str> {
    let by = CHANGE / reference.model.rate;
    let is_missed = |(name, alter): &Alteration| {
        let mut altered = seen.clone();
        alter(&mut altered.hits, k, by);
        let found = compare_with(case, run, reference, &altered);
        found.difference.is_none().then_some(*name)
    };
    OF_HITS.iter().filter_map(is_missed).collect()
}

#[test]
fn wrong_impacts_are_found() {
    let mut all = Vec::new();
    for number in 0..SCENES {
        let case = crate::runs::generator::scene(7, number);
        let run = (case.scene().ok()).and_then(|scene| library(&case, &scene).ok());
        let Some(run) = run else { continue };
        let reference = reference(&case, MANY);
        let seen = seen(&case, &run, &reference.model);
        let until = 0.9 * reference.horizon.0;
        let plain = plain_hit(&seen.hits, &reference.counting(&case), until);
        all.extend(plain.map(|k| (number, missed(&case, (&run, &seen), &reference, k))));
    }
    assert!(all.len() > SCENES as usize / 4, "{} impacts", all.len());
    all.retain(|(_, missed)| !missed.is_empty());
    assert!(all.is_empty(), "{all:?}");
}

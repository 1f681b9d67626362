//! Branches of pendulum chains: their orbits, verdicts and multipliers at points of them, and what happens between points.

use crate::branches::body::{Body, Number};
use crate::branches::condition;
use crate::branches::counts;
use crate::branches::draw;
use crate::branches::flights::misses;
use crate::branches::library::{followed, settled};
use crate::branches::look::Look;
use crate::branches::map::{Map, difference};
use crate::branches::rules::{Verdict, verdict};
use crate::branches::tally::Tally;
use crate::random::Random;
use vibroimpact::{Branch, ContinuationOptions, PeriodicOrbit, Special, SpecialKind, Virtual};

/// A motion closes to 1e-11 of its size, and so do its flights but for what they make of their start.
const CLOSED: f64 = 1e-9;
/// Differences of fourth order, in parts of their largest entry.
const MEASURED: f64 = 1e-6;
/// So well a special point is known by what changes its sign there.
const SPECIAL: f64 = 2e-6;

/// The points of a branch that are looked at.
fn places(random: &mut Random, branch: &Branch) -> Vec<usize> {
    let count = branch.orbits.len();
    let mut places = vec![0, random.below(count), count - 1];
    places.sort_unstable();
    places.dedup();
    places
}

/// An orbit against the referee's own motion, its rules and its map.
pub fn check_orbit(orbit: &PeriodicOrbit, body: &Body, tally: &mut Tally) -> Result<(), String> {
    let look = match Look::new(orbit, body) {
        Ok(look) => look,
        Err(why) => {
            tally.left_out(why);
            return Ok(());
        }
    };
    let off = misses(&look);
    tally.saw("orbits", off.worst());
    let map = Map::new(&look);
    if off.worst() > CLOSED {
        return Err(format!("{off:?}, allowed {CLOSED:e}"));
    }
    check_rules(&look, tally)?;
    let Some(map) = map else {
        tally.left_out("an orbit that never flies");
        return Ok(());
    };
    check_multipliers(&look, &map, tally)
}

fn check_rules(look: &Look<'_>, tally: &mut Tally) -> Result<(), String> {
    let (mine, theirs) = (verdict(look), look.orbit.is_admissible());
    let agrees = match mine {
        Verdict::Broken(_) => theirs == Some(false),
        Verdict::Kept => theirs != Some(false),
        Verdict::Unclear => true,
    };
    match mine {
        Verdict::Broken(_) => tally.saw("broken rules", 0.0),
        Verdict::Kept => tally.saw("kept rules", 0.0),
        Verdict::Unclear => tally.left_out("rules that are nearly broken"),
    }
    if agrees {
        return Ok(());
    }
    let why = look.orbit.violation();
    Err(format!("{mine:?}, library {theirs:?}: {why:?}"))
}

fn check_multipliers(look: &Look<'_>, map: &Map<'_, '_>, tally: &mut Tally) -> Result<(), String> {
    let stability = look.orbit.stability().map_err(|error| error.to_string())?;
    let Some(order) = stability.orders.first() else {
        tally.left_out("an orbit without multipliers");
        return Ok(());
    };
    let Some((mine, size)) = map.multipliers() else {
        tally.left_out("an impact too slow for differences");
        return Ok(());
    };
    let theirs: Vec<_> = order.multipliers.iter().copied().collect();
    let off = difference(&mine, &theirs);
    tally.saw("multipliers", off);
    // Of a derivative with entries larger than its multipliers these are not as well known.
    let largest = mine.iter().map(|mu| mu.norm()).fold(1.0, f64::max);
    if off > MEASURED * (size / largest).max(1.0) {
        return Err(format!("multipliers {mine:?}, library {theirs:?}: {off:e}"));
    }
    Ok(())
}

/// A special point against the referee's own motion.
fn check_special(special: &Special, body: &Body, tally: &mut Tally) -> Result<(), String> {
    if special.kind == SpecialKind::Corner {
        let orbit = &special.orbit;
        let off = condition::cornered(orbit, &Look::alone(orbit, body), special.stop);
        let off = off.ok_or("a corner without an impact")?;
        tally.saw("corner", off);
        let wrong = format!("a corner at {} is off by {off:e}", special.parameter);
        return if off > SPECIAL { Err(wrong) } else { Ok(()) };
    }
    let look = match Look::new(&special.orbit, body) {
        Ok(look) => look,
        Err(why) => {
            tally.left_out(why);
            return Ok(());
        }
    };
    match condition::miss(&look, special.kind, special.stop) {
        Err(why) => tally.left_out(why),
        Ok(off) => {
            tally.saw(special.kind.name(), off);
            if off > SPECIAL {
                let (kind, at) = (special.kind.name(), special.parameter);
                let least = condition::shortest(&look);
                return Err(format!(
                    "a {kind} at {at} is off by {off:e}, {least:e} of the period the shortest flight or stay"
                ));
            }
        }
    }
    Ok(())
}

/// The branch of a case, and what is wrong with it.
pub fn check(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let n = random.of(&[1, 1, 1, 1, 2, 2, 2, 2, 2, 3]);
    let body = draw::chain(n, random);
    let (number, range) = draw::number(random, &body);
    let options = ContinuationOptions {
        beyond: random.of(&[Virtual::Stop, Virtual::Keep]),
        // Points of chains of more links take long.
        max_points: 48 / n,
        ..Default::default()
    };
    let Some(orbit) = settled(random, &body, tally) else {
        return Ok(());
    };
    let branch = match followed(&orbit, &body, (number, range), &options) {
        Ok(branch) => branch,
        Err(error) => {
            tally.left_out("refused");
            tally.note(format!("refused: {error}"));
            return Ok(());
        }
    };
    check_branch(random, &branch, (&body, number), tally)
}

/// A branch over a number of a body.
fn check_branch(
    random: &mut Random,
    branch: &Branch,
    (body, number): (&Body, Number),
    tally: &mut Tally,
) -> Result<(), String> {
    for k in places(random, branch) {
        let there = body.with(number, branch.parameter[k]);
        let found = check_orbit(&branch.orbits[k], &there, tally);
        found.map_err(|wrong| format!("{number:?} = {}: {wrong}", branch.parameter[k]))?;
    }
    for special in branch.special.iter().take(4) {
        let there = body.with(number, special.parameter);
        check_special(special, &there, tally).map_err(|wrong| format!("{number:?}: {wrong}"))?;
    }
    let (wrong, [pairs, changes]) = counts::difference(branch);
    tally.count("pairs of points", pairs);
    tally.count("multipliers that crossed", changes);
    wrong.map_or(Ok(()), |wrong| Err(format!("{number:?}: {wrong}")))
}

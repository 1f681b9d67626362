//! Lasting contact that the impact on another stop ends: the contact force by the referee, over the whole of it, its end too.

use crate::branches::body::{Body, Number};
use crate::branches::draw;
use crate::branches::library::followed;
use crate::branches::look::Look;
use crate::branches::stepper::motion;
use crate::branches::tally::Tally;
use crate::random::Random;
use vibroimpact::{
    ContinuationOptions, ImpactSide, Motion, PeriodicOrbit, SegmentKind, SimulateOptions,
    SpecialKind, find_orbit, simulate,
};

/// Periods of the forcing that a motion settles in, and the most that its own takes.
const SETTLING: f64 = 80.0;
const MOST_PERIODS: usize = 3;
/// A force is below zero beyond doubt from this part of its largest on.
const CLEAR: f64 = 1e-7;
/// So well the place is known where it comes to zero.
const SPECIAL: f64 = 2e-6;
/// Instants nearer than this part of the period are one.
const TOGETHER: f64 = 1e-12;

/// A stay on one stop, and whether another stop's impact ends it.
struct Stay {
    stop: usize,
    start: f64,
    end: f64,
    is_cut: bool,
}

fn stays(orbit: &PeriodicOrbit) -> Vec<Stay> {
    let period = orbit.period();
    let all = orbit.segments().expect("a linear scene");
    let sticks = all.into_iter().filter(|own| own.kind == SegmentKind::Stick);
    sticks
        .filter_map(|own| {
            let stop = own.stop?;
            let cuts = orbit.impacts().iter().filter(|impact| {
                let late = (impact.time - own.end).rem_euclid(period);
                impact.stop != stop && late.min(period - late) <= TOGETHER * period
            });
            Some(Stay {
                stop,
                start: own.start,
                end: own.end,
                is_cut: cuts.count() > 0,
            })
        })
        .collect()
}

/// The least force of a stay, in parts of its largest; at a release of its own the end is left out.
fn least_force(look: &Look<'_>, stay: &Stay) -> f64 {
    let x = look.state(stay.start, false);
    let held = Some(stay.stop);
    let all = motion(&look.body, held, (stay.start, &x), stay.end);
    let count = all.len() - usize::from(!stay.is_cut);
    let forces: Vec<f64> = all[..count]
        .iter()
        .map(|(t, x)| look.body.acceleration(*t, x, held).1)
        .collect();
    let most = forces
        .iter()
        .fold(f64::MIN_POSITIVE, |most, own| most.max(own.abs()));
    forces
        .iter()
        .fold(f64::INFINITY, |least, own| least.min(own / most))
}

/// An orbit that a body comes to, with a stay that is cut.
fn cut_orbit(random: &mut Random, body: &Body) -> Option<PeriodicOrbit> {
    let scene = body.scene().expect("valid");
    let [q, v] = draw::start(random, body);
    let options = SimulateOptions {
        max_impacts: Some(4_000),
        ..Default::default()
    };
    let period = scene.period().expect("shaken");
    let run = simulate(&scene, &q, &v, (0.0, SETTLING * period), &options).ok()?;
    let at = |periods: usize| {
        let t = (SETTLING - periods as f64) * period;
        run.state(t, ImpactSide::After).ok()
    };
    let (q, v) = at(0)?;
    let is_back = |periods: usize| {
        at(periods).is_some_and(|(p, u)| {
            (p - &q).norm() < 0.01 * (1e-3 + q.norm()) && (u - &v).norm() < 0.01 * (1e-3 + v.norm())
        })
    };
    (1..=MOST_PERIODS).find(|periods| is_back(*periods))?;
    let found = find_orbit(&scene, &run, None).ok()?;
    let is_cut = stays(&found).iter().any(|own| own.is_cut);
    is_cut.then_some(found)
}

/// The branch of a case, and what is wrong with the verdicts on its stays.
pub fn check(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let body = draw::staying(random);
    let Some(orbit) = cut_orbit(random, &body) else {
        tally.left_out("no orbit with a stay that is cut");
        return Ok(());
    };
    let number = random.of(&[Number::Frequency, Number::Forcing, Number::Room(1)]);
    let range = draw::range(number, &body);
    let options = ContinuationOptions {
        max_points: 60,
        ..Default::default()
    };
    let Ok(branch) = followed(&orbit, &body, (number, range), &options) else {
        tally.left_out("refused");
        return Ok(());
    };
    for (orbit, value) in branch.orbits.iter().zip(&branch.parameter) {
        let look = Look::alone(orbit, &body.with(number, *value));
        for stay in stays(orbit) {
            let least = least_force(&look, &stay);
            tally.saw(if stay.is_cut { "cut stays" } else { "stays" }, 0.0);
            if least < -CLEAR && orbit.is_admissible() == Some(true) {
                return Err(format!(
                    "{number:?} = {value}: stop {} pulls by {least:e}, cut {}",
                    stay.stop, stay.is_cut
                ));
            }
        }
    }
    for rise in branch
        .special
        .iter()
        .filter(|own| own.kind == SpecialKind::Rise)
    {
        let look = Look::alone(&rise.orbit, &body.with(number, rise.parameter));
        let own = stays(&rise.orbit).into_iter();
        let least = own
            .map(|stay| least_force(&look, &stay))
            .fold(f64::INFINITY, f64::min);
        tally.saw("rises", least.abs());
        if least.abs() > SPECIAL {
            return Err(format!(
                "{number:?}: a rise at {} where it is {least:e}",
                rise.parameter
            ));
        }
    }
    Ok(())
}

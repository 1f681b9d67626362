//! Curves in two numbers: at their points the referee's own motion has what they are curves of.

use crate::branches::body::{Body, Number};
use crate::branches::condition;
use crate::branches::draw;
use crate::branches::flights::misses;
use crate::branches::library::{followed, followed_curve, settled};
use crate::branches::look::Look;
use crate::branches::rules::{Verdict, verdict};
use crate::branches::tally::Tally;
use crate::random::Random;
use vibroimpact::{
    BifurcationCurve, ContinuationOptions, OrbitOptions, Pattern, PeriodicOrbit, SpecialKind,
    Virtual, periodic_orbits,
};

/// A motion closes to 1e-11, and so do its flights but for what they make of their start.
const CLOSED: f64 = 1e-9;
/// Differences of fourth order, in parts of their largest entry.
const MEASURED: f64 = 1e-6;
/// A gap or a speed, of a motion that closes.
const TOUCHED: f64 = 1e-8;

/// Orbits to begin with: of linear systems that hit nothing or once in a period, of both what they come to.
fn orbits(random: &mut Random, body: &Body, tally: &mut Tally) -> Vec<PeriodicOrbit> {
    let mut found: Vec<PeriodicOrbit> = settled(random, body, tally).into_iter().collect();
    if matches!(body, Body::Plant(_)) {
        let scene = body.scene().expect("valid");
        let pattern = random.of(&[Pattern::none(), Pattern::single(0)]);
        let more = periodic_orbits(&scene, &pattern, &OrbitOptions::default());
        found.extend(more.into_iter().flatten().take(1));
    }
    found
}

/// Two numbers of a body.
fn plane(random: &mut Random, body: &Body) -> [(Number, (f64, f64)); 2] {
    let first = draw::number(random, body);
    let all = [Number::Forcing, Number::Frequency, Number::Room(0)];
    let others: Vec<Number> = all.into_iter().filter(|own| *own != first.0).collect();
    let second = random.of(&others);
    [first, (second, draw::range(second, body))]
}

/// The curves of a case, and what is wrong with them.
pub fn check(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let n = random.of(&[1, 1, 2]);
    let body = match random.below(10) {
        0..4 => draw::plant(1, random),
        4..8 => draw::plant(2, random),
        _ => draw::chain(n, random),
    };
    let [first, second] = plane(random, &body);
    let options = ContinuationOptions {
        beyond: random.of(&[Virtual::Stop, Virtual::Keep]),
        max_points: 80,
        ..Default::default()
    };
    let short = ContinuationOptions {
        max_points: 8,
        ..options.clone()
    };
    for orbit in orbits(random, &body, tally) {
        let branch = match followed(&orbit, &body, first, &options) {
            Ok(branch) => branch,
            Err(error) => {
                tally.left_out("refused");
                tally.note(format!("refused: {error}"));
                continue;
            }
        };
        for special in branch.special.iter().take(2) {
            let there = body.with(first.0, special.parameter);
            let ends = |(number, range): (Number, (f64, f64))| match number {
                // Factors count from the scene of the special point.
                Number::Forcing => (0.4, 2.0),
                Number::Damping => (0.2, 3.0),
                _ => range,
            };
            let numbers = [first.0, second.0];
            let between = [ends(first), ends(second)];
            let curve = followed_curve(special, &there, (numbers, between), &short);
            let curve = match curve {
                Ok(curve) => curve,
                Err(error) => {
                    tally.left_out("a special point without a curve");
                    tally.note(format!("{} refused: {error}", special.kind.name()));
                    continue;
                }
            };
            tally.saw("curves", 0.0);
            check_curve(random, &curve, (&there, numbers, special.stop), tally)
                .map_err(|wrong| format!("{} of {numbers:?}: {wrong}", special.kind.name()))?;
        }
    }
    Ok(())
}

fn check_curve(
    random: &mut Random,
    curve: &BifurcationCurve,
    (body, numbers, stop): (&Body, [Number; 2], Option<usize>),
    tally: &mut Tally,
) -> Result<(), String> {
    let count = curve.orbits.len();
    let mut places = vec![0, random.below(count), count - 1];
    places.sort_unstable();
    places.dedup();
    for k in places {
        let (x, y) = (curve.x[k], curve.y[k]);
        let there = body.with(numbers[0], x).with(numbers[1], y);
        check_point((curve, k), &there, stop, tally)
            .map_err(|wrong| format!("({x}, {y}): {wrong}"))?;
    }
    Ok(())
}

fn check_point(
    (curve, k): (&BifurcationCurve, usize),
    body: &Body,
    stop: Option<usize>,
    tally: &mut Tally,
) -> Result<(), String> {
    let orbit = &curve.orbits[k];
    let Some(kind) = curve.kind.filter(|kind| *kind != SpecialKind::Corner) else {
        let off = condition::cornered(orbit, &Look::alone(orbit, body), stop);
        let off = off.ok_or("two stops that are not hit at one instant")?;
        tally.saw("stops hit together", off);
        return within(off, TOUCHED);
    };
    let look = match Look::new(orbit, body) {
        Ok(look) => look,
        Err(why) => {
            tally.left_out(why);
            return Ok(());
        }
    };
    let off = misses(&look).worst();
    tally.saw("orbits", off);
    within(off, CLOSED)?;
    match condition::miss(&look, kind, stop) {
        Err(why) => tally.left_out(why),
        Ok(off) => {
            tally.saw(kind.name(), off);
            let is_touch = matches!(kind, SpecialKind::Graze | SpecialKind::LostImpact);
            within(off, if is_touch { TOUCHED } else { MEASURED })?;
        }
    }
    match (verdict(&look), curve.is_virtual[k]) {
        (Verdict::Broken(by), false) => Err(format!("a rule is broken by {by:e}, unsaid")),
        (Verdict::Kept, true) => {
            let why = orbit.violation();
            Err(format!("a rule is said to be broken, and none is: {why:?}"))
        }
        (Verdict::Unclear, _) => Ok(()),
        _ => {
            tally.saw("verdicts", 0.0);
            Ok(())
        }
    }
}

fn within(off: f64, allowed: f64) -> Result<(), String> {
    if off <= allowed {
        return Ok(());
    }
    Err(format!("off by {off:e}, allowed {allowed:e}"))
}

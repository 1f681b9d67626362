//! What the library is asked: an orbit of a body, and the branch that it is on.

use crate::branches::body::{Body, Number};
use crate::branches::draw::start;
use crate::branches::script::script;
use crate::branches::tally::Tally;
use crate::pendulums::chain::Kind;
use crate::random::Random;
use nalgebra::DVector;
use vibroimpact::{
    BifurcationCurve, Branch, ContinuationOptions, CurveOf, ImpactSide, Motion, PeriodicOrbit,
    SimulateOptions, Special, bifurcation_curve, bifurcation_curve_of, continuation,
    continuation_of, find_orbit, simulate,
};

/// So many periods of the forcing a motion is given to settle.
const PERIODS: f64 = 60.0;

/// Orbits of more impacts, as where they accumulate, take long, and this referee does not follow them.
const MOST_IMPACTS: usize = 12;
/// A motion that comes back so near to itself within so many periods has settled.
const SETTLED: f64 = 0.02;
const MOST_PERIODS: usize = 4;

/// The orbit that a body comes to, if it is found and is one that this referee can follow.
pub fn settled(random: &mut Random, body: &Body, tally: &mut Tally) -> Option<PeriodicOrbit> {
    let Some(found) = closed(random, body, tally) else {
        tally.left_out("no orbit");
        return None;
    };
    script(&found).map_err(|why| tally.left_out(why)).ok()?;
    Some(found)
}

/// The orbit that a body comes to, if it is found.
fn closed(random: &mut Random, body: &Body, tally: &mut Tally) -> Option<PeriodicOrbit> {
    let scene = body.scene().expect("valid");
    let [q, v] = start(random, body);
    let options = SimulateOptions {
        max_impacts: Some(5_000),
        ..Default::default()
    };
    let span = (0.0, PERIODS * scene.period().expect("shaken"));
    let run = simulate(&scene, &q, &v, span, &options).ok()?;
    let period = scene.period().expect("shaken");
    let at = |periods: usize| {
        let t = span.1 - periods as f64 * period;
        run.state(t, ImpactSide::After).ok()
    };
    let (q, v) = at(0)?;
    let is_back = |periods: usize| {
        let far = |(p, u): (DVector<f64>, DVector<f64>)| {
            (p - &q).norm() / (1e-3 + q.norm()) + (u - &v).norm() / (1e-3 + v.norm())
        };
        at(periods).is_some_and(|own| far(own) < SETTLED)
    };
    let Some(periods) = (1..=MOST_PERIODS).find(|periods| is_back(*periods)) else {
        tally.left_out("a motion that does not settle");
        return None;
    };
    let since = span.1 - periods as f64 * period;
    let late = run.impacts().iter().filter(|own| own.time > since);
    if late.count() > MOST_IMPACTS {
        tally.left_out("many impacts");
        return None;
    }
    find_orbit(&scene, &run, None).ok()
}

/// The branch of an orbit over a number: of the place of a wall by scenes of one's own.
pub fn followed(
    orbit: &PeriodicOrbit,
    body: &Body,
    (number, range): (Number, (f64, f64)),
    options: &ContinuationOptions,
) -> vibroimpact::Result<Branch> {
    if is_wall(body, number) {
        let make = |value: f64| body.with(number, value).scene();
        return continuation_of(orbit, &make, body.value(number), range, options);
    }
    continuation(orbit, number.parameter(), range, options)
}

/// The curve of a special point, of a body, in two numbers.
pub fn followed_curve(
    special: &Special,
    body: &Body,
    (numbers, between): ([Number; 2], [(f64, f64); 2]),
    options: &ContinuationOptions,
) -> vibroimpact::Result<BifurcationCurve> {
    let of = CurveOf::Special(special);
    if numbers.iter().any(|number| is_wall(body, *number)) {
        let make = |x: f64, y: f64| body.with(numbers[0], x).with(numbers[1], y).scene();
        let start = numbers.map(|number| body.value(number));
        return bifurcation_curve_of(of, &make, start, between, options);
    }
    bifurcation_curve(of, numbers.map(Number::parameter), between, options)
}

/// Whether a number is the place of a wall, which the library has no name for.
fn is_wall(body: &Body, number: Number) -> bool {
    match number {
        Number::Room(face) => matches!(body.faces()[face].kind, Kind::Wall { .. }),
        _ => false,
    }
}

//! Branches of linear systems, and of such that press against springs on one side or on two: every point closes, and what the multipliers do
//! between points is what the special points say.

use crate::branches::body::{Body, Number};
use crate::branches::counts;
use crate::branches::draw;
use crate::branches::flights::misses;
use crate::branches::library::{followed, settled};
use crate::branches::look::Look;
use crate::branches::tally::Tally;
use crate::random::Random;
use vibroimpact::{
    Branch, ContinuationOptions, OrbitOptions, Pattern, PeriodicOrbit, Virtual, periodic_orbits,
};

/// A motion closes to 1e-11 of its size, and so do its flights but for what they make of their start.
const CLOSED: f64 = 1e-9;

/// The largest multiplier, or one.
fn growth(orbit: &PeriodicOrbit) -> f64 {
    let stability = orbit.stability().ok();
    let order = stability.and_then(|own| own.orders.first());
    order.map_or(1.0, |own| own.spectral_radius().max(1.0))
}

/// Every point of a branch against the referee's motion.
fn check_points(
    branch: &Branch,
    (body, number): (&Body, Number),
    tally: &mut Tally,
) -> Result<(), String> {
    for (orbit, value) in branch.orbits.iter().zip(&branch.parameter) {
        match Look::new(orbit, &body.with(number, *value)) {
            Err(why) => tally.left_out(why),
            Ok(look) => {
                let off = misses(&look);
                tally.saw("points", off.worst());
                if off.worst() > CLOSED * growth(orbit) {
                    return Err(format!("{number:?} = {value}: {off:?}"));
                }
            }
        }
    }
    let (wrong, [pairs, changes]) = counts::difference(branch);
    tally.count("pairs of points", pairs);
    tally.count("multipliers that crossed", changes);
    wrong.map_or(Ok(()), |wrong| Err(format!("{number:?}: {wrong}")))
}

fn check_branch(
    orbit: &PeriodicOrbit,
    body: &Body,
    (number, range): (Number, (f64, f64)),
    options: &ContinuationOptions,
    tally: &mut Tally,
) -> Result<(), String> {
    match followed(orbit, body, (number, range), options) {
        Ok(branch) => {
            tally.saw("branches", 0.0);
            check_points(&branch, (body, number), tally)
        }
        Err(error) => {
            tally.left_out("refused");
            tally.note(format!("refused: {error}"));
            Ok(())
        }
    }
}

/// The branches of a linear system with one impact in a period, or with what it comes to.
pub fn check_linear(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let body = draw::plant(random.of(&[1, 2, 2, 3, 3, 4]), random);
    let (number, range) = draw::number(random, &body);
    let options = ContinuationOptions {
        beyond: random.of(&[Virtual::Stop, Virtual::Keep]),
        max_points: 120,
        ..Default::default()
    };
    let scene = body.scene().expect("valid");
    let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
    let mut orbits: Vec<PeriodicOrbit> = found.into_iter().flatten().take(1).collect();
    orbits.extend(settled(random, &body, tally));
    for orbit in &orbits {
        check_branch(orbit, &body, (number, range), &options, tally)?;
    }
    Ok(())
}

/// The branch of a system beside springs, through where they are reached.
pub fn check_sprung(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let body = draw::sprung(random.of(&[1, 1, 2]), random);
    let number = random.of(&[Number::Frequency, Number::Forcing]);
    let range = match number {
        Number::Forcing => (0.6, 1.6),
        _ => draw::range(number, &body),
    };
    let options = ContinuationOptions {
        max_points: 12,
        ..Default::default()
    };
    let Some(orbit) = settled(random, &body, tally) else {
        return Ok(());
    };
    check_branch(&orbit, &body, (number, range), &options, tally)
}

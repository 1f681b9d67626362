//! Tori of branches: two multipliers of the referee's map on the unit circle, turned by the rotation number.

use crate::branches::body::{Body, Number};
use crate::branches::condition;
use crate::branches::draw;
use crate::branches::library::{followed, settled};
use crate::branches::look::Look;
use crate::branches::tally::Tally;
use crate::random::Random;
use std::f64::consts::TAU;
use vibroimpact::{
    ContinuationOptions, OrbitOptions, Pattern, PeriodicOrbit, Special, SpecialKind, Virtual,
    periodic_orbits,
};

/// Differences of fourth order, of a branch whose torus is shut in to 1e-12 of its range.
const ON_CIRCLE: f64 = 1e-6;

/// Orbits of a body: of a linear system all of one impact in a period, of a chain the one that it comes to.
fn orbits(random: &mut Random, body: &Body, tally: &mut Tally) -> Vec<PeriodicOrbit> {
    match body {
        Body::Plant(_) => {
            let scene = body.scene().expect("valid");
            let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
            found.map_or_else(|_| Vec::new(), |found| found.into_iter().take(1).collect())
        }
        Body::Chain(_) => settled(random, body, tally).into_iter().collect(),
    }
}

/// The branches of a case, and what is wrong with their tori.
pub fn check(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let body = if random.chance(92) {
        draw::plant(2, random)
    } else {
        draw::chain(2, random)
    };
    let number = random.of(&[Number::Frequency, Number::Forcing]);
    let range = draw::range(number, &body);
    let options = ContinuationOptions {
        beyond: Virtual::Keep,
        max_points: 150,
        ..Default::default()
    };
    for orbit in orbits(random, &body, tally) {
        let Ok(branch) = followed(&orbit, &body, (number, range), &options) else {
            tally.left_out("refused");
            continue;
        };
        tally.saw("branches", 0.0);
        let tori = branch
            .special
            .iter()
            .filter(|own| own.kind == SpecialKind::Torus);
        for torus in tori.take(3) {
            check_torus(torus, &body.with(number, torus.parameter), tally)
                .map_err(|wrong| format!("{number:?} = {}: {wrong}", torus.parameter))?;
        }
    }
    Ok(())
}

fn check_torus(torus: &Special, body: &Body, tally: &mut Tally) -> Result<(), String> {
    let all = match Look::new(&torus.orbit, body).and_then(|look| condition::multipliers(&look)) {
        Ok(all) => all,
        Err(why) => {
            tally.left_out(why);
            return Ok(());
        }
    };
    let largest = all.iter().map(|mu| mu.norm()).fold(1.0, f64::max);
    let off = |mu: &&nalgebra::Complex<f64>| (mu.norm() - 1.0).abs();
    let pairs = all.iter().filter(|mu| mu.im > 0.0);
    let pair = pairs.min_by(|a, b| off(a).total_cmp(&off(b)));
    let pair = pair.ok_or_else(|| format!("a torus without conjugate multipliers: {all:?}"))?;
    let rotation = torus.rotation.ok_or("a torus without a rotation number")?;
    let turned = pair.arg() / TAU;
    // Close to the real axis an angle is known to the root of what the pair is.
    let known = ON_CIRCLE * largest / pair.im.abs().min(1.0);
    tally.saw("tori", off(&pair));
    tally.saw("rotation numbers", (turned - rotation).abs());
    if off(&pair) > ON_CIRCLE * largest || (turned - rotation).abs() > known {
        return Err(format!(
            "{all:?}, rotation {rotation}, by the referee {turned}"
        ));
    }
    Ok(())
}

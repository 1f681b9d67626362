//! A referee for pendulums with large motions, in steps and along Taylor series: chains written down from the places of their
//! bobs, followed by extrapolated steps that are much shorter than the motion. The number of scenes is `VIBROIMPACT_CASES`
//! (default 100), their seed `VIBROIMPACT_SEED`; `VIBROIMPACT_CASE` picks one.

mod chain;
mod compare;
#[path = "../common/random.rs"]
mod random;
mod run;
mod scenes;
#[path = "../common/soak.rs"]
mod soak;

use nalgebra::DVector;
use random::{Random, chosen, number};
use vibroimpact::{SimulateOptions, simulate};

/// Times at which states are compared.
const SAMPLES: usize = 40;
#[test]
fn pendulums_move_as_the_referee_says() {
    let (count, seed) = (
        number("VIBROIMPACT_CASES", 100),
        number("VIBROIMPACT_SEED", 1) as u64,
    );
    let only = chosen("VIBROIMPACT_CASE");
    let (mut parts, mut failed, mut hits) = (0.0, Vec::new(), 0);
    for number in (0..count).filter(|k| only.is_none_or(|only| only == *k)) {
        let mut random = Random((seed << 24) + 7919 * number as u64 + 1);
        for _ in 0..8 {
            random.unit();
        }
        let case = scenes::scene(&mut random);
        let times: Vec<f64> = (1..SAMPLES)
            .map(|k| case.end * k as f64 / SAMPLES as f64)
            .collect();
        let reference = compare::reference(&case, &times);
        let n = case.chain.n();
        let options = SimulateOptions {
            method: case.method,
            rtol: case.rtol,
            atol: 1e-2 * case.rtol,
            ..Default::default()
        };
        let [q0, v0] = [&case.start[..n], &case.start[n..]].map(DVector::from_column_slice);
        let again = || simulate(&case.scene(), &q0, &v0, (0.0, case.end), &options);
        let wrong = match again() {
            Err(error) => Some(error.to_string()),
            Ok(run) => {
                let same = again().is_ok_and(|twice| twice.last() == run.last());
                let differs = compare::difference(&case, &times, &reference, &run);
                differs.or_else(|| (!same).then(|| "two runs differ".to_owned()))
            }
        };
        parts += reference.until / case.end;
        hits += reference
            .main
            .hits
            .iter()
            .filter(|h| h.time < reference.until)
            .count();
        if only.is_some() {
            println!(
                "{case:?}\n{:?} until {} ({:?})",
                reference.main, reference.until, reference.main.why
            );
        }
        if let Some(wrong) = wrong {
            println!(
                "scene {number} of seed {seed}, {:?} {:e}: {wrong}",
                case.method, case.rtol
            );
            failed.push(number);
        }
    }
    if only.is_none() {
        soak::note("pendulums", seed, 0, count, failed.len());
    }
    println!(
        "{count} scenes looked at, compared {:.3} of the spans, {hits} impacts",
        parts / count as f64
    );
    assert!(
        failed.is_empty(),
        "the library and the referee disagree: {failed:?}"
    );
    assert!(
        only.is_some() || parts > 0.4 * count as f64,
        "compared {parts} spans of {count}"
    );
}

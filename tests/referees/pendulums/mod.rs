//! A referee for pendulums with large motions, in steps and along Taylor series: chains written down from the places of their
//! bobs, followed by extrapolated steps that are much shorter than the motion.

pub mod chain;
mod compare;
mod run;
mod scenes;

use crate::random::Cases;
use nalgebra::DVector;
use vibroimpact::{SimulateOptions, Solver, simulate};

/// Times at which states are compared.
const SAMPLES: usize = 40;
#[test]
fn pendulums_move_as_the_referee_says() {
    let cases = Cases::new(1, 100);
    let (count, seed) = (cases.numbers().len(), cases.seed);
    let (mut parts, mut failed, mut hits) = (0.0, Vec::new(), 0);
    for (number, mut random) in cases.each() {
        let case = scenes::scene(&mut random);
        if cases.is_one() {
            println!("{case:?}");
        }
        let times: Vec<f64> = (1..SAMPLES)
            .map(|k| case.end * k as f64 / SAMPLES as f64)
            .collect();
        let reference = compare::reference(&case, &times);
        let n = case.chain.n();
        let options = SimulateOptions {
            solver: Solver {
                method: case.method,
                rtol: case.rtol,
                atol: Some(1e-2 * case.rtol),
            }, // What is pressed onto an elastic face bounces lower and lower without end.
            max_impacts: Some(10_000),
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
        if cases.is_one() {
            println!(
                "{:?} until {} ({:?})",
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
    if !cases.is_one() {
        crate::soak::note("pendulums", seed, count, failed.len());
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
        cases.is_one() || parts > 0.4 * count as f64,
        "compared {parts} spans of {count}"
    );
}

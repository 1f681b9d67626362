//! Runs of scenes whose forcing has no period: they end after a number of impacts, or once no impact has come for long. Times are in the
//! scene's unit.

use crate::error::Result;
use crate::model::Scene;
use crate::section::{Section, contacts_begun, points_of};
use crate::simulate::{Keep, RunEnd, SimulateOptions, Status, Trajectory, simulate_after};
use crate::tolerance::{FIRST_COUNTED_SPAN, QUIET_EVALUATIONS, QUIET_SPAN_RATIO};

/// How often the span of a run is doubled at most. [work]
const MOST_SPAN_DOUBLINGS: i32 = 60;
/// Impacts of a run at most: those that accumulate count as one in the section, so that many may be needed for few points. [work]
const MOST_COUNTED_IMPACTS: usize = 1 << 20;

/// A run from where another one has ended, at a time, until a section of impacts has `count` points, or until no impact has come for long.
pub(super) fn until(
    scene: &Scene,
    (from, start): (&RunEnd, f64),
    (count, section): (usize, &Section),
    options: &SimulateOptions,
) -> Result<Trajectory> {
    let (mut most, mut span) = (count, FIRST_COUNTED_SPAN);
    let run = |most: usize, span: f64| {
        let own = SimulateOptions {
            keep: Keep::Motion,
            max_impacts: Some(most),
            ..options.clone()
        };
        simulate_after(scene, from, (start, start + span), &own)
    };
    loop {
        let found = run(most, span)?;
        match found.status() {
            Status::MaxImpacts => {
                let seen = points_of(&found, section)?.t.len();
                if seen >= count || most >= MOST_COUNTED_IMPACTS {
                    return Ok(found);
                }
                most = 2 * most.max(1);
            }
            Status::Finished if !is_over(&found, start)? => span *= 2.0,
            _ => return Ok(found),
        }
    }
}

/// Whether no impact has come for long, and no contact begun, or the longest span is over.
fn is_over(run: &Trajectory, start: f64) -> Result<bool> {
    let span = run.t_end() - start;
    let (impact, begun) = (run.impacts().last(), contacts_begun(run)?);
    let last = impact.map(|last| last.time).into_iter();
    let last = last.chain(begun.last().map(|last| last.0));
    let quiet = last.fold(0.0, |quiet: f64, last| quiet.max(last - start));
    let stats = run.stats();
    let is_enough = stats.n_steps + stats.n_gap_evaluations >= QUIET_EVALUATIONS
        || span > QUIET_SPAN_RATIO * quiet && quiet > 0.0;
    let is_longest = span >= FIRST_COUNTED_SPAN * 2f64.powi(MOST_SPAN_DOUBLINGS);
    Ok(quiet <= 0.5 * span && is_enough || is_longest)
}

//! Runs as long as their impacts make them: of scenes whose forcing has no period.

use crate::error::Result;
use crate::model::{PhysicalState, Scene};
use crate::observer::ObserverFn;
use crate::section::{Motion, Section, points_of};
use crate::simulate::{Keep, SimulateOptions, Status, Trajectory, simulate_observed};

/// The shortest span that is tried, and how often it is doubled at most.
const FIRST_SPAN: f64 = 1e-6;
const DOUBLINGS: i32 = 60;
/// Steps and looks at gaps of a run, at least half of them after its last impact, after which no other is waited for; and how many times
/// longer than until that impact.
const PATIENCE: usize = 20_000;
const LONG: f64 = 1e4;
/// Impacts of a run at most: many that accumulate are one.
const MOST: usize = 1 << 20;

/// A run from a state at a time until the motion has been seen so many times after impacts, as a section of them has it, or until none
/// has come for long.
pub(super) fn until(
    scene: &Scene,
    (state, start): (&PhysicalState, f64),
    (count, section): (usize, &Section),
    options: &SimulateOptions,
    go_on: ObserverFn<'_>,
) -> Result<Trajectory> {
    let (mut most, mut span) = (count, FIRST_SPAN);
    let mut run = |most: usize, span: f64| {
        let own = SimulateOptions {
            keep: Keep::Motion,
            max_impacts: Some(most),
            ..options.clone()
        };
        let (q, v) = state;
        simulate_observed(scene, q, v, (start, start + span), &own, &mut |_| go_on())
    };
    loop {
        let found = run(most, span)?;
        match found.status() {
            Status::MaxImpacts => {
                let seen = points_of(&Motion::Trajectory(&found), section)?.t.len();
                if seen >= count || most >= MOST {
                    return Ok(found);
                }
                most = 2 * most.max(1);
            }
            Status::Finished if !is_over(&found, start) => span *= 2.0,
            _ => return Ok(found),
        }
    }
}

/// Whether no impact has come for long, or the longest span is over.
fn is_over(run: &Trajectory, start: f64) -> bool {
    let span = run.t_end() - start;
    let quiet = run.impacts().last().map_or(0.0, |last| last.time - start);
    let stats = run.stats();
    let is_enough =
        stats.n_steps + stats.n_gap_evaluations >= PATIENCE || span > LONG * quiet && quiet > 0.0;
    quiet <= 0.5 * span && is_enough || span >= FIRST_SPAN * 2f64.powi(DOUBLINGS)
}

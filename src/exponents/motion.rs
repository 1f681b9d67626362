//! What exponents alone do not tell: a motion with one that is zero may run on a torus, decay slowly, or drift. Where it goes tells.

use crate::error::Result;
use crate::exponents::verdict::Attraction;
use crate::model::Scene;
use crate::recurrence::{Measure, advance, comes_back};
use crate::simulate::{Keep, Motion, SimulateOptions, Status, simulate};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// States, one in each period of the forcing, by which a torus is told from a drift and from slow decay. [work]
const RECURRENCE_STATES: usize = 1000;
/// The most periods of the forcing after which a motion is looked for to repeat itself but for an advance. [work]
const LONGEST_DRIFT_PERIOD: usize = 32;

/// The verdict on a motion from a state under a forcing of some period, one of whose exponents is zero, and why it is that: it is gone
/// through once more and carried on from where it ended.
pub(super) fn verdict_of_motion(
    scene: &Scene,
    period: f64,
    ((q, v), (start, end)): ((&DVector<f64>, &DVector<f64>), (f64, f64)),
    options: &SimulateOptions,
) -> Result<(Attraction, String)> {
    let times: Vec<f64> = (0..RECURRENCE_STATES)
        .map(|k| end + k as f64 * period)
        .collect();
    let span = (start, times[RECURRENCE_STATES - 1]);
    let sampled = SimulateOptions {
        keep: Keep::Final,
        t_eval: Some(times),
        ..options.clone()
    };
    let run = simulate(scene, q, v, span, &sampled)?;
    if run.status() != Status::Finished {
        let reason = "it ends soon after the time that counts";
        return Ok((Attraction::Undecided, reason.into()));
    }
    let (_, q, v) = run.samples()?;
    let n = q.ncols();
    let states = DMatrix::from_fn(RECURRENCE_STATES, 2 * n, |k, j| {
        if j < n { q[(k, j)] } else { v[(k, j - n)] }
    });
    let measure = Measure::new(&vec![0.0; n], TAU / period);
    if let Some(found) = advance(&states, &measure, LONGEST_DRIFT_PERIOD) {
        return Ok((Attraction::Drift, found.told()));
    }
    if comes_back(&states, &measure) {
        return Ok((Attraction::Torus, String::new()));
    }
    let reason = "an exponent is zero within its error, but the motion goes on and does not come back to where it was: slow decay looks \
                  like that";
    Ok((Attraction::Undecided, reason.into()))
}

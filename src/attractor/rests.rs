//! The period of motions that come to rest on a stop once in a long while. A rest forgets the motion before it: the release from it is one
//! of few pairs of state and phase, so that a whole number of periods of the motion lies between two releases that are alike. Where
//! deviations grow from rounding to the size of the motion in between, it is the period of the computed motion alone.
//!
//! States are (q, v) in units of the scene, phases are those of the forcing \[rad\], periods count those of the forcing. Source:
//! docs/theory.md, section 17.

use crate::attractor::finding::AttractorSearch;
use crate::error::Result;
use crate::path::{ImpactSide, KeptMotion, Motion};
use crate::simulate::{Keep, RunEnd, Status, Trajectory};
use crate::tolerance::SAME_STATE;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Spans, each as long as the one that the exponents were taken over, that are searched for two releases that are alike. [work]
const MOST_REST_SPANS: usize = 16;

/// The end of a rest on stops: when, on which, at which phase of the forcing \[rad\], and the state (q, v) as a row.
struct StickEnd {
    time: f64,
    stops: Vec<usize>,
    phase: f64,
    state: DMatrix<f64>,
}

impl AttractorSearch<'_> {
    /// Periods of the forcing between the last two releases that are alike, of a motion that is there `done` periods after its start;
    /// none where no two are alike in [`MOST_REST_SPANS`] times `periods`.
    pub(super) fn between_rests(
        &self,
        from: &RunEnd,
        (done, periods): (usize, usize),
    ) -> Result<Option<usize>> {
        let mut releases: Vec<StickEnd> = Vec::new();
        let mut from = from.clone();
        for k in 0..MOST_REST_SPANS {
            let run = self.run(&from, done + k * periods, periods, Keep::Motion)?;
            if run.status() != Status::Finished {
                return Ok(None);
            }
            releases.extend(self::releases(&run)?);
            if let Some(found) = self.between(&releases) {
                return Ok(Some(found));
            }
            from = run.run_end();
        }
        Ok(None)
    }

    /// Periods between the last two releases that are alike.
    fn between(&self, releases: &[StickEnd]) -> Option<usize> {
        let (last, earlier) = releases.split_last()?;
        let measure = self.measure();
        let is_like = |one: &&StickEnd| {
            let turn = (last.phase - one.phase + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
            let size = measure.size(&last.state);
            one.stops == last.stops
                && turn.abs() <= SAME_STATE
                && measure.distance((&one.state, 0), (&last.state, 0)) <= SAME_STATE * size
        };
        let before = earlier.iter().rev().find(is_like)?;
        let apart = ((last.time - before.time) / self.period).round() as usize;
        (apart > 0).then_some(apart)
    }
}

/// The releases of a run.
fn releases(run: &Trajectory) -> Result<Vec<StickEnd>> {
    let end = run.t_end();
    let phase = run.forcing_phase();
    let mut all = Vec::new();
    for part in run.stretches()? {
        if part.lasting().n_lost_directions() == 0 || part.end >= end {
            continue;
        }
        let (q, v) = run.state(part.end, ImpactSide::After)?;
        let n = q.len();
        all.push(StickEnd {
            time: part.end,
            stops: part.stops().to_vec(),
            phase: phase(part.end),
            state: DMatrix::from_fn(1, 2 * n, |_, j| if j < n { q[j] } else { v[j - n] }),
        });
    }
    Ok(all)
}

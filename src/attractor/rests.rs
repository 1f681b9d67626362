//! Motions that come to rest on a stop once in a long while. What is let go again begins with one of few pairs of state and phase, so
//! that between two releases that are alike lies a whole number of its periods, though between them deviations may have grown from
//! rounding to the size of the motion: the number is then that of the computed motion.

use crate::attractor::finding::{Search, owned};
use crate::error::Result;
use crate::hybrid::SegmentKind;
use crate::model::PhysicalState;
use crate::observer::ObserverFn;
use crate::simulate::{ImpactSide, Keep, Status, Trajectory};
use crate::tolerance::SAME_STATE;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// So many times the periods that exponents were taken over are gone through for two releases that are alike.
const TIMES: usize = 16;

/// A stop is let go.
struct Release {
    time: f64,
    stops: Vec<usize>,
    phase: f64,
    state: DMatrix<f64>,
}

impl Search<'_> {
    /// Periods between the last two releases that are alike, of a motion from a state so many periods after its start; none where it
    /// is let go no two times in many times so many periods.
    pub(super) fn between_rests(
        &self,
        state: &PhysicalState,
        (done, periods): (usize, usize),
        go_on: ObserverFn<'_>,
    ) -> Result<Option<usize>> {
        let mut releases: Vec<Release> = Vec::new();
        let mut state = state.clone();
        for k in 0..TIMES {
            let run = self.run(&state, done + k * periods, periods, Keep::Motion, go_on)?;
            if run.status() != Status::Finished {
                return Ok(None);
            }
            releases.extend(self::releases(&run)?);
            if let Some(found) = self.between(&releases) {
                return Ok(Some(found));
            }
            state = owned(&run);
        }
        Ok(None)
    }

    /// Periods between the last two releases that are alike.
    fn between(&self, releases: &[Release]) -> Option<usize> {
        let (last, earlier) = releases.split_last()?;
        let measure = self.measure();
        let is_like = |one: &&Release| {
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
fn releases(run: &Trajectory) -> Result<Vec<Release>> {
    let end = run.t_end();
    let phase = run.forcing_phase();
    let mut all = Vec::new();
    for part in run.stretches()? {
        if part.kind != SegmentKind::Stick || part.end >= end {
            continue;
        }
        let (q, v) = run.state(part.end, ImpactSide::After)?;
        let n = q.len();
        all.push(Release {
            time: part.end,
            stops: part.stops.to_vec(),
            phase: phase(part.end),
            state: DMatrix::from_fn(1, 2 * n, |_, j| if j < n { q[j] } else { v[j - n] }),
        });
    }
    Ok(all)
}

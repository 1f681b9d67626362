//! The classification of a motion that does not repeat itself: by its Lyapunov exponents, and by whether it comes back to where it was.
//!
//! Exponents are per unit of time \[1/s\]; states are rows (q, v) in units of the scene, one in each period of the forcing, and periods
//! count those. Source: docs/theory.md, sections 16 and 17.

use crate::attractor::at_phase::sampled_states;
use crate::attractor::finding::{AttractorSearch, SeedOutcome, attractor};
use crate::attractor::kind::AttractorKind;
use crate::attractor::record::Attractor;
use crate::error::{Error, Result};
use crate::exponents::{Attraction, LyapunovOptions, lyapunov_exponents};
use crate::orbit::Pattern;
use crate::recurrence::{comes_back, repeats_after};
use crate::simulate::{Keep, RunEnd, SimulateOptions, Status, Trajectory, simulate_after};
use crate::tolerance::SET_STATES;
use nalgebra::DMatrix;

/// A motion that comes nearer to an orbit is followed until its deviations have fallen by the factor `exp(18)`, 1e8: far below the distance
/// at which it counts as being there. [work]
const APPROACH_E_FOLDS: f64 = 18.0;
/// How many times as long as the exponents were taken over a motion is followed at most that comes nearer to an orbit. [work]
const MOST_APPROACH_SPANS: usize = 20;
/// How many times as long as the exponents were taken over a motion is followed that has not come back to where it was: it may decay
/// slowly. [work]
const DECAY_SPANS: usize = 5;

impl AttractorSearch<'_> {
    /// The outcome of a motion without a period up to the longest one sought; and, where that may change, for how many more periods it is
    /// to be followed, else zero.
    pub(super) fn by_exponents(
        &self,
        run: &Trajectory,
        done: usize,
        reason: &str,
    ) -> Result<(SeedOutcome, usize)> {
        let (q, v) = run.last();
        let time = |periods: usize| self.start + self.period * (done + periods) as f64;
        let periods = self.options.max_periods.max(SET_STATES);
        let span = (time(0), time(periods));
        let options = LyapunovOptions {
            solver: self.options.solver,
            ..LyapunovOptions::default()
        };
        let found = lyapunov_exponents(self.scene, q, v, span, &options)?;
        // An angle that advances by the same in each period goes round a torus: only positions drift.
        let has_angles = self.around.turns().iter().any(|turn| *turn > 0.0);
        if found.verdict == Attraction::Drift && !has_angles {
            return Ok((SeedOutcome::Drifting, 0));
        }
        let Some(points) = self.strobed(run, (done, periods))? else {
            return Ok((SeedOutcome::Undecided, 0));
        };
        // After a chaotic transient, or with a long period, it may repeat itself by now.
        let long = repeats_after(&points, &self.measure(), SET_STATES / 2);
        if long > 0 {
            return self.long_round((done, periods, long), &run.run_end());
        }
        let set = |kind: AttractorKind, points: DMatrix<f64>, n_periods: usize, reason: String| {
            attractor(Attractor {
                kind,
                n_periods,
                points,
                exponents: found.exponents.clone(),
                pattern: Pattern::none(),
                reason,
                orbit: None,
                fraction: 0.0,
            })
        };
        let usual = || match reason {
            "" => format!("it has no period up to {}", self.options.longest_period),
            reason => reason.to_owned(),
        };
        let largest = found.exponents.first().copied().unwrap_or(f64::NAN);
        match found.verdict {
            Attraction::Chaotic => Ok((set(AttractorKind::Chaotic, points, 0, usual()), 0)),
            Attraction::Torus => Ok((set(AttractorKind::Torus, points, 0, usual()), 0)),
            Attraction::Drift if comes_back(&points, &self.measure()) => {
                Ok((set(AttractorKind::Torus, points, 0, usual()), 0))
            }
            Attraction::Periodic => {
                if largest.is_finite() {
                    let longer = (-APPROACH_E_FOLDS / (largest * self.period)).ceil();
                    let is_near = longer > 0.0 && longer <= (MOST_APPROACH_SPANS * periods) as f64;
                    let longer = if is_near { longer as usize } else { 0 };
                    return Ok((SeedOutcome::Unclear(points), longer));
                }
                let rests = self.between_rests(&run.run_end(), (done, periods))?;
                Ok(match rests {
                    None => (SeedOutcome::Unclear(points), 0),
                    Some(n_periods) => {
                        let kept = points.nrows() - usize::from(points.nrows() == n_periods);
                        let points = points.rows(points.nrows() - kept, kept).into_owned();
                        let reason = format!(
                            "it comes to rest on a stop, the last two times in the same way {n_periods} periods apart; deviations grow \
                             beyond rounding in between, so that this is the period of the computed motion"
                        );
                        (set(AttractorKind::Periodic, points, n_periods, reason), 0)
                    }
                })
            }
            Attraction::Drift | Attraction::Undecided => {
                // A motion that has not come back may be one that decays slowly.
                let is_back = comes_back(&points, &self.measure());
                let longer = if is_back { 0 } else { DECAY_SPANS * periods };
                Ok((SeedOutcome::Unclear(points), longer))
            }
        }
    }

    /// The last [`SET_STATES`] states, one in each period, of a motion carried on for some periods; none where it ends before.
    fn strobed(
        &self,
        run: &Trajectory,
        (done, periods): (usize, usize),
    ) -> Result<Option<DMatrix<f64>>> {
        let time = |periods: usize| self.start + self.period * (done + periods) as f64;
        let sampled = SimulateOptions {
            t_eval: Some((periods - SET_STATES..periods).map(time).collect()),
            ..self.options.run(Keep::Final)
        };
        let span = (time(0), time(periods));
        let kept = simulate_after(self.scene, &run.run_end(), span, &sampled)?;
        if kept.status() != Status::Finished {
            return Ok(None);
        }
        Ok(Some(self.around.within_turns(sampled_states(&kept)?)))
    }

    /// The outcome of a motion that repeats itself after `long` periods, or after fewer; where no orbit is near enough yet, for how many
    /// more periods it is to be followed.
    fn long_round(
        &self,
        (done, periods, long): (usize, usize, usize),
        from: &RunEnd,
    ) -> Result<(SeedOutcome, usize)> {
        let there = self.run(from, done, periods, Keep::Final)?;
        let window = 3 * long + 4;
        let run = self.run(&there.run_end(), done + periods, window, Keep::Motion)?;
        let now = self.settled(&run, long)?;
        if now.n_periods == 0 {
            return Ok((SeedOutcome::Undecided, periods));
        }
        match self.closed(&run, &now) {
            Ok(Some(closed)) => Ok((attractor(closed), 0)),
            Ok(None) => Ok((SeedOutcome::Undecided, periods)),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            Err(error) => {
                let found = self.repeating(&run, &now, error.to_string())?;
                Ok((attractor(found), 0))
            }
        }
    }
}

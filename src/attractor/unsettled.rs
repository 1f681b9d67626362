//! What a motion is that does not repeat itself: it is told by its exponents, and by where it goes.

use crate::attractor::finding::{Found, Search, attractor, owned};
use crate::attractor::kind::AttractorKind;
use crate::attractor::one::Attractor;
use crate::error::{Error, Result};
use crate::exponents::{Attraction, LyapunovOptions, lyapunov_exponents_observed};
use crate::model::PhysicalState;
use crate::observer::ObserverFn;
use crate::orbit::Pattern;
use crate::recurrence::{comes_back, repeats_after};
use crate::simulate::{Keep, SimulateOptions, Status, Trajectory, simulate_observed};
use nalgebra::DMatrix;

/// Points that are kept.
pub(super) const KEPT: usize = 1000;
/// Logarithm of the part to which a motion that comes nearer to an orbit is to come, and how many times longer than before that may take.
const NEARER: f64 = 18.0;
const PATIENCE: usize = 20;
/// How many times longer a motion is followed that goes on from where it was and is not yet back there.
const FARTHER: usize = 5;

impl Search<'_> {
    /// What does not repeat itself within the periods looked for; where it comes nearer to an orbit, slowly, the periods until it is there.
    pub(super) fn by_exponents(
        &self,
        run: &Trajectory,
        done: usize,
        reason: &str,
        go_on: ObserverFn<'_>,
    ) -> Result<(Found, usize)> {
        let (q, v) = run.last();
        let time = |periods: usize| self.start + self.period * (done + periods) as f64;
        let periods = self.options.max_periods.max(KEPT);
        let span = (time(0), time(periods));
        let options = LyapunovOptions {
            method: self.options.method,
            rtol: self.options.rtol,
            atol: self.options.atol,
            ..LyapunovOptions::default()
        };
        let found =
            lyapunov_exponents_observed(self.scene, q, v, span, &options, &mut |_| go_on())?;
        // An angle that is on by the same in each period goes round a torus.
        let has_angles = self.around.turns().iter().any(|turn| *turn > 0.0);
        if found.verdict == Attraction::Drift && !has_angles {
            return Ok((Found::Drifting, 0));
        }
        let Some(points) = self.strobed(run, (done, periods), go_on)? else {
            return Ok((Found::Undecided, 0));
        };
        // What was chaotic for a while, or has a long period, repeats itself by now.
        let long = repeats_after(&points, &self.measure(), KEPT / 2);
        if long > 0 {
            let state = (q.clone(), v.clone());
            return self.long_round((done, periods, long), &state, go_on);
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
                    let longer = (-NEARER / (largest * self.period)).ceil();
                    let is_near = longer > 0.0 && longer <= (PATIENCE * periods) as f64;
                    let longer = if is_near { longer as usize } else { 0 };
                    return Ok((Found::Unclear(points), longer));
                }
                let rests = self.between_rests(&(q.clone(), v.clone()), (done, periods), go_on)?;
                Ok(match rests {
                    None => (Found::Unclear(points), 0),
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
                // What decays slowly does not come back.
                let is_back = comes_back(&points, &self.measure());
                let longer = if is_back { 0 } else { FARTHER * periods };
                Ok((Found::Unclear(points), longer))
            }
        }
    }

    /// The last states of a motion, one in each period, that goes on for some periods; none where it ends before.
    fn strobed(
        &self,
        run: &Trajectory,
        (done, periods): (usize, usize),
        go_on: ObserverFn<'_>,
    ) -> Result<Option<DMatrix<f64>>> {
        let time = |periods: usize| self.start + self.period * (done + periods) as f64;
        let sampled = SimulateOptions {
            t_eval: Some((periods - KEPT..periods).map(time).collect()),
            ..self.options.run(Keep::Final)
        };
        let (q, v) = run.last();
        let span = (time(0), time(periods));
        let kept = simulate_observed(self.scene, q, v, span, &sampled, &mut |_| go_on())?;
        if kept.status() != Status::Finished {
            return Ok(None);
        }
        let (_, q, v) = kept.samples()?;
        let n = q.ncols();
        let states = DMatrix::from_fn(q.nrows(), 2 * n, |k, j| {
            if j < n { q[(k, j)] } else { v[(k, j - n)] }
        });
        Ok(Some(self.around.within_turns(states)))
    }

    /// What repeats itself so many periods after a state of its motion, if not before; where no orbit is near enough yet, so many more.
    fn long_round(
        &self,
        (done, periods, long): (usize, usize, usize),
        state: &PhysicalState,
        go_on: ObserverFn<'_>,
    ) -> Result<(Found, usize)> {
        let there = self.run(state, done, periods, Keep::Final, go_on)?;
        let window = 3 * long + 4;
        let run = self.run(&owned(&there), done + periods, window, Keep::Motion, go_on)?;
        let now = self.settled(&run, long)?;
        if now.n_periods == 0 {
            return Ok((Found::Undecided, periods));
        }
        match self.closed(&run, &now, go_on) {
            Ok(Some(closed)) => Ok((attractor(closed), 0)),
            Ok(None) => Ok((Found::Undecided, periods)),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            Err(error) => {
                let found = self.repeating(&run, &now, error.to_string())?;
                Ok((attractor(found), 0))
            }
        }
    }
}

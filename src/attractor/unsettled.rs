//! What a motion is that does not repeat itself: it is told by its exponents.

use crate::attractor::finding::{Found, Search, attractor, states};
use crate::attractor::kind::AttractorKind;
use crate::attractor::one::Attractor;
use crate::error::Result;
use crate::exponents::{Attraction, LyapunovOptions, lyapunov_exponents_observed};
use crate::observer::ObserverFn;
use crate::orbit::Pattern;
use crate::section::repeats_after;
use crate::simulate::{Keep, SimulateOptions, Trajectory, simulate_observed};
use std::f64::consts::TAU;

/// Points that are kept.
const KEPT: usize = 1000;
/// Logarithm of the part to which a motion that comes nearer to an orbit is to come, and how many times longer than before that may take.
const NEARER: f64 = 18.0;
const PATIENCE: usize = 20;

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
        let kind = match found.verdict {
            Attraction::Chaotic => AttractorKind::Chaotic,
            Attraction::Torus => AttractorKind::Torus,
            Attraction::Periodic => AttractorKind::Periodic,
            Attraction::Undecided => return Ok((Found::Undecided, 0)),
        };
        let sampled = SimulateOptions {
            t_eval: Some((periods - KEPT..periods).map(time).collect()),
            ..self.options.run(Keep::Final)
        };
        let kept = simulate_observed(self.scene, q, v, span, &sampled, &mut |_| go_on())?;
        let (_, q, v) = kept.samples()?;
        // What sticks repeats itself, if after more periods than were looked for.
        let loops = match kind {
            AttractorKind::Periodic => {
                repeats_after(&q, &v, self.around.turns(), TAU / self.period, KEPT / 2)
            }
            _ => 0,
        };
        let first = if loops > 0 { q.nrows() - loops } else { 0 };
        let all = self.around.within_turns(states((&q, &v)));
        let points = all.rows_range(first..).into_owned();
        let rate = (found.exponents.first()).map_or(0.0, |rate| -rate * self.period);
        let longer = (NEARER / rate).ceil();
        let is_slow = kind == AttractorKind::Periodic && longer > 0.0;
        let is_near = is_slow && longer <= (PATIENCE * periods) as f64;
        let reason = if !reason.is_empty() {
            reason.into()
        } else if is_slow && !is_near {
            format!("it comes nearer to an orbit, and is there in some {longer} periods")
        } else {
            let longest = self.options.longest_period;
            format!("it has no period up to {longest}")
        };
        let found = attractor(Attractor {
            kind,
            n_periods: 0,
            points,
            exponents: found.exponents,
            pattern: Pattern::none(),
            reason,
            orbit: None,
            fraction: 0.0,
        });
        Ok((found, if is_near { longer as usize } else { 0 }))
    }
}

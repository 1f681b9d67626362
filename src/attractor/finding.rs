//! The outcome of one motion: it is simulated window by window until its states, one in each period of the forcing, repeat themselves;
//! Newton's method then closes the orbit. A motion that does not repeat itself is classified in `unsettled.rs`.
//!
//! States are (q, v) in units of the scene; periods count those of the forcing; distances are parts of the motion's size, or of the state
//! box where they are from it \[-\]. Source: docs/theory.md, section 17.

use crate::attractor::at_phase::{quiet_phase, quiet_points};
use crate::attractor::kind::AttractorKind;
use crate::attractor::options::AttractorOptions;
use crate::attractor::record::Attractor;
use crate::attractor::state_box::StateBox;
use crate::error::{Error, Result};
use crate::model::{PhysicalState, Scene};
use crate::orbit::{OrderMultipliers, Pattern, PeriodicOrbit, find_orbit};
use crate::path::{ImpactSide, KeptMotion};
use crate::recurrence::{Measure, least_period};
use crate::section::{Section, Settled, points_of, settled};
use crate::simulate::{Keep, RunEnd, Status, Trajectory, simulate_after};
use crate::tolerance::{FIRST_SOUGHT_PERIODS, LEFT_BOX, NEUTRAL_MULTIPLIER, SAME_STATE};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Why a motion in which an angle goes round has no orbit.
pub(crate) const TURNS: &str =
    "an angle goes round in each of its periods: find_orbit closes no such motion";

/// What the motion from one start settles on.
#[derive(Debug, Clone)]
pub(crate) enum SeedOutcome {
    /// It begins inside a stop.
    Inside,
    /// It leaves the surroundings of the box.
    Lost,
    /// Nothing could be decided.
    Undecided,
    /// It drifts: it repeats itself but for a constant advance.
    Drifting,
    /// Nothing could be decided, but these are its states, one in each period, shape `(p, 2n)`: they may lie on the set of another start.
    Unclear(DMatrix<f64>),
    /// An attractor.
    Attractor(Box<Attractor>),
}

/// The search for the attractor of a motion that begins in a state at a phase of the forcing.
pub(crate) struct AttractorSearch<'s> {
    pub scene: &'s Scene,
    pub around: &'s StateBox,
    pub options: &'s AttractorOptions,
    /// The period of the forcing \[s\].
    pub period: f64,
    /// The first time at which the forcing has the phase \[s\].
    pub start: f64,
    /// Attractors that earlier starts have led to.
    pub known: Vec<Attractor>,
}

impl AttractorSearch<'_> {
    /// The distance of states.
    pub fn measure(&self) -> Measure {
        Measure::new(self.around.turns(), TAU / self.period)
    }

    /// Whether an attractor is among those known.
    pub fn knows(&self, own: &Attractor) -> Result<bool> {
        for one in &self.known {
            if self.are_one((one, &one.points), (own, &own.points))? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What the motion from a state settles on.
    pub fn settle(&self, state: &PhysicalState) -> Result<SeedOutcome> {
        let periods = self.options.transient;
        let begun = RunEnd {
            state: state.clone(),
            ..RunEnd::default()
        };
        let run = self.run(&begun, 0, periods, Keep::Final);
        let mut run = match run {
            Err(error) if error.is_about("q0") => return Ok(SeedOutcome::Inside),
            run => run?,
        };
        let mut reason = String::new();
        let mut has_turned = 0;
        let mut done = periods;
        let mut limit = self.options.max_periods.max(periods + 1);
        let mut is_told = false;
        let longest = self.options.longest_period;
        let mut looked_for = longest.min(FIRST_SOUGHT_PERIODS);
        let least = 3 * looked_for + 4;
        loop {
            if self.is_far(&run) {
                return self.far_away(&run, done);
            }
            if run.status() != Status::Finished {
                return Ok(SeedOutcome::Undecided);
            }
            if done >= limit {
                let (found, longer) = self.by_exponents(&run, done, &reason)?;
                if is_told || longer == 0 {
                    return Ok(found);
                }
                // It approaches an orbit slowly, and reaches it in `longer` periods by the rate of its exponents.
                (is_told, limit) = (true, done + longer);
            }
            // A window holds three of the longest period that is sought, as far as the limit allows.
            let window = (3 * looked_for + 4).min((limit - done).max(least));
            run = self.run(&run.run_end(), done, window, Keep::Motion)?;
            done += window;
            if run.status() != Status::Finished {
                continue;
            }
            let now = self.settled(&run, looked_for)?;
            looked_for = longest.min(2 * looked_for);
            if now.n_periods == 0 {
                if now.advance.is_some() {
                    return Ok(SeedOutcome::Drifting);
                }
                continue;
            }
            if let Some(known) = self.known_one(&run, now.n_periods)? {
                return Ok(attractor(known.clone()));
            }
            if self.turns(&run, now.n_periods)? {
                // Its q does not close: its points describe it, once two windows show the same period.
                if has_turned == now.n_periods {
                    let turning = self.repeating(&run, &now, TURNS.into());
                    return turning.map(attractor);
                }
                has_turned = now.n_periods;
                continue;
            }
            match self.closed(&run, &now) {
                Ok(Some(closed)) => return Ok(attractor(closed)),
                // The orbit is another or still too far away: the next window tries again.
                Ok(None) => {}
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Err(error) => {
                    reason = error.to_string();
                    if done + window > limit {
                        return Ok(attractor(self.repeating(&run, &now, reason)?));
                    }
                }
            }
        }
    }

    /// What a motion has settled on, up to a longest period.
    pub(super) fn settled(&self, run: &Trajectory, longest: usize) -> Result<Settled> {
        settled(run, self.around.turns(), longest)
    }

    /// The outcome of a motion far from the box: it drifts if it repeats itself but for an advance.
    fn far_away(&self, run: &Trajectory, done: usize) -> Result<SeedOutcome> {
        let window = 3 * self.options.longest_period.min(FIRST_SOUGHT_PERIODS) + 4;
        let run = match self.run(&run.run_end(), done, window, Keep::Motion) {
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            // It overflows.
            Err(_) => return Ok(SeedOutcome::Lost),
            Ok(run) => run,
        };
        if run.status() != Status::Finished {
            return Ok(SeedOutcome::Lost);
        }
        Ok(match self.settled(&run, FIRST_SOUGHT_PERIODS)?.advance {
            Some(_) => SeedOutcome::Drifting,
            None => SeedOutcome::Lost,
        })
    }

    /// A run of some periods from where the motion is `first` periods after the start.
    pub(super) fn run(
        &self,
        from: &RunEnd,
        first: usize,
        periods: usize,
        keep: Keep,
    ) -> Result<Trajectory> {
        let options = self.options.run(keep);
        let time = |periods: usize| self.start + self.period * periods as f64;
        let span = (time(first), time(first + periods));
        simulate_after(self.scene, from, span, &options)
    }

    /// Whether a motion has left the surroundings of the box.
    fn is_far(&self, run: &Trajectory) -> bool {
        let (q, v) = run.last();
        self.around.beyond(q.iter().chain(v.iter())) > LEFT_BOX
    }

    /// Whether an angle goes round in a number of periods.
    fn turns(&self, run: &Trajectory, n_periods: usize) -> Result<bool> {
        let turns = self.around.turns();
        if turns.iter().all(|turn| *turn == 0.0) {
            return Ok(false);
        }
        let found = points_of(run, &Section::Phase(self.options.phase))?;
        let last = found.q.nrows().saturating_sub(1);
        let goes_round = |(i, turn): (usize, &f64)| {
            let off = found.q[(last, i)] - found.q[(last.saturating_sub(n_periods), i)];
            *turn > 0.0 && off.abs() > 0.5 * turn
        };
        Ok(turns.iter().enumerate().any(goes_round))
    }

    /// The known orbit that a motion with a period is on.
    fn known_one(&self, run: &Trajectory, n_periods: usize) -> Result<Option<&Attractor>> {
        for one in &self.known {
            if !n_periods.is_multiple_of(one.n_periods.max(1)) {
                continue;
            }
            let quiet = quiet_phase([one], self.options.phase);
            let all = self.points(run, quiet)?;
            let last = all.nrows().saturating_sub(n_periods);
            let own = all.rows_range(last..).into_owned();
            if self.is_on(&own, (one, quiet))? {
                return Ok(Some(one));
            }
        }
        Ok(None)
    }

    /// The orbit that a motion is near, closed by Newton's method; none where that is another orbit, or an unstable one. The motion repeats
    /// itself after `now.n_periods`; the orbit may have a divisor of them as its period, since a motion that approaches it slowly repeats
    /// itself after several rounds first.
    pub(super) fn closed(&self, run: &Trajectory, now: &Settled) -> Result<Option<Attractor>> {
        let n = now.n_periods;
        for fewer in (1..n).filter(|&fewer| n.is_multiple_of(fewer)) {
            match self.closed_after(fewer, run, now) {
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Ok(Some(found)) => return Ok(Some(found)),
                _ => {}
            }
        }
        self.closed_after(n, run, now)
    }

    /// [`Self::closed`] for an orbit of so many periods.
    fn closed_after(
        &self,
        n_periods: usize,
        run: &Trajectory,
        now: &Settled,
    ) -> Result<Option<Attractor>> {
        let quiet = |orbit: &PeriodicOrbit| quiet_points(self.scene, orbit, self.options.phase);
        let mut orbit = find_orbit(self.scene, run, Some(n_periods))?;
        let round = least_period(&quiet(&orbit).0, &self.measure());
        if round < orbit.n_periods() {
            orbit = find_orbit(self.scene, run, Some(round))?;
        }
        let stability = orbit.stability()?;
        if stability.is_stable == Some(false) {
            return Ok(None);
        }
        let largest = stability
            .orders
            .first()
            .map_or(0.0, OrderMultipliers::spectral_radius);
        if largest > NEUTRAL_MULTIPLIER {
            return Ok(None);
        }
        // The last state, at a phase far from impacts, must be a point of the orbit but for a deviation that still decays: a change by
        // `SAME_STATE` in a round leaves `SAME_STATE / (1 - largest)` in all.
        let (points, phase) = quiet(&orbit);
        let seen = self.points(run, phase)?;
        let Some(last) = seen.nrows().checked_sub(1) else {
            return Ok(None);
        };
        let measure = self.measure();
        let points = self.around.within_turns(points);
        let away = (0..points.nrows()).map(|k| measure.distance((&seen, last), (&points, k)));
        let allowed = SAME_STATE / (1.0 - largest) * measure.size(&points);
        if away.fold(f64::INFINITY, f64::min) > allowed {
            return Ok(None);
        }
        let pattern = of_one_round(now, orbit.n_periods())?;
        self.periodic(orbit, pattern).map(Some)
    }

    /// The points of a motion at a phase.
    fn points(&self, motion: &dyn KeptMotion, phase: f64) -> Result<DMatrix<f64>> {
        let found = points_of(motion, &Section::Phase(phase))?;
        Ok(self.around.within_turns(found.states()))
    }

    fn periodic(&self, orbit: PeriodicOrbit, pattern: Pattern) -> Result<Attractor> {
        let multipliers = &orbit.stability()?.orders;
        let rates = multipliers.first().map(|order| {
            let each = order.multipliers.iter();
            each.map(|mu| mu.norm().ln() / orbit.period()).collect()
        });
        let points = self.points(&orbit, self.options.phase)?;
        let is_at_rest = orbit.impacts().is_empty()
            && (0..8).all(|k| {
                let (q, v) = orbit.state_at(orbit.period() * f64::from(k) / 8.0, ImpactSide::After);
                let size = q.amax().max(f64::MIN_POSITIVE);
                v.amax() * self.period <= SAME_STATE * size
            });
        Ok(Attractor {
            kind: if is_at_rest {
                AttractorKind::Rest
            } else {
                AttractorKind::Periodic
            },
            n_periods: orbit.n_periods(),
            points,
            exponents: rates.unwrap_or_default(),
            pattern,
            reason: String::new(),
            orbit: Some(orbit),
            fraction: 0.0,
        })
    }

    /// The attractor of a motion that repeats itself although no orbit could be closed, for a reason.
    pub(super) fn repeating(
        &self,
        run: &Trajectory,
        now: &Settled,
        reason: String,
    ) -> Result<Attractor> {
        let all = self.points(run, self.options.phase)?;
        let count = now.n_periods.min(all.nrows());
        let first = all.nrows().saturating_sub(now.n_periods + 1);
        let seen = all.rows(first, count).into_owned();
        let n_periods = least_period(&seen, &self.measure());
        Ok(Attractor {
            kind: AttractorKind::Periodic,
            n_periods,
            points: seen.rows(0, n_periods).into_owned(),
            exponents: Vec::new(),
            pattern: of_one_round(now, n_periods)?,
            reason,
            orbit: None,
            fraction: 0.0,
        })
    }
}

/// The stops hit in one round of a motion whose repetition was found over several rounds.
fn of_one_round(seen: &Settled, round: usize) -> Result<Pattern> {
    let instants = seen.pattern.instants();
    Pattern::new(instants[..instants.len() * round / seen.n_periods.max(1)].to_vec())
}

pub(super) fn attractor(found: Attractor) -> SeedOutcome {
    SeedOutcome::Attractor(Box::new(found))
}

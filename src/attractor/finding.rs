//! What one motion settles on: it is looked at until it repeats itself, and then closed by Newton's method.

use crate::attractor::kind::AttractorKind;
use crate::attractor::one::Attractor;
use crate::attractor::options::AttractorOptions;
use crate::attractor::same::are_points_within;
use crate::attractor::state_box::StateBox;
use crate::error::{Error, Result};
use crate::model::{PhysicalState, Scene};
use crate::observer::ObserverFn;
use crate::orbit::{OrderMultipliers, Pattern, PeriodicOrbit, find_orbit_observed};
use crate::section::{Motion, Section, Sectioned, Settled, points_of, settled};
use crate::simulate::{Keep, Status, Trajectory, simulate_observed};
use crate::tolerance::FAR;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A motion is on an orbit that is known if its points are, to this part of the box.
const CLOSE: f64 = 1e-5;
/// An orbit is that of a motion if it is no farther from it than this part of the motion, over what is left of a deviation in a round.
const NEAR: f64 = 1e-6;

/// An orbit goes round several times if its states once in each period repeat themselves to this part of the motion.
const ROUND: f64 = 1e-8;

/// Why a motion in which an angle goes round has no orbit.
pub(crate) const TURNS: &str =
    "an angle goes round in each of its periods: find_orbit closes no such motion";

/// An orbit attracts nothing, being one of a family, if a deviation is left in a round as this part or more.
const NEUTRAL: f64 = 1.0 - 1e-6;

/// What one motion settles on.
#[derive(Debug, Clone)]
pub(crate) enum Found {
    /// It begins inside a stop.
    Inside,
    /// It leaves the surroundings of the box.
    Lost,
    /// It was not decided.
    Undecided,
    /// An attractor.
    Attractor(Box<Attractor>),
}

/// Goes along a motion from a state at a phase of the forcing.
pub(crate) struct Search<'s> {
    pub scene: &'s Scene,
    pub around: &'s StateBox,
    pub options: &'s AttractorOptions,
    pub period: f64,
    /// The time at which the forcing has the phase.
    pub start: f64,
    /// Orbits that other starts have led to.
    pub known: Vec<Attractor>,
}

impl Search<'_> {
    /// Whether an orbit is known.
    pub fn knows(&self, own: &Attractor) -> bool {
        let is_same =
            |one: &Attractor| are_points_within(&one.points, &own.points, self.around, CLOSE);
        self.known.iter().any(is_same)
    }

    /// What the motion from a state settles on.
    pub fn settle(&self, state: &PhysicalState, go_on: ObserverFn<'_>) -> Result<Found> {
        let periods = self.options.transient;
        let run = self.run(state, 0, periods, Keep::Final, go_on);
        let mut run = match run {
            Err(error) if error.is_about("q0") => return Ok(Found::Inside),
            run => run?,
        };
        let mut reason = String::new();
        let mut has_turned = 0;
        let mut done = periods;
        let mut limit = self.options.max_periods.max(periods + 1);
        let mut is_told = false;
        let window = 3 * self.options.longest_period + 4;
        loop {
            if self.is_far(&run) {
                return Ok(Found::Lost);
            }
            if run.status() != Status::Finished {
                return Ok(Found::Undecided);
            }
            if done >= limit {
                let (found, longer) = self.by_exponents(&run, done, &reason, go_on)?;
                if is_told || longer == 0 {
                    return Ok(found);
                }
                // It comes nearer to an orbit, and in so many periods is there.
                (is_told, limit) = (true, done + longer);
            }
            run = self.run(&owned(&run), done, window, Keep::Motion, go_on)?;
            done += window;
            if run.status() != Status::Finished {
                continue;
            }
            let now = settled(
                &Motion::Trajectory(&run),
                self.around.turns(),
                self.options.longest_period,
            )?;
            if now.n_periods == 0 {
                continue;
            }
            if let Some(known) = self.known_one(&run, now.n_periods)? {
                return Ok(attractor(known.clone()));
            }
            if self.turns(&run, now.n_periods)? {
                // No orbit in q: it is told by its points, seen twice.
                if has_turned == now.n_periods {
                    let turning = self.repeating(&run, now.n_periods, now.pattern, TURNS.into());
                    return turning.map(attractor);
                }
                has_turned = now.n_periods;
                continue;
            }
            match self.polished(&run, now.n_periods, go_on) {
                Ok(Some(orbit)) => {
                    let pattern = of_one_round(&now, orbit.n_periods())?;
                    return Ok(attractor(self.periodic(orbit, pattern)?));
                }
                // It comes nearer slowly: further on it is told again.
                Ok(None) => {}
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Err(error) => {
                    reason = error.to_string();
                    if done + window > limit {
                        return Ok(attractor(self.repeating(
                            &run,
                            now.n_periods,
                            now.pattern,
                            reason,
                        )?));
                    }
                }
            }
        }
    }

    /// A run of some periods, from so many after the start.
    fn run(
        &self,
        (q, v): &PhysicalState,
        first: usize,
        periods: usize,
        keep: Keep,
        go_on: ObserverFn<'_>,
    ) -> Result<Trajectory> {
        let options = self.options.run(keep);
        let time = |periods: usize| self.start + self.period * periods as f64;
        let span = (time(first), time(first + periods));
        simulate_observed(self.scene, q, v, span, &options, &mut |_| go_on())
    }

    /// Whether a motion has left the surroundings of the box.
    fn is_far(&self, run: &Trajectory) -> bool {
        let (q, v) = run.last();
        self.around.beyond(q.iter().chain(v.iter())) > FAR
    }

    /// Whether an angle goes round in a number of periods.
    fn turns(&self, run: &Trajectory, n_periods: usize) -> Result<bool> {
        let turns = self.around.turns();
        if turns.iter().all(|turn| *turn == 0.0) {
            return Ok(false);
        }
        let found = points_of(
            &Motion::Trajectory(run),
            &Section::Phase(self.options.phase),
        )?;
        let last = found.q.nrows().saturating_sub(1);
        let goes_round = |(i, turn): (usize, &f64)| {
            let off = found.q[(last, i)] - found.q[(last.saturating_sub(n_periods), i)];
            *turn > 0.0 && off.abs() > 0.5 * turn
        };
        Ok(turns.iter().enumerate().any(goes_round))
    }

    /// The orbit that is known of a motion of some periods.
    fn known_one(&self, run: &Trajectory, n_periods: usize) -> Result<Option<&Attractor>> {
        let mut known = self
            .known
            .iter()
            .filter(|one| one.n_periods == n_periods)
            .peekable();
        if known.peek().is_none() {
            return Ok(None);
        }
        let all = self.points(&Motion::Trajectory(run))?;
        let last = all.nrows().saturating_sub(n_periods);
        let points = all.rows_range(last..).into_owned();
        Ok(known.find(|one| are_points_within(&one.points, &points, self.around, CLOSE)))
    }

    /// The orbit that a motion is near; none where it is another, or unstable.
    fn polished(
        &self,
        run: &Trajectory,
        n_periods: usize,
        go_on: ObserverFn<'_>,
    ) -> Result<Option<PeriodicOrbit>> {
        let mut orbit = find_orbit_observed(self.scene, run, Some(n_periods), go_on)?;
        let round = rounds(&orbit, self.period);
        if round < n_periods {
            orbit = find_orbit_observed(self.scene, run, Some(round), go_on)?;
        }
        let stability = orbit.stability_observed(go_on)?;
        if stability.is_stable == Some(false) {
            return Ok(None);
        }
        let largest = stability
            .orders
            .first()
            .map_or(0.0, OrderMultipliers::spectral_radius);
        if largest > NEUTRAL {
            return Ok(None);
        }
        let allowed = NEAR / (1.0 - largest);
        // At the phase at which the period begins, between impacts.
        let (t, period) = (run.t_end(), orbit.period());
        let late = (run.forcing_phase()(t) - orbit.phase()).rem_euclid(TAU) / TAU * self.period;
        let (q, v) = run.last();
        let mut apart = f64::INFINITY;
        let mut size: f64 = 0.0;
        for k in 0..n_periods {
            let (p, u) = orbit.state((late + k as f64 * self.period).rem_euclid(period), true);
            size = size.max(p.amax()).max(u.amax() * self.period / TAU);
            let off = (q - p).amax().max((v - u).amax() * self.period / TAU);
            apart = apart.min(off);
        }
        Ok((apart <= allowed * size).then_some(orbit))
    }

    /// The points of a motion at the phase.
    fn points(&self, motion: &dyn Sectioned) -> Result<DMatrix<f64>> {
        let found = points_of(motion, &Section::Phase(self.options.phase))?;
        Ok(self.around.within_turns(states((&found.q, &found.v))))
    }

    fn periodic(&self, orbit: PeriodicOrbit, pattern: Pattern) -> Result<Attractor> {
        let multipliers = &orbit.stability()?.orders;
        let rates = multipliers.first().map(|order| {
            let each = order.multipliers.iter();
            each.map(|mu| mu.norm().ln() / orbit.period()).collect()
        });
        let points = self.points(&Motion::Orbit(&orbit))?;
        let is_at_rest = orbit.impacts().is_empty()
            && (0..8).all(|k| {
                let (q, v) = orbit.state(orbit.period() * f64::from(k) / 8.0, false);
                let size = q.amax().max(f64::MIN_POSITIVE);
                v.amax() * self.period <= NEAR * size
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

    /// What repeats itself and has no orbit, for a reason.
    fn repeating(
        &self,
        run: &Trajectory,
        n_periods: usize,
        pattern: Pattern,
        reason: String,
    ) -> Result<Attractor> {
        let all = self.points(&Motion::Trajectory(run))?;
        let first = all.nrows().saturating_sub(n_periods + 1);
        let points = all.rows(first, n_periods.min(all.nrows())).into_owned();
        Ok(Attractor {
            kind: AttractorKind::Periodic,
            n_periods,
            points,
            exponents: Vec::new(),
            pattern,
            reason,
            orbit: None,
            fraction: 0.0,
        })
    }
}

/// The periods after which an orbit repeats itself: it may have been found going round several times.
fn rounds(orbit: &PeriodicOrbit, period: f64) -> usize {
    let n = orbit.n_periods();
    let states: Vec<PhysicalState> = (0..n)
        .map(|k| orbit.state(k as f64 * period, true))
        .collect();
    let size = |(q, v): &PhysicalState| q.amax().max(v.amax() * period / TAU);
    let largest = states.iter().map(size).fold(0.0, f64::max);
    let apart = |(q, v): &PhysicalState, (p, u): &PhysicalState| {
        (q - p).amax().max((v - u).amax() * period / TAU)
    };
    let is_round = |m: &usize| {
        n.is_multiple_of(*m)
            && (0..n).all(|k| apart(&states[k], &states[(k + m) % n]) <= ROUND * largest)
    };
    (1..=n).find(is_round).unwrap_or(n)
}

/// The stops hit in one round of what was seen to repeat itself after several.
fn of_one_round(seen: &Settled, round: usize) -> Result<Pattern> {
    let instants = seen.pattern.instants();
    Pattern::new(instants[..instants.len() * round / seen.n_periods.max(1)].to_vec())
}

pub(super) fn attractor(found: Attractor) -> Found {
    Found::Attractor(Box::new(found))
}

/// Rows of positions and of velocities as rows of states.
pub(super) fn states((q, v): (&DMatrix<f64>, &DMatrix<f64>)) -> DMatrix<f64> {
    let n = q.ncols();
    DMatrix::from_fn(q.nrows(), 2 * n, |k, j| {
        if j < n { q[(k, j)] } else { v[(k, j - n)] }
    })
}

/// The last state of a run.
fn owned(run: &Trajectory) -> (DVector<f64>, DVector<f64>) {
    let (q, v) = run.last();
    (q.clone(), v.clone())
}

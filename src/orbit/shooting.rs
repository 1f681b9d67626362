//! Periodic motions of any pattern from a guess (theory 5): Newton's method on the states after the impacts and on the
//! times of the impacts, all at once (multiple shooting). A time is an unknown with its own equation, the gap of the stop
//! hit; nothing asks which stop is met first, so the method stays regular where an impact loses its speed.

use crate::error::{Error, Result};
use crate::linalg::rank;
use crate::orbit::Pattern;
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

/// Largest scaled mismatch of what counts as closed.
const CLOSED: f64 = 1e-11;
/// Newton steps before giving up.
const MOST_STEPS: usize = 60;
/// Halvings of a Newton step that does not bring the motion nearer to closing.
const MOST_HALVINGS: i32 = 12;
/// Singular values below this, relative to the largest entry, belong to directions in which the orbit may be changed.
const FREE_DIRECTION: f64 = 1e-12;

/// Smooth motion and impacts as the shooting sees them. A state is `(q, v)`; deviations are columns of such.
pub(crate) trait Motion {
    /// Carries a state from one time to another and multiplies deviations by the Jacobian of the flow.
    fn fly(
        &self,
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()>;
    /// The rate of change of a state.
    fn rate(&self, t: f64, state: &DVector<f64>) -> Result<DVector<f64>>;
    /// Applies the impacts of the stops hit together at a fixed time, and returns their impulses.
    fn collide(
        &self,
        stops: &[usize],
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>>;
    /// The gap of a stop and its gradient in q, shape `(n,)`.
    fn gap(&self, stop: usize, state: &DVector<f64>) -> Result<(f64, DVector<f64>)>;
}

/// A motion between impacts, closed or nearly so: flight k goes from `times[k]` to `times[k + 1]`, and its state is the
/// one right after the impacts at its start.
#[derive(Debug, Clone)]
pub(crate) struct Loop {
    /// One more than there are flights.
    pub times: Vec<f64>,
    pub states: Vec<DVector<f64>>,
}

/// What a flight ends with.
#[derive(Debug, Clone)]
pub(crate) struct Landing {
    /// The state before the impacts.
    pub before: DVector<f64>,
    /// The impulses of the impacts.
    pub impulses: Vec<f64>,
}

/// The times that are unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clocked {
    /// By a forcing: every impact has its time, and the last flight ends one period after the first began.
    Forced { period: f64 },
    /// By nothing: time counts from the first impact, and the period is an unknown.
    Free,
}

/// One periodic problem.
pub(crate) struct Shooting<'a, M> {
    pub motion: &'a M,
    pub pattern: &'a Pattern,
    pub clocked: Clocked,
}

/// Units in which mismatches and corrections are measured.
struct Units {
    position: f64,
    velocity: f64,
    time: f64,
}

/// The equations linearised about a loop: `rows xi = right`, and every state's correction `states[k] (xi, 1)`.
struct Linearised {
    rows: DMatrix<f64>,
    right: DVector<f64>,
    states: Vec<DMatrix<f64>>,
}

impl<M: Motion> Shooting<'_, M> {
    /// The closed loop near a guess, and the ends of its flights.
    pub fn solve(
        &self,
        guess: Loop,
        observer: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<(Loop, Vec<Landing>)> {
        let mut current = guess;
        let mut units = self.units(&current);
        let mut mismatch = self.mismatch(&current, &units)?;
        let mut steps = 0;
        while steps < MOST_STEPS {
            if observer().is_break() {
                return Err(Error::Interrupted);
            }
            let correction = self.correction(&current, &units)?;
            let Some((next, left)) = self.corrected(&current, &correction, mismatch, &units)?
            else {
                break;
            };
            (current, mismatch) = (next, left);
            units = self.units(&current);
            steps += 1;
        }
        if mismatch <= CLOSED {
            let landings = self.landings(&current)?;
            return Ok((current, landings));
        }
        Err(Error::NoConvergence {
            stage: "the shooting on flight times",
            iterations: steps,
            residual: mismatch,
        })
    }

    fn instant(&self, k: usize) -> &[usize] {
        let instants = self.pattern.instants();
        match instants.len() {
            0 => &[],
            count => &instants[k % count],
        }
    }

    /// The unknown that the time of instant k is, among the times.
    fn time_index(&self, k: usize) -> Option<usize> {
        match (self.pattern.instants().len(), self.clocked) {
            (0, _) => None,
            (count, Clocked::Forced { .. }) => Some(k % count),
            (_, Clocked::Free) => k.checked_sub(1),
        }
    }

    fn units(&self, state: &Loop) -> Units {
        let n = state.states[0].len() / 2;
        let largest = |first: usize| {
            state
                .states
                .iter()
                .map(|x| x.rows(first, n).amax())
                .fold(0.0, f64::max)
        };
        let period = match self.clocked {
            Clocked::Forced { period } => period,
            Clocked::Free => state.times[state.times.len() - 1] - state.times[0],
        };
        let time = period / std::f64::consts::TAU;
        let (position, velocity) = (largest(0), largest(n));
        let or_one = |x: f64| if x > 0.0 { x } else { 1.0 };
        let position = or_one(position.max(velocity * time));
        Units {
            position,
            velocity: or_one(velocity.max(position / time)),
            time,
        }
    }

    /// The ends of all flights.
    fn landings(&self, state: &Loop) -> Result<Vec<Landing>> {
        let mut none = DMatrix::zeros(state.states[0].len(), 0);
        (0..state.states.len())
            .map(|k| {
                let mut before = state.states[k].clone();
                self.motion
                    .fly((state.times[k], state.times[k + 1]), &mut before, &mut none)?;
                let mut after = before.clone();
                let impulses = self
                    .motion
                    .collide(self.instant(k + 1), &mut after, &mut none)?;
                Ok(Landing { before, impulses })
            })
            .collect()
    }

    /// The largest of all gaps at impacts and of all jumps between flights, in their units.
    fn mismatch(&self, state: &Loop, units: &Units) -> Result<f64> {
        let n = state.states[0].len() / 2;
        let mut none = DMatrix::zeros(2 * n, 0);
        let mut worst = 0.0f64;
        let count = state.states.len();
        for k in 0..count {
            for &stop in self.instant(k) {
                let (gap, gradient) = self.motion.gap(stop, &state.states[k])?;
                worst = worst.max((gap / (gradient.amax() * units.position)).abs());
            }
            let mut end = state.states[k].clone();
            self.motion
                .fly((state.times[k], state.times[k + 1]), &mut end, &mut none)?;
            self.motion
                .collide(self.instant(k + 1), &mut end, &mut none)?;
            end -= &state.states[(k + 1) % count];
            worst = worst
                .max(end.rows(0, n).amax() / units.position)
                .max(end.rows(n, n).amax() / units.velocity);
        }
        Ok(if worst.is_nan() { f64::INFINITY } else { worst })
    }

    /// The equations about a loop. The corrections of all states follow from that of the first one and from those of the
    /// times, `xi`, so that these alone are solved for.
    fn linearised(&self, state: &Loop, units: &Units) -> Result<Linearised> {
        let flights = state.states.len();
        let (two_n, n_times) = (state.states[0].len(), self.pattern.instants().len());
        let (n, unknowns) = (two_n / 2, two_n + n_times);
        let scale = |i: usize| {
            if i < n {
                units.position
            } else {
                units.velocity
            }
        };
        // Columns: the first state, the times, and what the flights do not close by.
        let mut deviations = DMatrix::zeros(two_n, unknowns + 1);
        for i in 0..two_n {
            deviations[(i, i)] = scale(i);
        }
        let mut rows = Vec::new();
        let mut states = Vec::with_capacity(flights);
        for k in 0..flights {
            for &stop in self.instant(k) {
                let (gap, gradient) = self.motion.gap(stop, &state.states[k])?;
                let mut row = deviations.rows(0, n).tr_mul(&gradient);
                row[unknowns] += gap;
                rows.push(row / (gradient.amax() * units.position));
            }
            states.push(deviations.clone());
            let shift = |deviations: &mut DMatrix<f64>, instant: usize, rate: DVector<f64>| {
                if let Some(j) = self.time_index(instant) {
                    let mut column = deviations.column_mut(two_n + j);
                    column += rate * units.time;
                }
            };
            let rate = self.motion.rate(state.times[k], &state.states[k])?;
            shift(&mut deviations, k, -rate);
            let mut end = state.states[k].clone();
            self.motion.fly(
                (state.times[k], state.times[k + 1]),
                &mut end,
                &mut deviations,
            )?;
            let rate = self.motion.rate(state.times[k + 1], &end)?;
            shift(&mut deviations, k + 1, rate);
            self.motion
                .collide(self.instant(k + 1), &mut end, &mut deviations)?;
            end -= &state.states[(k + 1) % flights];
            let mut open = deviations.column_mut(unknowns);
            open += end;
        }
        for i in 0..two_n {
            deviations[(i, i)] -= scale(i);
            rows.push(deviations.row(i).transpose() / scale(i));
        }
        let all = DMatrix::from_columns(&rows).transpose();
        Ok(Linearised {
            right: -all.column(unknowns).into_owned(),
            rows: all.columns(0, unknowns).into_owned(),
            states,
        })
    }

    /// Newton's correction of every time and state; of many the least.
    fn correction(&self, state: &Loop, units: &Units) -> Result<Loop> {
        let Linearised {
            rows,
            right,
            states,
        } = self.linearised(state, units)?;
        let tolerance = FREE_DIRECTION * rows.amax();
        let xi = rank::solve(&rows, &right, tolerance)?.particular;
        let two_n = state.states[0].len();
        let times = (0..state.times.len())
            .map(|k| {
                self.time_index(k)
                    .map_or(0.0, |j| xi[two_n + j] * units.time)
            })
            .collect();
        let with_one = xi.push(1.0);
        let states = states.iter().map(|d| d * &with_one).collect();
        Ok(Loop { times, states })
    }

    /// The loop after as much of a correction as brings it nearer to closing, and what it then lacks.
    fn corrected(
        &self,
        state: &Loop,
        correction: &Loop,
        mismatch: f64,
        units: &Units,
    ) -> Result<Option<(Loop, f64)>> {
        // What is closed is only polished.
        let tries = if mismatch <= CLOSED { 1 } else { MOST_HALVINGS };
        for halvings in 0..tries {
            let part = 0.5f64.powi(halvings);
            let times: Vec<f64> = state
                .times
                .iter()
                .zip(&correction.times)
                .map(|(t, d)| t + part * d)
                .collect();
            if times.windows(2).any(|w| w[1] <= w[0]) {
                continue;
            }
            let states = state
                .states
                .iter()
                .zip(&correction.states)
                .map(|(x, d)| x + d * part)
                .collect();
            let next = Loop { times, states };
            let left = match self.mismatch(&next, units) {
                Ok(left) => left,
                Err(Error::NoConvergence { .. }) => continue,
                Err(error) => return Err(error),
            };
            if left < (1.0 - 0.25 * part) * mismatch {
                return Ok(Some((next, left)));
            }
        }
        Ok(None)
    }
}

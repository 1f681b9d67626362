//! Newton's method on a loop (theory 5): the linearised equations, the correction of least norm, and as much of it as brings the loop nearer
//! to closing. Unknowns xi: the first state and the times of the instants, in `ScaledUnits` [-].

use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::itinerary::ArcEnd;
use crate::linalg::rank;
use crate::linalg::singular::Singular;
use crate::observer::unless_broken_off;
use crate::orbit::shooting::closure::{
    Clocked, MOST_SHOOTING_STEPS, Mismatch, Shooting, ShootingState,
};
use crate::orbit::shooting::transported_flight::{FlightMap, TransportedFlight};
use crate::tolerance::{NEAR_FOLD, SHRUNK_MOTION, ZERO_MISMATCH};
use nalgebra::{DMatrix, DVector};

/// Halvings of a Newton step that does not bring the motion nearer to closing. [work]
const MOST_CORRECTION_HALVINGS: i32 = 12;

/// The equations linearised about a loop: `rows xi = right`, and the corrections `times[k] (xi, 1)` of every instant, `states[k] (xi, 1)`
/// and `starts[k] (xi, 1)` of every flight.
#[derive(Debug, Clone)]
pub(crate) struct Linearised {
    /// Derivatives of the residuals by the unknowns xi: the first state in units of positions and velocities, then the times that are unknown
    /// in units of time, shape (equations, unknowns), [-] in `ScaledUnits`.
    pub rows: DMatrix<f64>,
    /// The residuals with the opposite sign, shape (equations,), [-] in `ScaledUnits`.
    pub right: DVector<f64>,
    /// How far the loop is from closing.
    pub mismatch: f64,
    /// The part of `rows` that multiplies the unknowns a period later, which are those at the start, shape (equations, unknowns), [-].
    pub closing: DMatrix<f64>,
    times: Vec<DVector<f64>>,
    starts: Vec<DVector<f64>>,
    states: Vec<DMatrix<f64>>,
    /// The maps of the flights, where they were made.
    flights: Vec<Option<FlightMap>>,
}

impl Linearised {
    /// The rows of a deviation that comes back multiplied: square, they are singular if the number is a multiplier, without forcing if it
    /// is one beside that of the phase (theory 19).
    pub fn returning(&self, multiplier: f64) -> DMatrix<f64> {
        &self.rows + &self.closing * (multiplier - 1.0)
    }

    /// The corrections of every time and state that follow from those of the unknowns; without unknowns, those that close the flights one
    /// after the other.
    pub fn corrections(&self, xi: &DVector<f64>) -> ShootingState {
        self.of(xi.clone().push(1.0))
    }

    /// The deviations of every time and state that follow from those of the unknowns.
    pub fn deviations(&self, xi: &DVector<f64>) -> ShootingState {
        self.of(xi.clone().push(0.0))
    }

    fn of(&self, numbers: DVector<f64>) -> ShootingState {
        let each = |rows: &[DVector<f64>]| rows.iter().map(|d| d.dot(&numbers)).collect();
        ShootingState {
            times: each(&self.times),
            starts: each(&self.starts),
            states: self.states.iter().map(|d| d * &numbers).collect(),
        }
    }
}

/// Newton's correction of every time and state; of many the least, none along directions that are as weak as this.
fn least_correction(equations: &Linearised, weak: f64) -> Result<ShootingState> {
    let tolerance = weak * equations.rows.amax();
    let xi = rank::solve(&equations.rows, &equations.right, tolerance)?.particular;
    Ok(equations.corrections(&xi))
}

impl Shooting<'_> {
    /// The closed loop near a guess, and the ends of its flights.
    pub fn solve(&self, guess: ShootingState) -> Result<(ShootingState, Vec<ArcEnd>)> {
        let mut current = guess;
        let mut units = self.units(&current)?;
        let first_units = units;
        let mut mismatch = self.mismatch(&current, &units)?;
        let mut steps = 0;
        while steps < MOST_SHOOTING_STEPS && mismatch > ZERO_MISMATCH {
            unless_broken_off()?;
            let equations = self.linearised(&current, &units)?;
            let mut better = None;
            for weak in self.weak_directions {
                let correction = least_correction(&equations, weak)?;
                better = self.corrected((&current, mismatch), &correction, &units)?;
                if better.is_some() {
                    break;
                }
            }
            let Some((next, left)) = better else {
                break;
            };
            (current, mismatch) = (next, left);
            units = self.units(&current)?;
            steps += 1;
        }
        // Without forcing a state of rest closes at any period.
        let is_lost =
            self.clocked == Clocked::Free && units.velocity <= SHRUNK_MOTION * first_units.velocity;
        if mismatch <= self.motion.closes_to() && !is_lost {
            let flight_ends = self.flight_ends(&current, &units)?;
            return Ok((current, flight_ends));
        }
        let stage = if is_lost {
            "the shooting on flight times, which shrinks the motion to nothing,"
        } else if self.is_near_fold(&current, &units)? {
            "the shooting on flight times, whose equations are singular where it stops: there is a fold nearby, beyond which the scene may have \
             no such motion; continuation follows it to where it turns back. It"
        } else {
            "the shooting on flight times"
        };
        Err(Error::NoConvergence {
            stage,
            iterations: steps,
            residual: mismatch,
        })
    }

    /// Whether the equations about a loop are singular but for a small part: two motions of the pattern meet nearby.
    fn is_near_fold(&self, state: &ShootingState, units: &ScaledUnits) -> Result<bool> {
        let Ok(equations) = self.linearised(state, units) else {
            return Ok(false);
        };
        let rows = &equations.rows;
        let found = Singular::new(rows)?;
        let mut values: Vec<f64> = (0..rows.ncols()).map(|k| found.value(k)).collect();
        values.sort_by(f64::total_cmp);
        let spare = rows.ncols().saturating_sub(rows.nrows());
        Ok(values[spare] <= NEAR_FOLD * values[values.len() - 1])
    }

    /// The equations about a loop. The corrections of all states follow from that of the first one and from those of the
    /// times, `xi`, so that these alone are solved for.
    pub(crate) fn linearised(
        &self,
        state: &ShootingState,
        units: &ScaledUnits,
    ) -> Result<Linearised> {
        self.equations(state, units, self.n_unknowns(state), &[])
    }

    /// The residuals of a loop beside another one, and the corrections that close its flights one after the other from the first state:
    /// equations without unknowns, with the maps of the flights of the other loop where they are known.
    pub(crate) fn lacking(
        &self,
        state: &ShootingState,
        units: &ScaledUnits,
        beside: &Linearised,
    ) -> Result<Linearised> {
        self.equations(state, units, 0, &beside.flights)
    }

    /// How many unknowns there are: the first state, and the times.
    fn n_unknowns(&self, state: &ShootingState) -> usize {
        state.states[0].len() + self.n_times()
    }

    /// The equations of the first state and the times, or of none of them; flights by their maps where these are known.
    fn equations(
        &self,
        state: &ShootingState,
        units: &ScaledUnits,
        unknowns: usize,
        known: &[Option<FlightMap>],
    ) -> Result<Linearised> {
        let flights = state.states.len();
        let two_n = state.states[0].len();
        let n = two_n / 2;
        let scale = |i: usize| {
            if i < n {
                units.position
            } else {
                units.velocity
            }
        };
        // Columns: the first state, the times, and what the flights do not close by; in the end the time of the first instant a period
        // later, if that is one of the times.
        let mut deviations = DMatrix::zeros(two_n, unknowns + 1);
        for i in 0..two_n.min(unknowns) {
            deviations[(i, i)] = scale(i);
        }
        let mut delays = self.shift(0, unknowns, units);
        let mut rows = Vec::new();
        let mut worst = Mismatch::default();
        let (mut states, mut starts) = (Vec::with_capacity(flights), Vec::with_capacity(flights));
        let mut maps = Vec::with_capacity(flights);
        let mut meetings = Vec::new();
        for k in 0..flights {
            for stop in self.closing(k) {
                let at = self.motion.gap(stop, state.start(k), &state.states[k])?;
                let mut row = at.timed_deviations(&deviations, &delays);
                row[unknowns] += at.gap;
                let size = at.gradient.amax() * units.position;
                worst.note(at.gap / size);
                rows.push(row / size);
            }
            states.push(deviations.clone());
            starts.push(delays.clone());
            let start = state.starts[k];
            let rate = self.motion.rate(self.regime(k), start, &state.states[k])?;
            deviations -= rate * delays.transpose();
            let TransportedFlight { y, condition, map } = match known.get(k) {
                Some(Some(map)) => self.transported_by(map, k, (state, units), &deviations)?,
                _ => self.transported(k, (state, units), deviations)?,
            };
            if let Some((condition, mut row)) = condition {
                row[unknowns] += condition;
                worst.note(condition);
                rows.push(row);
            }
            if let Some(own) = self.meeting(k + 1) {
                meetings.push((own, y.clone()));
            }
            maps.push(map);
            self.note_jump(k, (state, units), &y, &mut worst)?;
            (deviations, delays) = (y.deviations, y.delays);
            let mut open = deviations.column_mut(unknowns);
            open += y.state - &state.states[(k + 1) % flights];
            delays[unknowns] += y.time - self.next_start(k, state);
        }
        for (own, y) in &meetings {
            let known = (&states[..], &starts[..]);
            let (distance, mut row) = self.distance(own, (state, units), y, known)?;
            row[unknowns] += distance;
            worst.note(distance);
            rows.push(row);
        }
        let own = rows.len();
        for i in 0..two_n {
            if i < unknowns {
                deviations[(i, i)] -= scale(i);
            }
            rows.push(deviations.row(i).transpose() / scale(i));
        }
        let mut all = DMatrix::from_fn(rows.len(), unknowns + 1, |i, j| rows[i][j]);
        let mut closing = DMatrix::zeros(rows.len(), unknowns);
        for i in 0..two_n.min(unknowns) {
            closing[(own + i, i)] = -1.0;
        }
        for (i, row) in rows.iter().enumerate() {
            if let Some(later) = row.get(unknowns + 1) {
                closing[(i, two_n)] += *later;
                all[(i, two_n)] += *later;
            }
        }
        Ok(Linearised {
            right: -all.column(unknowns).into_owned(),
            rows: all.columns(0, unknowns).into_owned(),
            closing,
            mismatch: worst.size,
            times: (0..=flights)
                .map(|k| self.shift(k, unknowns, units))
                .collect(),
            starts,
            states,
            flights: maps,
        })
    }

    /// The derivatives of the time of instant k by the unknowns [s].
    pub(super) fn shift(&self, k: usize, unknowns: usize, units: &ScaledUnits) -> DVector<f64> {
        let mut delays = DVector::zeros(unknowns + 1);
        if let Some(j) = self.time_index(k).filter(|_| unknowns > 0) {
            delays[unknowns - self.n_times() + j] = units.time;
        }
        delays
    }

    /// The loop after as much of a correction as brings it nearer to closing, and what it then lacks.
    fn corrected(
        &self,
        (state, mismatch): (&ShootingState, f64),
        correction: &ShootingState,
        units: &ScaledUnits,
    ) -> Result<Option<(ShootingState, f64)>> {
        // A loop that is closed is only polished.
        let tries = if mismatch <= self.motion.closes_to() {
            1
        } else {
            MOST_CORRECTION_HALVINGS
        };
        for halvings in 0..tries {
            unless_broken_off()?;
            let part = 0.5f64.powi(halvings);
            let next = state.moved(correction, part);
            let flights = next.starts.iter().zip(next.times.windows(2));
            if flights.into_iter().any(|(s, w)| *s < w[0] || w[1] <= *s) {
                continue;
            }
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

//! A flight of a loop with the instant at its end, as deviations see it: what they become, and the map that does it, which serves for
//! loops beside.

use crate::error::Result;
use crate::hybrid::ScaledUnits;
use crate::hybrid::Timed;
use crate::orbit::shooting::closure::{Clocked, Shooting, ShootingState};
use nalgebra::{DMatrix, DVector};

/// A flight and the instant at its end: what is behind that, and the condition of the instant with what deviations make of it.
pub(super) struct Carried {
    pub y: Timed,
    pub condition: Option<(f64, DVector<f64>)>,
    /// What makes them of others, where it was made on the way.
    pub map: Option<FlightMap>,
}

/// What a flight and the instant at its end make of deviations at the time of its start.
#[derive(Debug, Clone)]
pub(super) struct FlightMap {
    deviations: DMatrix<f64>,
    /// Of where the next flight begins.
    delays: DVector<f64>,
    /// Of the condition of the instant, if it has one.
    condition: Option<DVector<f64>>,
}

impl FlightMap {
    /// Takes off the columns from one on, which are what becomes of every coordinate and velocity.
    fn taken_off(own: usize, y: &mut Timed, condition: &mut Option<(f64, DVector<f64>)>) -> Self {
        let len = y.deviations.ncols() - own;
        let map = Self {
            deviations: y.deviations.columns(own, len).into_owned(),
            delays: y.delays.rows(own, len).into_owned(),
            condition: condition
                .as_ref()
                .map(|(_, row)| row.rows(own, len).into_owned()),
        };
        y.deviations.resize_horizontally_mut(own, 0.0);
        y.delays.resize_vertically_mut(own, 0.0);
        if let Some((_, row)) = condition {
            row.resize_vertically_mut(own, 0.0);
        }
        map
    }
}

impl Shooting<'_> {
    /// What flight k and the instant at its end make of a state and of deviations from it at the time of its start.
    pub(super) fn carried(
        &self,
        k: usize,
        (state, units): (&ShootingState, &ScaledUnits),
        mut deviations: DMatrix<f64>,
    ) -> Result<Carried> {
        let (two_n, unknowns) = (deviations.nrows(), deviations.ncols() - 1);
        let end = state.times[k + 1];
        let mut x = state.states[k].clone();
        let jacobian = self.fly(k, state, (&mut x, &mut deviations))?;
        let mut delays = self.shift(k + 1, unknowns, units);
        let is_last = k + 1 == state.states.len();
        if is_last && self.clocked != Clocked::Free && unknowns > two_n {
            let columns = unknowns + 1;
            deviations = deviations.insert_column(columns, 0.0);
            delays = delays.push(0.0);
            delays.swap_rows(two_n, columns);
        }
        deviations += self.motion.rate(self.held(k), end, &x)? * delays.transpose();
        let own = deviations.ncols();
        if let Some(jacobian) = &jacobian {
            deviations = deviations.insert_columns(own, two_n, 0.0);
            deviations.columns_mut(own, two_n).copy_from(jacobian);
            delays = delays.insert_rows(own, two_n, 0.0);
        }
        let mut y = Timed {
            time: end,
            state: x,
            deviations,
            delays,
        };
        self.mirror(k, state, &mut y);
        let mut condition = self.condition(k + 1, units, &y)?;
        self.pass(k + 1, units, &mut y)?;
        let map = jacobian.map(|_| FlightMap::taken_off(own, &mut y, &mut condition));
        Ok(Carried { y, condition, map })
    }

    /// The same by what the flight of another loop makes of deviations.
    pub(super) fn carried_by(
        &self,
        map: &FlightMap,
        k: usize,
        (state, units): (&ShootingState, &ScaledUnits),
        deviations: &DMatrix<f64>,
    ) -> Result<Carried> {
        let mut y = self.flown(k, state)?;
        let condition = self.condition(k + 1, units, &y)?;
        self.pass(k + 1, units, &mut y)?;
        y.deviations = &map.deviations * deviations;
        y.delays = deviations.tr_mul(&map.delays);
        let condition = condition.zip(map.condition.as_ref());
        Ok(Carried {
            y,
            condition: condition.map(|((value, _), row)| (value, deviations.tr_mul(row))),
            map: None,
        })
    }
}

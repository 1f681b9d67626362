//! Transport of deviations along one flight of a loop and across the instant at its end; the map of it serves for loops beside, too.

use crate::error::Result;
use crate::hybrid::ScaledUnits;
use crate::hybrid::Timed;
use crate::orbit::shooting::closure::{Clocked, Shooting, ShootingState};
use nalgebra::{DMatrix, DVector};

/// The outcome of a flight and the instant at its end.
pub(super) struct TransportedFlight {
    pub y: Timed,
    /// The scaled residual of the condition of the instant, if it has one, and its derivatives by the deviations, shape (deviations,), [-] in
    /// `ScaledUnits`.
    pub condition: Option<(f64, DVector<f64>)>,
    /// The map that transports further deviations, where it was made.
    pub map: Option<FlightMap>,
}

/// The linear map of deviations along a flight and across the instant at its end.
#[derive(Debug, Clone)]
pub(super) struct FlightMap {
    deviations: DMatrix<f64>,
    /// Delays of the start of the next flight.
    delays: DVector<f64>,
    /// Derivatives of the condition of the instant, if it has one.
    condition: Option<DVector<f64>>,
}

impl FlightMap {
    /// Takes the columns from `own` on, which hold the transport of every coordinate and velocity, off the deviations.
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
    /// Transports a state and deviations of it along flight k and across the instant at its end.
    pub(super) fn transported(
        &self,
        k: usize,
        (state, units): (&ShootingState, &ScaledUnits),
        mut deviations: DMatrix<f64>,
    ) -> Result<TransportedFlight> {
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
        deviations += self.motion.rate(self.regime(k), end, &x)? * delays.transpose();
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
        Ok(TransportedFlight { y, condition, map })
    }

    /// The same, deviations by the map of that flight in another loop.
    pub(super) fn transported_by(
        &self,
        map: &FlightMap,
        k: usize,
        (state, units): (&ShootingState, &ScaledUnits),
        deviations: &DMatrix<f64>,
    ) -> Result<TransportedFlight> {
        let mut y = self.end_of_flight(k, state)?;
        let condition = self.condition(k + 1, units, &y)?;
        self.pass(k + 1, units, &mut y)?;
        y.deviations = &map.deviations * deviations;
        y.delays = deviations.tr_mul(&map.delays);
        let condition = condition.zip(map.condition.as_ref());
        Ok(TransportedFlight {
            y,
            condition: condition.map(|((value, _), row)| (value, deviations.tr_mul(row))),
            map: None,
        })
    }
}

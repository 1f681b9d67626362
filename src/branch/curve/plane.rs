//! Scenes of two numbers, and loops in them.

use crate::branch::boundary::is_broken;
use crate::branch::curve::condition::Condition;
use crate::branch::equations::Equations;
use crate::branch::family::{Family, span_of, stretched};
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{PeriodicOrbit, ScaledUnits, Signature};
use nalgebra::{DMatrix, DVector};

/// The step of the differences of a condition, in scaled unknowns.
const STEP: f64 = 6e-6;

/// The scenes of two numbers, what happens along the orbits, and what holds on the curve.
pub(super) struct Plane<'a> {
    pub make: &'a dyn Fn(f64, f64) -> Result<Scene>,
    /// The ranges of both.
    pub between: [(f64, f64); 2],
    pub signature: Signature,
    pub phase: f64,
    pub is_free: bool,
    pub units: ScaledUnits,
    pub condition: Condition,
    /// Whether the impact of no speed is not one of the orbits, which touch the stop.
    pub is_touch: bool,
}

/// A loop at two numbers.
#[derive(Debug, Clone)]
pub(super) struct Spot {
    /// The loop, at the first number.
    pub place: Place,
    pub second: f64,
}

/// The equations of a loop and of what holds on the curve at a spot: `matrix y = right`, y the unknowns of the loop and both numbers in
/// parts of their ranges.
#[derive(Clone)]
pub(super) struct Conditions {
    pub matrix: DMatrix<f64>,
    pub right: DVector<f64>,
    /// How far the loop is from closing.
    pub mismatch: f64,
    first: Equations,
    second: Equations,
}

impl Plane<'_> {
    /// Does some work with the scenes over the first number, or over the second, the other as at a spot.
    pub fn along<T>(
        &self,
        axis: usize,
        spot: &Spot,
        work: impl FnOnce(&Family<'_>) -> Result<T>,
    ) -> Result<T> {
        let (first, second) = (spot.place.value, spot.second);
        let over_first = |value: f64| (self.make)(value, second);
        let over_second = |value: f64| (self.make)(first, value);
        let make: &dyn Fn(f64) -> Result<Scene> =
            if axis == 0 { &over_first } else { &over_second };
        work(&Family {
            make,
            range: self.between[axis],
            signature: self.signature.clone(),
            phase: self.phase,
            is_free: self.is_free,
            units: self.units,
            energetics: None,
            has_pulses: false,
        })
    }

    /// A spot at another value of one of the numbers, its instants at the same phases.
    pub fn at_value(&self, spot: &Spot, axis: usize, value: f64) -> Result<Spot> {
        let mut values = [spot.place.value, spot.second];
        let from = (self.make)(values[0], values[1])?;
        values[axis] = value;
        let to = (self.make)(values[0], values[1])?;
        let state = stretched(&spot.place.state, &from, &to);
        let there = Spot {
            place: spot.place.clone(),
            second: values[1],
        };
        Ok(Spot {
            place: self.along(0, &there, |family| family.place(&to, values[0], state))?,
            second: values[1],
        })
    }

    /// The unit of a number.
    pub fn span(&self, axis: usize) -> f64 {
        span_of(self.between[axis])
    }

    /// The orbit of a spot where the loop is closed.
    pub fn orbit(&self, spot: &Spot) -> Result<PeriodicOrbit> {
        if self.is_touch {
            return self.judged(spot);
        }
        self.along(0, spot, |family| family.orbit(&spot.place))
    }

    /// Whether the orbit of a spot breaks a rule of contact, but for the speed that an impact has not.
    pub fn is_virtual(&self, spot: &Spot, orbit: &PeriodicOrbit) -> Result<bool> {
        Ok(match self.condition {
            Condition::NoSpeed(_) if !self.is_touch => is_broken(&self.judged(spot)?),
            _ => is_broken(orbit),
        })
    }

    /// The orbit of a spot without an impact of no speed.
    pub fn judged(&self, spot: &Spot) -> Result<PeriodicOrbit> {
        self.along(0, spot, |family| {
            let rest = match self.condition {
                Condition::NoSpeed(instant) => family.without(&spot.place, instant)?,
                _ => None,
            };
            let (family, place) = rest
                .as_ref()
                .map_or((family, &spot.place), |(family, place)| (family, place));
            family.orbit(place)
        })
    }

    /// The equations at a spot.
    pub fn conditions(&self, spot: &Spot) -> Result<Conditions> {
        let first = self.along(0, spot, |family| family.equations(&spot.place))?;
        let over_second = Place {
            value: spot.second,
            ..spot.place.clone()
        };
        let second = self.along(1, spot, |family| {
            family.renewed(&over_second, first.clone())
        })?;
        let last = first.rows.ncols();
        let mut matrix = first.all_columns().insert_column(last + 1, 0.0);
        matrix.set_column(last + 1, &second.by_value.column);
        let mut found = Conditions {
            right: first.right.clone(),
            mismatch: first.mismatch,
            matrix,
            first,
            second,
        };
        let unit = self.along(0, spot, |family| self.condition.unit(family, &spot.place))?;
        if let Some(value) = self.value(spot, unit)? {
            let unknowns = last + 2;
            let mut row = DVector::zeros(unknowns);
            for k in 0..unknowns {
                let by = |part: f64| -> Result<f64> {
                    let mut step = DVector::zeros(unknowns);
                    step[k] = part;
                    let there = self.deviated(spot, &found, &step)?;
                    Ok(self.value(&there, unit)?.unwrap_or(f64::NAN))
                };
                // One-sided at the end of what a number may be.
                row[k] = match (by(STEP), by(-STEP)) {
                    (Err(Error::BadValue { .. }), below) => (value - below?) / STEP,
                    (above, Err(Error::BadValue { .. })) => (above? - value) / STEP,
                    (above, below) => (above? - below?) / (2.0 * STEP),
                };
            }
            let size = row.amax();
            let below = found.matrix.nrows();
            found.matrix = found.matrix.insert_row(below, 0.0);
            found.matrix.set_row(below, &(row / size).transpose());
            found.right = found.right.push(-value / size);
        }
        Ok(found)
    }

    /// A number that is zero where the condition of the curve holds, in a unit.
    fn value(&self, spot: &Spot, unit: f64) -> Result<Option<f64>> {
        let condition = self.condition;
        self.along(0, spot, |family| condition.value(family, &spot.place, unit))
    }

    /// A spot moved by a correction of all unknowns, to first order.
    pub fn moved(&self, spot: &Spot, at: &Conditions, by: &DVector<f64>) -> Result<Spot> {
        self.shifted(spot, at, by, true)
    }

    /// A spot moved by a deviation: what is not closed stays so.
    fn deviated(&self, spot: &Spot, at: &Conditions, by: &DVector<f64>) -> Result<Spot> {
        self.shifted(spot, at, by, false)
    }

    fn shifted(
        &self,
        spot: &Spot,
        at: &Conditions,
        by: &DVector<f64>,
        closes: bool,
    ) -> Result<Spot> {
        let unknowns = by.len() - 2;
        let way = Direction {
            loop_part: by.rows(0, unknowns).into_owned(),
            value_part: by[unknowns],
        };
        let place = self.along(0, spot, |family| {
            if closes {
                family.moved(&spot.place, &at.first, &way)
            } else {
                family.deviated(&spot.place, &at.first, &way)
            }
        })?;
        let there = Spot {
            second: spot.second,
            place,
        };
        let value = there.place.value;
        let over_second = Place {
            value: spot.second,
            ..there.place.clone()
        };
        let moved = self.along(1, &there, |family| {
            family.moved_by_value(&over_second, &at.second, by[unknowns + 1])
        })?;
        Ok(Spot {
            second: moved.value,
            place: Place { value, ..moved },
        })
    }
}

//! Scenes of two numbers, and loops in them.

use crate::branch::boundary::is_broken;
use crate::branch::curve::condition::Condition;
use crate::branch::equations::{ByValue, Equations};
use crate::branch::family::{Family, Recent, span_of, stretched};
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::model::Scene;
use crate::orbit::{Breach, PeriodicOrbit, Rule, Signature};
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;

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
    pub recent: RecentOfBoth,
}

/// The scenes made last over each number, while the other has a value.
#[derive(Default)]
pub(super) struct RecentOfBoth(RefCell<[(f64, Recent); 2]>);

impl RecentOfBoth {
    fn beside(&self, axis: usize, other: f64) -> Recent {
        let known = &mut self.0.borrow_mut()[axis];
        if known.0 != other {
            *known = (other, Recent::default());
        }
        known.1.clone()
    }
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
    pub first: Equations,
    second: ByValue,
    /// Of the condition, where that is a row beside those of the loop.
    gradient: Option<Gradient>,
}

/// How the number that is zero on a curve changes with all unknowns, in parts of the largest of these; the unit in which it was taken.
#[derive(Clone)]
struct Gradient {
    row: DVector<f64>,
    size: f64,
    unit: f64,
}

/// How a function changes from zero, where its value is known.
type Rate<'a> = &'a dyn Fn(&dyn Fn(f64) -> Result<f64>, f64) -> Result<f64>;

/// By a step ahead, back at the end of what a number may be.
fn ahead(of: &dyn Fn(f64) -> Result<f64>, value: f64) -> Result<f64> {
    match of(STEP) {
        Err(Error::BadValue { .. }) => Ok((value - of(-STEP)?) / STEP),
        above => Ok((above? - value) / STEP),
    }
}

/// By a step both ways, one-sided at the end of what a number may be.
fn central(of: &dyn Fn(f64) -> Result<f64>, value: f64) -> Result<f64> {
    Ok(match (of(STEP), of(-STEP)) {
        (Err(Error::BadValue { .. }), below) => (value - below?) / STEP,
        (above, Err(Error::BadValue { .. })) => (above? - value) / STEP,
        (above, below) => (above? - below?) / (2.0 * STEP),
    })
}

impl Conditions {
    /// Those of the loop.
    fn of_loop(first: Equations, second: ByValue) -> Self {
        let last = first.rows.ncols();
        let mut matrix = first.all_columns().insert_column(last + 1, 0.0);
        matrix.set_column(last + 1, &second.column);
        Self {
            matrix,
            right: first.right.clone(),
            mismatch: first.mismatch,
            first,
            second,
            gradient: None,
        }
    }

    /// The same and what holds on the curve, whose number has a value.
    fn with(mut self, value: f64, gradient: Gradient) -> Self {
        let below = self.matrix.nrows();
        self.matrix = self.matrix.insert_row(below, 0.0);
        self.matrix.set_row(below, &gradient.row.transpose());
        self.right = self.right.push(-value / gradient.size);
        self.gradient = Some(gradient);
        self
    }
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
            recent: self.recent.beside(axis, [second, first][axis]),
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
            // That it is reached is what the curve is of.
            Condition::Reached { stop, .. } => {
                let is_own =
                    |own: Breach| own.stop == stop && matches!(own.rule, Rule::Reached { .. });
                is_broken(orbit) && !orbit.breach().is_some_and(is_own)
            }
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

    /// The equations at a spot, of which Newton's method begins: how the condition changes is one-sided.
    pub fn conditions(&self, spot: &Spot) -> Result<Conditions> {
        let nothing = &ByValue::default();
        let bare = self.along(0, spot, |family| {
            family.equations_nearby(&spot.place, nothing)
        })?;
        self.with_changes(spot, bare, &ahead)
    }

    /// The same with what changes there, by central differences.
    pub fn renewed(&self, spot: &Spot, conditions: Conditions) -> Result<Conditions> {
        self.with_changes(spot, conditions.first, &central)
    }

    fn with_changes(&self, spot: &Spot, bare: Equations, rate: Rate<'_>) -> Result<Conditions> {
        let first = self.along(0, spot, |family| family.renewed(&spot.place, bare))?;
        let over_second = Place {
            value: spot.second,
            ..spot.place.clone()
        };
        let second = self.along(1, spot, |family| {
            family.renewed(&over_second, first.clone())
        })?;
        let loops = Conditions::of_loop(first, second.by_value);
        let Some((value, unit)) = self.value(spot, Some(&loops.first), None)? else {
            return Ok(loops);
        };
        let unknowns = loops.matrix.ncols();
        let mut row = DVector::zeros(unknowns);
        for k in 0..unknowns {
            let by = |part: f64| -> Result<f64> {
                let mut step = DVector::zeros(unknowns);
                step[k] = part;
                let there = self.value(&self.deviated(spot, &loops, &step)?, None, Some(unit))?;
                Ok(there.map_or(f64::NAN, |(value, _)| value))
            };
            row[k] = rate(&by, value)?;
        }
        let size = row.amax();
        row /= size;
        Ok(loops.with(value, Gradient { row, size, unit }))
    }

    /// The same with what changes with both numbers, and with the condition, as it is at a spot nearby.
    pub fn conditions_nearby(&self, spot: &Spot, near: &Conditions) -> Result<Conditions> {
        let first = self.along(0, spot, |family| {
            family.equations_nearby(&spot.place, &near.first.by_value)
        })?;
        let loops = Conditions::of_loop(first, near.second.clone());
        let Some(gradient) = near.gradient.clone() else {
            return Ok(loops);
        };
        let value = self.value(spot, Some(&loops.first), Some(gradient.unit))?;
        Ok(loops.with(value.map_or(f64::NAN, |(value, _)| value), gradient))
    }

    /// Conditions as those of a spot next to theirs.
    pub fn conditions_at(&self, spot: &Spot, conditions: Conditions) -> Result<Conditions> {
        let Conditions { first, .. } = conditions;
        let first = self.along(0, spot, |family| family.equations_at(&spot.place, first))?;
        Ok(Conditions {
            first,
            ..conditions
        })
    }

    /// The number of the condition at a spot, in a unit or its own, and that.
    fn value(
        &self,
        spot: &Spot,
        equations: Option<&Equations>,
        unit: Option<f64>,
    ) -> Result<Option<(f64, f64)>> {
        let (condition, at) = (self.condition, (&spot.place, equations));
        self.along(0, spot, |family| condition.value(family, at, unit))
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
        if by[unknowns + 1] == 0.0 {
            return Ok(there);
        }
        let value = there.place.value;
        let over_second = Place {
            value: spot.second,
            ..there.place.clone()
        };
        let moved = self.along(1, &there, |family| {
            family.moved_by_value(&over_second, (&at.first, &at.second), by[unknowns + 1])
        })?;
        Ok(Spot {
            second: moved.value,
            place: Place { value, ..moved },
        })
    }
}

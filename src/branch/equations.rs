//! The equations of a loop linearised at a place, with the column of the parameter by differences (theory 19).

use crate::branch::family::{Family, check_same, stretched};
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{
    Linearised, PeriodicOrbit, ScaledUnits, ShootingState, Signature, with_shooting,
};
use nalgebra::{DMatrix, DVector};

/// The equations at a place: `rows xi + column pi = right`, pi the parameter in parts of its range.
#[derive(Clone)]
pub(super) struct Equations {
    pub rows: DMatrix<f64>,
    pub by_value: ByValue,
    pub right: DVector<f64>,
    /// How far the loop is from closing.
    pub mismatch: f64,
    scene: Scene,
    linear: Linearised,
}

/// What changes with pi.
#[derive(Clone)]
pub(super) struct ByValue {
    /// The equations.
    pub column: DVector<f64>,
    /// The states and the starts of the flights.
    flights: ShootingState,
}

/// The units of a branch: the sizes of its first loop.
pub(super) fn units_of(
    scene: &Scene,
    signature: &Signature,
    state: &ShootingState,
) -> Result<ScaledUnits> {
    with_shooting(scene, signature, |shooting, _| shooting.units(state))
}

impl Equations {
    fn new((scene, linear, mismatch): (Scene, Linearised, f64), by_value: ByValue) -> Self {
        Self {
            rows: linear.rows.clone(),
            right: linear.right.clone(),
            by_value,
            mismatch,
            scene,
            linear,
        }
    }
}

impl Family<'_> {
    /// The equations at a place.
    pub fn equations(&self, place: &Place) -> Result<Equations> {
        let (scene, linear, mismatch) = self.linear(place)?;
        let by_value = self.by_value(place, &scene, &linear)?;
        Ok(Equations::new((scene, linear, mismatch), by_value))
    }

    /// The same with what changes with the parameter as it is at a place nearby: corrections by them are a little longer on their way.
    pub fn equations_nearby(&self, place: &Place, by_value: &ByValue) -> Result<Equations> {
        Ok(Equations::new(self.linear(place)?, by_value.clone()))
    }

    /// The same with what changes with the parameter there.
    pub fn renewed(&self, place: &Place, equations: Equations) -> Result<Equations> {
        let by_value = self.by_value(place, &equations.scene, &equations.linear)?;
        Ok(Equations {
            by_value,
            ..equations
        })
    }

    /// The equations of the loop alone, and how far it is from closing.
    fn linear(&self, place: &Place) -> Result<(Scene, Linearised, f64)> {
        let scene = self.scene(place.value)?;
        let (state, units) = (&place.state, &self.units_in(&scene));
        let (linear, mismatch) = with_shooting(&scene, &self.signature, |shooting, _| {
            let linear = shooting.linearised(state, units)?;
            Ok((linear, shooting.mismatch(state, units)?))
        })?;
        Ok((scene, linear, mismatch))
    }

    /// A number that changes its sign where a multiplier passes through another number, and nowhere else: a determinant, in parts of the
    /// product of its columns' lengths.
    pub fn multiplier_test(&self, place: &Place, multiplier: f64) -> Result<f64> {
        let scene = self.scene(place.value)?;
        let (state, units) = (&place.state, &self.units_in(&scene));
        let matrix = with_shooting(&scene, &self.signature, |shooting, _| {
            shooting.variational(state, units, multiplier)
        })?;
        let lengths = matrix.column_iter().map(|column| column.norm().ln());
        let lengths: f64 = lengths.sum();
        let lu = matrix.lu();
        let diagonal = lu.u().diagonal();
        let log: f64 = diagonal.iter().map(|x| x.abs().ln()).sum();
        let is_odd = diagonal.iter().filter(|x| **x < 0.0).count() % 2 == 1;
        let sign = lu.p().determinant::<f64>() * if is_odd { -1.0 } else { 1.0 };
        Ok(sign * (log - lengths).exp().max(f64::MIN_POSITIVE))
    }

    /// The orbit at a place where the loop is closed.
    pub fn orbit(&self, place: &Place) -> Result<PeriodicOrbit> {
        let scene = self.scene(place.value)?;
        let (state, units) = (&place.state, &self.units_in(&scene));
        with_shooting(&scene, &self.signature, |shooting, orbit| {
            orbit(state, &shooting.flight_ends(state, units)?)
        })
    }

    /// How what the loop lacks, and with it the states of its flights, changes with the parameter, in parts of the range: central
    /// differences, instants held at their phases; one-sided at the end of what the parameter may be.
    fn by_value(&self, place: &Place, scene: &Scene, here: &Linearised) -> Result<ByValue> {
        let lacking = |value: f64| -> Result<Linearised> {
            let there = self.scene(value)?;
            check_same(scene, &there, value)?;
            let state = &stretched(&place.state, scene, &there);
            let units = &self.units_in(&there);
            with_shooting(&there, &self.signature, |shooting, _| {
                shooting.lacking(state, units)
            })
        };
        let step = self.difference(place.value);
        let (above, below) = (place.value + step, place.value - step);
        let (upper, lower) = (lacking(above), lacking(below));
        // Corrections without unknowns.
        let open = |linear: &Linearised| {
            let none = DVector::zeros(linear.rows.ncols());
            (linear.right.clone(), linear.corrections(&none))
        };
        let is_refused = |found: &Result<Linearised>| matches!(found, Err(Error::BadValue { .. }));
        let ((high, one), (low, other)) = match (upper, lower) {
            (Ok(upper), lower) if is_refused(&lower) => {
                ((above, open(&upper)), (place.value, open(here)))
            }
            (upper, Ok(lower)) if is_refused(&upper) => {
                ((place.value, open(here)), (below, open(&lower)))
            }
            (upper, lower) => ((above, open(&upper?)), (below, open(&lower?))),
        };
        let factor = self.span() / (high - low);
        let rate = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| (a - b) * factor).collect()
        };
        let ((right, one), (left, other)) = (one, other);
        let states = one.states.iter().zip(&other.states);
        Ok(ByValue {
            column: (right - left) * -factor,
            flights: ShootingState {
                times: rate(&one.times, &other.times),
                starts: rate(&one.starts, &other.starts),
                states: states.map(|(a, b)| (a - b) * factor).collect(),
            },
        })
    }

    /// A place moved by a direction, to first order.
    pub fn moved(&self, place: &Place, equations: &Equations, by: &Direction) -> Result<Place> {
        let value = place.value + by.value_part * self.span();
        let (scene, there) = (&equations.scene, self.scene(value)?);
        check_same(scene, &there, value)?;
        let corrections = equations.linear.corrections(&by.loop_part);
        let by_value = &equations.by_value.flights;
        let sum = |x: &[f64], d: &[f64], p: &[f64]| -> Vec<f64> {
            let each = x.iter().zip(d).zip(p);
            each.map(|((x, d), p)| x + d + by.value_part * p).collect()
        };
        let start = &place.state;
        let states = start.states.iter().zip(&corrections.states);
        let moved = ShootingState {
            times: sum(&start.times, &corrections.times, &by_value.times),
            starts: sum(&start.starts, &corrections.starts, &by_value.starts),
            states: states
                .zip(&by_value.states)
                .map(|((x, d), p)| x + d + p * by.value_part)
                .collect(),
        };
        Ok(Place {
            value,
            state: stretched(&moved, scene, &there),
            clock: self.units_in(&there).time,
        })
    }
}

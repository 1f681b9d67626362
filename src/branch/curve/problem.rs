//! The continuation problem of a curve: scenes over two numbers, and the equations of their loops with the condition of the curve (theory
//! 20).

use crate::branch::boundary::is_broken;
use crate::branch::curve::condition::Condition;
use crate::branch::equations::{Equations, ParameterDerivative};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::{BranchProblem, Formulation, RecentScenes, span_of, stretched};
use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::model::Scene;
use crate::orbit::{Breach, PeriodicOrbit, Rule, Signature};
use crate::tolerance::CONDITION_STEP;
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;

/// The continuation problem of a curve: `G(Z, p1, p2) = 0` and a condition, for loops Z of one signature.
pub(super) struct CurveProblem<'a> {
    /// The scene of two numbers.
    pub make: &'a dyn Fn(f64, f64) -> Result<Scene>,
    /// The ranges of both numbers, in their units.
    pub between: [(f64, f64); 2],
    pub signature: Signature,
    pub phase: f64,
    pub is_free: bool,
    pub units: ScaledUnits,
    pub condition: Condition,
    /// Whether the curve is one of grazes: the impact of no speed is an unknown of the loop and no impact of the orbit.
    pub is_touch: bool,
    pub recent: RecentScenesOfBoth,
}

/// Caches of the scenes made last over each number, while the other keeps its value.
#[derive(Default)]
pub(super) struct RecentScenesOfBoth(RefCell<[(f64, RecentScenes); 2]>);

impl RecentScenesOfBoth {
    fn beside(&self, axis: usize, other: f64) -> RecentScenes {
        let known = &mut self.0.borrow_mut()[axis];
        if known.0 != other {
            *known = (other, RecentScenes::default());
        }
        known.1.clone()
    }
}

/// A loop and the two numbers that it belongs to.
#[derive(Debug, Clone)]
pub(super) struct TwoParameterLoop {
    /// The loop, at the first number.
    pub place: ParametricLoop,
    /// The second number, in its unit.
    pub second: f64,
}

/// The defining system of a curve, linearised: the equations of a loop and the condition, `matrix y = right`, y the correction of the
/// loop's scaled unknowns and of both numbers in parts of their ranges.
#[derive(Clone)]
pub(super) struct DefiningSystem {
    /// The Jacobian, shape `(n_equations, n_unknowns + 2)`, \[-\].
    pub matrix: DMatrix<f64>,
    /// Minus the residual, shape `(n_equations,)`, \[-\].
    pub right: DVector<f64>,
    /// How far the loop is from closing, in parts of the motion's size \[-\].
    pub mismatch: f64,
    pub first: Equations,
    pub second: ParameterDerivative,
    /// The gradient of the condition, where that is a row beside those of the loop.
    pub gradient: Option<ConditionGradient>,
}

/// The gradient of the condition by all unknowns, divided by its largest entry `size`; and the unit in which the condition was taken.
#[derive(Clone)]
pub(super) struct ConditionGradient {
    row: DVector<f64>,
    size: f64,
    pub unit: f64,
}

/// A rule of differences: the derivative at zero of a function whose value there is known.
pub(super) type DifferenceRule<'a> = &'a dyn Fn(&dyn Fn(f64) -> Result<f64>, f64) -> Result<f64>;

/// The forward difference, the backward one where the scene refuses the value ahead.
pub(super) fn ahead(of: &dyn Fn(f64) -> Result<f64>, value: f64) -> Result<f64> {
    match of(CONDITION_STEP) {
        Err(Error::BadValue { .. }) => Ok((value - of(-CONDITION_STEP)?) / CONDITION_STEP),
        above => Ok((above? - value) / CONDITION_STEP),
    }
}

/// The central difference, a one-sided one where the scene refuses a value.
pub(super) fn central(of: &dyn Fn(f64) -> Result<f64>, value: f64) -> Result<f64> {
    Ok(match (of(CONDITION_STEP), of(-CONDITION_STEP)) {
        (Err(Error::BadValue { .. }), below) => (value - below?) / CONDITION_STEP,
        (above, Err(Error::BadValue { .. })) => (above? - value) / CONDITION_STEP,
        (above, below) => (above? - below?) / (2.0 * CONDITION_STEP),
    })
}

impl DefiningSystem {
    /// The system of the loop alone.
    pub fn of_loop(first: Equations, second: ParameterDerivative) -> Self {
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

    /// Adds the row of the condition, which has a value.
    pub fn with(mut self, value: f64, gradient: ConditionGradient) -> Self {
        let below = self.matrix.nrows();
        self.matrix = self.matrix.insert_row(below, 0.0);
        self.matrix.set_row(below, &gradient.row.transpose());
        self.right = self.right.push(-value / gradient.size);
        self.gradient = Some(gradient);
        self
    }
}

impl CurveProblem<'_> {
    /// Gives the problem over one number (axis 0 or 1), the other held at its value, to a function, and returns what that makes of it.
    pub fn along<T>(
        &self,
        axis: usize,
        iterate: &TwoParameterLoop,
        work: impl FnOnce(&BranchProblem<'_>) -> Result<T>,
    ) -> Result<T> {
        let (first, second) = (iterate.place.value, iterate.second);
        let over_first = |value: f64| (self.make)(value, second);
        let over_second = |value: f64| (self.make)(first, value);
        let make: &dyn Fn(f64) -> Result<Scene> =
            if axis == 0 { &over_first } else { &over_second };
        work(&BranchProblem {
            make,
            range: self.between[axis],
            signature: self.signature.clone(),
            phase: self.phase,
            is_free: self.is_free,
            units: self.units,
            formulation: Formulation::Shooting,
            recent: self.recent.beside(axis, [second, first][axis]),
        })
    }

    /// A loop at another value of one of the numbers, its instants at the same phases.
    pub fn at_value(
        &self,
        iterate: &TwoParameterLoop,
        axis: usize,
        value: f64,
    ) -> Result<TwoParameterLoop> {
        let mut values = [iterate.place.value, iterate.second];
        let from = (self.make)(values[0], values[1])?;
        values[axis] = value;
        let to = (self.make)(values[0], values[1])?;
        let state = stretched(&iterate.place.state, &from, &to);
        let there = TwoParameterLoop {
            place: iterate.place.clone(),
            second: values[1],
        };
        Ok(TwoParameterLoop {
            place: self.along(0, &there, |problem| problem.place(&to, values[0], state))?,
            second: values[1],
        })
    }

    /// The unit of a number in scaled unknowns: the width of its range.
    pub fn span(&self, axis: usize) -> f64 {
        span_of(self.between[axis])
    }

    /// The orbit of a closed loop.
    pub fn orbit(&self, iterate: &TwoParameterLoop) -> Result<PeriodicOrbit> {
        if self.is_touch {
            return self.judged(iterate);
        }
        self.along(0, iterate, |problem| problem.orbit(&iterate.place))
    }

    /// Whether the orbit of a loop breaks a rule of contact, other than by the impact of no speed that the curve is of.
    pub fn is_virtual(&self, iterate: &TwoParameterLoop, orbit: &PeriodicOrbit) -> Result<bool> {
        Ok(match self.condition {
            Condition::NoSpeed(_) if !self.is_touch => is_broken(&self.judged(iterate)?),
            // The curve is one of orbits that reach this stop.
            Condition::Reached { stop, .. } => {
                let is_own =
                    |own: Breach| own.stop == stop && matches!(own.rule, Rule::Reached { .. });
                is_broken(orbit) && !orbit.breach().is_some_and(is_own)
            }
            _ => is_broken(orbit),
        })
    }

    /// The orbit of a loop without its impact of no speed.
    pub fn judged(&self, iterate: &TwoParameterLoop) -> Result<PeriodicOrbit> {
        self.along(0, iterate, |problem| {
            let rest = match self.condition {
                Condition::NoSpeed(instant) => problem.without(&iterate.place, instant)?,
                _ => None,
            };
            let (problem, place) = rest
                .as_ref()
                .map_or((problem, &iterate.place), |(problem, place)| {
                    (problem, place)
                });
            problem.orbit(place)
        })
    }

    /// The system with its derivatives taken at the loop itself, those of the condition by a rule of differences.
    pub fn with_changes(
        &self,
        iterate: &TwoParameterLoop,
        bare: Equations,
        rate: DifferenceRule<'_>,
    ) -> Result<DefiningSystem> {
        let first = self.along(0, iterate, |problem| problem.renewed(&iterate.place, bare))?;
        let over_second = ParametricLoop {
            value: iterate.second,
            ..iterate.place.clone()
        };
        let second = self.along(1, iterate, |problem| {
            problem.renewed(&over_second, first.clone())
        })?;
        let loops = DefiningSystem::of_loop(first, second.by_value);
        let Some((value, unit)) = self.condition_value(iterate, Some(&loops.first), None)? else {
            return Ok(loops);
        };
        let unknowns = loops.matrix.ncols();
        let mut row = DVector::zeros(unknowns);
        for k in 0..unknowns {
            let by = |part: f64| -> Result<f64> {
                let mut step = DVector::zeros(unknowns);
                step[k] = part;
                let there = self.condition_value(
                    &self.shifted(iterate, &loops, &step, false)?,
                    None,
                    Some(unit),
                )?;
                Ok(there.map_or(f64::NAN, |(value, _)| value))
            };
            row[k] = rate(&by, value)?;
        }
        let size = row.amax();
        row /= size;
        Ok(loops.with(value, ConditionGradient { row, size, unit }))
    }

    /// The value of the condition at a loop, and its unit: the given one, else its own.
    pub fn condition_value(
        &self,
        iterate: &TwoParameterLoop,
        equations: Option<&Equations>,
        unit: Option<f64>,
    ) -> Result<Option<(f64, f64)>> {
        let (condition, at) = (self.condition, (&iterate.place, equations));
        self.along(0, iterate, |problem| condition.value(problem, at, unit))
    }

    /// A loop moved along a direction of all unknowns, to first order: its flights are joined, or those that are not stay so.
    pub fn shifted(
        &self,
        iterate: &TwoParameterLoop,
        at: &DefiningSystem,
        by: &DVector<f64>,
        closes: bool,
    ) -> Result<TwoParameterLoop> {
        let unknowns = by.len() - 2;
        let loop_direction = BranchDirection {
            loop_part: by.rows(0, unknowns).into_owned(),
            value_part: by[unknowns],
        };
        let place = self.along(0, iterate, |problem| {
            if closes {
                problem.moved(&iterate.place, &at.first, &loop_direction)
            } else {
                problem.deviated((&iterate.place, &at.first, &loop_direction))
            }
        })?;
        let there = TwoParameterLoop {
            second: iterate.second,
            place,
        };
        if by[unknowns + 1] == 0.0 {
            return Ok(there);
        }
        let value = there.place.value;
        let over_second = ParametricLoop {
            value: iterate.second,
            ..there.place.clone()
        };
        let moved = self.along(1, &there, |problem| {
            problem.moved_by_value(&over_second, (&at.first, &at.second), by[unknowns + 1])
        })?;
        Ok(TwoParameterLoop {
            second: moved.value,
            place: ParametricLoop { value, ..moved },
        })
    }
}

//! A curve of special points as a curve of zeros (theory 20).

use crate::branch::curve::direction::CurveDirection;
use crate::branch::curve::problem::{
    CurveProblem, DefiningSystem, TwoParameterLoop, ahead, central,
};
use crate::branch::equations::ParameterDerivative;
use crate::continuation::{Corrected, Linearisation, ZeroProblem};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// A point of a curve as the corrector leaves it.
pub(super) type CorrectedCurvePoint = Corrected<TwoParameterLoop, DefiningSystem, CurveDirection>;

impl Linearisation for DefiningSystem {
    fn matrix(&self) -> DMatrix<f64> {
        self.matrix.clone()
    }

    fn right(&self) -> &DVector<f64> {
        &self.right
    }

    fn mismatch(&self) -> f64 {
        self.mismatch
    }
}

impl ZeroProblem for CurveProblem<'_> {
    type Iterate = TwoParameterLoop;
    type Equations = DefiningSystem;
    type Direction = CurveDirection;

    /// Both numbers of the plane. `[exact]`
    const N_NUMBERS: usize = 2;
    /// More than on a branch, as the row of the condition stays that of the first iterate. `[work]`
    const MOST_CORRECTIONS: usize = 10;
    const KEPT_CORRECTION: Option<f64> = None;

    fn value(&self, iterate: &TwoParameterLoop) -> f64 {
        iterate.place.value
    }

    fn coinciding(&self, iterate: &TwoParameterLoop) -> Option<usize> {
        iterate.place.coinciding_instant()
    }

    /// Next to another iterate with its derivatives by both numbers and of the condition; else with forward differences of this.
    fn linearise(
        &self,
        iterate: &TwoParameterLoop,
        near: Option<&DefiningSystem>,
    ) -> Result<DefiningSystem> {
        let nothing = &ParameterDerivative::default();
        let by_value = near.map_or(nothing, |near| &near.first.by_value);
        let first = self.along(0, iterate, |problem| {
            problem.equations_nearby(&iterate.place, by_value)
        })?;
        let Some(near) = near else {
            return self.with_changes(iterate, first, &ahead);
        };
        let loops = DefiningSystem::of_loop(first, near.second.clone());
        let Some(gradient) = near.gradient.clone() else {
            return Ok(loops);
        };
        let value = self.condition_value(iterate, Some(&loops.first), Some(gradient.unit))?;
        Ok(loops.with(value.map_or(f64::NAN, |(value, _)| value), gradient))
    }

    fn retract(
        &self,
        iterate: &TwoParameterLoop,
        conditions: &DefiningSystem,
        by: &CurveDirection,
    ) -> Result<TwoParameterLoop> {
        self.shifted(iterate, conditions, &by.0, true)
    }

    /// With central differences of the condition.
    fn settle(
        &self,
        mut iterate: TwoParameterLoop,
        conditions: DefiningSystem,
        by: Option<&CurveDirection>,
    ) -> Result<(TwoParameterLoop, DefiningSystem)> {
        let mut conditions = self.with_changes(&iterate, conditions.first, &central)?;
        if let Some(by) = by {
            iterate = self.retract(&iterate, &conditions, by)?;
        }
        conditions.first = self.along(0, &iterate, |problem| {
            problem.equations_at(&iterate.place, conditions.first)
        })?;
        Ok((iterate, conditions))
    }

    fn pin(
        &self,
        iterate: TwoParameterLoop,
        number: usize,
        value: f64,
    ) -> Result<TwoParameterLoop> {
        self.at_value(&iterate, number, value)
    }
}

//! Units in which the periodic conditions have entries of order one, and their solution in these units.

use crate::error::Result;
use crate::linalg::rank::{self, SolutionSet};
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::tolerance::CONDITIONS_RANK;
use nalgebra::{DMatrix, DVector};

/// Units in which the conditions have entries of order one, so that neither a unit of measurement nor the rounding of a
/// vanishing entry decides the rank.
pub(in crate::orbit) struct Units {
    /// Factors from the scaled unknowns, which are velocities, to the unknowns, shape (unknowns,): impulses [kg], resonant modal states,
    /// cosines and sines [s/m].
    pub columns: DVector<f64>,
    /// Factors on the equations, which make velocities of them, shape (equations,): restitution [-], repetition in inverse modal units,
    /// contacts [1/s].
    pub rows: DVector<f64>,
}

impl Units {
    /// Solves in these units; the residual is relative to the size of the right-hand side, `floor` at least.
    pub fn solve(
        &self,
        matrix: &DMatrix<f64>,
        rhs: &DVector<f64>,
        floor: f64,
    ) -> Result<SolutionSet> {
        let mut a = matrix.clone();
        for (i, mut row) in a.row_iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x *= self.rows[i] * self.columns[j];
            }
        }
        let b = rhs.component_mul(&self.rows);
        let mut set = rank::solve(&a, &b, CONDITIONS_RANK)?;
        let scale = set.particular.norm() + b.norm().max(floor);
        set.residual = if scale > 0.0 {
            set.residual / scale
        } else {
            0.0
        };
        set.particular
            .component_mul_assign(&self.columns.rows(0, a.ncols()));
        for (j, mut row) in set.null_space.row_iter_mut().enumerate() {
            row *= self.columns[j];
        }
        Ok(set)
    }
}

impl PeriodicConditions<'_> {
    /// Velocities are measured by the normal velocity of a unit impulse, positions by that over the forcing frequency,
    /// forcing by the largest response to it; `contacts` rows follow those of `repeat_rows`, `extra` columns the phase.
    pub(in crate::orbit) fn units(&self, matrix: &DMatrix<f64>, contacts: usize) -> Units {
        let (k, inner) = (self.n_impulses(), self.n_inner());
        let or_one = |x: f64| if x > 0.0 && x.is_finite() { x } else { 1.0 };
        let w = or_one(self.scene.frequency);
        let push = or_one(self.delassus().amax());
        let jumps = self.stops.iter().flat_map(|&i| {
            self.resonant
                .iter()
                .flat_map(move |&j| self.scene.jumps[i][j])
        });
        let modal = or_one(jumps.fold(0.0f64, |m, x| m.max(x.abs()))) / push;
        let is_position = |i: usize| (i - k).is_multiple_of(2);
        let mut columns = DVector::from_fn(matrix.ncols(), |i, _| match i {
            i if i < k => 1.0 / push,
            i if i < inner && is_position(i) => modal / w,
            i if i < inner => modal,
            _ => 1.0,
        });
        let rows = DVector::from_fn(inner + contacts, |i, _| match i {
            i if i < k => 1.0,
            i if i < inner && is_position(i) => w / modal,
            i if i < inner => 1.0 / modal,
            _ => w,
        });
        let phases = self.n_phases();
        for (from, count) in [(inner, phases), (inner + phases, 1)] {
            if from + count <= matrix.ncols() {
                let block = matrix.columns(from, count);
                let largest = (0..block.nrows())
                    .map(|i| rows[i] * block.row(i).amax())
                    .fold(0.0, f64::max);
                columns.rows_mut(from, count).fill(1.0 / or_one(largest));
            }
        }
        Units { columns, rows }
    }
}

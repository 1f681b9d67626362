//! Impulses and states at an instant to their own digits. Where they are little beside the steady motion (a forcing much
//! faster than the structure), what a decomposition of all conditions together leaves of them is rounding of the large.

use crate::error::Result;
use crate::flow::{ModalScene, along};
use crate::impact::impulse_matrix;
use crate::linalg::rank;
use crate::modal::Pair;
use crate::orbit::one_instant::periodic_conditions::{PeriodicConditions, Rows};
use crate::tolerance::{CONDITIONS_RANK, CONSISTENT};
use nalgebra::{DMatrix, DVector};

impl PeriodicConditions<'_> {
    /// Takes the unknowns of a solution for given clearances anew for its phase, by least squares on the rows of these with each
    /// in units of its own rounding: those in which the phase matters little decide. Where that leaves one of them open, or the
    /// rows contradict each other in these units (the phase itself is not known well enough for the smallest of them), X stays.
    pub fn refine(&self, (mut matrix, mut rhs): Rows, x: &mut DVector<f64>) -> Result<()> {
        let (inner, phases) = (self.n_inner(), self.n_phases());
        let mut sizes = x.abs();
        // Of cos and sin the smaller, too, has the rounding of the larger.
        sizes.rows_mut(inner, phases).fill(1.0);
        for (mut row, b) in matrix.row_iter_mut().zip(rhs.iter_mut()) {
            let terms = row.iter().zip(sizes.iter()).map(|(a, x)| a.abs() * x);
            let size = b.abs() + terms.sum::<f64>();
            if size > 0.0 {
                row /= size;
                *b /= size;
            }
        }
        let left = rhs - matrix.columns(inner, phases) * x.rows(inner, phases);
        let scaled = DMatrix::from_fn(matrix.nrows(), inner, |i, j| matrix[(i, j)] * x[j]);
        // Conditions of rounding alone have none to be measured by.
        if !scaled.iter().chain(left.iter()).all(|x| x.is_finite()) {
            return Ok(());
        }
        let set = rank::solve(&scaled, &left, CONDITIONS_RANK * scaled.amax())?;
        if set.null_space.ncols() == 0 && set.residual <= CONSISTENT {
            for (x, factor) in x.iter_mut().zip(set.particular.iter()) {
                *x *= factor;
            }
        }
        Ok(())
    }
}

/// Takes the rounding off the normal speeds of a state after the impacts at one instant.
///
/// Relative to the stops, which may recede, they are `-e/(1 + e)` times what the impulses change, `N^T B p`; where that is little beside
/// the speed of the motion, their sum over the modes has lost its digits, which the impulses still have.
pub(crate) fn settle_speeds(
    scene: &ModalScene,
    (stops, receding): (&[usize], &[f64]),
    impulses: &[f64],
    after: &mut [Pair],
) -> Result<()> {
    let g = &scene.geometry;
    let (normals, reactions) = g.columns(stops);
    let changes = normals.tr_mul(&(reactions * DVector::from_column_slice(impulses)));
    // An impulse to each approach (1 + e) times too small takes away that much speed and no more.
    let left = DVector::from_fn(stops.len(), |i, _| {
        let law = g.law(stops[i]);
        let relative = along(&scene.velocity_rows[stops[i]], after) - receding[i];
        law.approach_by(relative + law.departure_by(changes[i]))
    });
    let pushes = impulse_matrix(g, stops)? * left;
    for (&stop, &push) in stops.iter().zip(pushes.iter()) {
        for (z, jump) in after.iter_mut().zip(&scene.jumps[stop]) {
            *z = [z[0] - jump[0] * push, z[1] - jump[1] * push];
        }
    }
    Ok(())
}

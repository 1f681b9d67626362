//! Linear systems of unknown rank, by the singular value decomposition: a particular solution, the null space, and
//! how far the right-hand side is from solvable.

use crate::error::Result;
use crate::linalg::singular::{Singular, overflow};
use crate::tolerance::DEPENDENT;
use nalgebra::{DMatrix, DVector};

/// All solutions of `A x = b`: `particular + null_space c`.
#[derive(Debug, Clone)]
pub(crate) struct SolutionSet {
    /// The solution of least norm (in the least-squares sense where there is none), shape `(columns,)`, [-], in units of the right-hand
    /// side over those of A.
    pub particular: DVector<f64>,
    /// Orthonormal columns that `A` maps to (numerically) zero, shape `(columns, k)`, [-].
    pub null_space: DMatrix<f64>,
    /// `|A x - b|` of the particular solution.
    pub residual: f64,
}

/// Solves `A x = b`; singular values up to `tolerance` count as zero, so A is to be scaled to entries of order one.
pub(crate) fn solve(a: &DMatrix<f64>, b: &DVector<f64>, tolerance: f64) -> Result<SolutionSet> {
    if !b.iter().all(|x| x.is_finite()) {
        return Err(overflow());
    }
    let columns = a.ncols();
    let singular = Singular::new(a)?;
    let mut particular = DVector::zeros(columns);
    let mut null = Vec::new();
    for k in 0..columns {
        let right = singular.right(k);
        if singular.value(k) <= tolerance {
            null.push(right);
        } else {
            particular += right * singular.part(k, b);
        }
    }
    let null_space = if null.is_empty() {
        DMatrix::zeros(columns, 0)
    } else {
        DMatrix::from_columns(&null)
    };
    let residual = (a * &particular - b).norm();
    Ok(SolutionSet {
        particular,
        null_space,
        residual,
    })
}

/// Some orthonormal vectors that A makes shortest, the shortest first.
pub(crate) fn weakest(a: &DMatrix<f64>, count: usize) -> Result<DMatrix<f64>> {
    let singular = Singular::new(a)?;
    let mut order: Vec<usize> = (0..a.ncols()).collect();
    order.sort_by(|&i, &j| singular.value(i).total_cmp(&singular.value(j)));
    let vectors: Vec<_> = order[..count].iter().map(|&k| singular.right(k)).collect();
    Ok(DMatrix::from_columns(&vectors))
}

/// The pseudo-inverse of A; singular values up to `tolerance` count as zero.
pub(crate) fn pseudo_inverse(a: &DMatrix<f64>, tolerance: f64) -> Result<DMatrix<f64>> {
    let singular = Singular::new(a)?;
    let (rows, columns) = a.shape();
    let mut inverse = DMatrix::zeros(columns, rows);
    for k in (0..columns).filter(|&k| singular.value(k) > tolerance) {
        inverse += singular.right(k) * singular.left_over_value(k).transpose();
    }
    Ok(inverse)
}

/// Orthonormal columns across those of a matrix that is not zero, shape `(rows, rows - rank)`, \[-\].
pub(crate) fn across(columns: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let none = DVector::zeros(columns.ncols());
    Ok(solve(&columns.transpose(), &none, DEPENDENT * columns.amax())?.null_space)
}

/// Whether a vector depends on the columns of a matrix that is not zero.
pub(crate) fn depends_on(vector: &DVector<f64>, columns: &DMatrix<f64>) -> Result<bool> {
    let across = across(columns)?;
    Ok(across.tr_mul(vector).norm() <= DEPENDENT * vector.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_system_has_its_whole_null_space() {
        let a = DMatrix::from_row_slice(2, 4, &[1.0, 2.0, 0.0, 1.0, 2.0, 4.0, 0.0, 2.0]);
        let set = solve(&a, &DVector::from_vec(vec![3.0, 6.0]), 1e-10).expect("converges");
        assert_eq!(set.null_space.ncols(), 3);
        assert!((&a * &set.null_space).amax() < 1e-14);
        assert!(set.residual < 1e-14);
        assert!(
            solve(&a, &DVector::from_vec(vec![3.0, 5.0]), 1e-10)
                .expect("converges")
                .residual
                > 1e-3
        );
    }

    #[test]
    fn a_vector_in_a_plane_depends_on_what_spans_it() {
        let plane = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 1.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0]);
        let depends = |x: [f64; 3]| depends_on(&DVector::from_row_slice(&x), &plane);
        assert!(depends([0.3, -7.0, 0.0]).expect("converges"));
        assert!(!depends([0.3, -7.0, 1e-9]).expect("converges"));
    }

    #[test]
    fn no_conditions_leave_everything_free() {
        let set = solve(&DMatrix::zeros(0, 2), &DVector::zeros(0), 1e-10).expect("nothing to do");
        assert_eq!((set.null_space.ncols(), set.particular.len()), (2, 2));
        assert!(set.residual == 0.0);
    }
}

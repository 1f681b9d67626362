//! Determinants whose signs are asked for.

use nalgebra::DMatrix;

/// The determinant in parts of the product of the columns' lengths: no larger than one, and zero for singular matrices alone.
pub(crate) fn signed_volume(matrix: DMatrix<f64>) -> f64 {
    let lengths = matrix.column_iter().map(|column| column.norm().ln());
    let lengths: f64 = lengths.sum();
    let lu = matrix.lu();
    let diagonal = lu.u().diagonal();
    let log: f64 = diagonal.iter().map(|x| x.abs().ln()).sum();
    let is_odd = diagonal.iter().filter(|x| **x < 0.0).count() % 2 == 1;
    let sign = lu.p().determinant::<f64>() * if is_odd { -1.0 } else { 1.0 };
    sign * (log - lengths).exp().max(f64::MIN_POSITIVE)
}

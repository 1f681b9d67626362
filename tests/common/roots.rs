//! Eigenvalues of a small matrix, which the search of nalgebra's Schur form alone finds for nearly all of them and seeks for ever for
//! the others.

use nalgebra::linalg::Schur;
use nalgebra::{Complex, DMatrix, DVector};

/// Rounds of the search, far more than it takes where it comes to an end.
const MOST_ROUNDS: usize = 10_000;

/// The eigenvalues of a matrix, to a few digits less where those of the matrix itself are not found.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> DVector<Complex<f64>> {
    let size = matrix.amax();
    (0..20)
        .find_map(|k| {
            // The search runs in a circle on few matrices, and not on those next to them, a little farther off, or moved along the
            // diagonal.
            let by = if k == 0 {
                0.0
            } else {
                1e-16 * 4f64.powi(k % 10)
            };
            let aside = |i: usize, j: usize| by * size * ((i + 2 * j) as f64).sin();
            let shift = size * 0.37 * f64::from(k / 10);
            let near = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
                let along = if i == j { shift } else { 0.0 };
                matrix[(i, j)] + along + aside(i, j)
            });
            let schur = Schur::try_new(near, f64::EPSILON, MOST_ROUNDS)?;
            Some(schur.complex_eigenvalues().map(|z| z - shift))
        })
        .expect("eigenvalues of one of twenty neighbours")
}

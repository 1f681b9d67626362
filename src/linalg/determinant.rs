//! Determinants, which may be larger or smaller than doubles are.

use crate::tolerance::LEAST_COLUMN;
use nalgebra::DMatrix;

/// A determinant by its sign and the logarithm of its size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Determinant {
    sign: f64,
    log: f64,
    /// The logarithm of the product of the columns' lengths, of those that are next to nothing a little more.
    pub lengths: f64,
}

impl Determinant {
    pub fn of(matrix: DMatrix<f64>) -> Self {
        let norms: Vec<f64> = matrix.column_iter().map(|column| column.norm()).collect();
        let largest = norms.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let lengths = norms.iter().map(|own| own.max(LEAST_COLUMN * largest).ln());
        let lengths = lengths.sum();
        let lu = matrix.lu();
        let diagonal = lu.u().diagonal();
        let is_odd = diagonal.iter().filter(|x| **x < 0.0).count() % 2 == 1;
        Self {
            sign: lu.p().determinant::<f64>() * if is_odd { -1.0 } else { 1.0 },
            log: diagonal.iter().map(|x| x.abs().ln()).sum(),
            lengths,
        }
    }

    /// It in parts of a unit, of which the logarithm is given; never zero, so that it has its sign.
    pub fn in_parts_of(self, unit: f64) -> f64 {
        self.sign * (self.log - unit).exp().max(f64::MIN_POSITIVE)
    }
}

/// The determinant in parts of the product of the columns' lengths: no larger than one, and zero for singular matrices alone. By its sign it
/// tells where matrices are singular; it is not smooth where a column comes to nothing.
pub(crate) fn signed_volume(matrix: DMatrix<f64>) -> f64 {
    let own = Determinant::of(matrix);
    own.in_parts_of(own.lengths)
}

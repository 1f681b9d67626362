//! The exponential of a matrix.

use crate::tolerance::HOPELESS_EXPONENT;
use nalgebra::DMatrix;

/// `e^A`; nan throughout where A is so large that no digit could be right, on which scaling and squaring would not end.
pub(crate) fn matrix_exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    if a.iter().all(|x| x.abs() < HOPELESS_EXPONENT) {
        a.exp()
    } else {
        DMatrix::from_element(a.nrows(), a.ncols(), f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn a_rotation_keeps_its_angle_and_a_hopeless_matrix_ends() {
        let turned = matrix_exponential(&dmatrix![0.0, 0.7; -0.7, 0.0]);
        let (sin, cos) = 0.7f64.sin_cos();
        assert!((turned - dmatrix![cos, sin; -sin, cos]).amax() < 1e-15);
        for size in [1e40, 1e300, f64::INFINITY, f64::NAN] {
            let ended = matrix_exponential(&dmatrix![0.0, size; size, 0.0]);
            assert!(ended.iter().all(|x| x.is_nan()));
        }
    }
}

//! Coefficients of the Radau IIA method of order 5 (Hairer and Wanner, Solving Ordinary Differential Equations II, sections
//! IV.5 and IV.8).
//!
//! The nodes are the roots of `M(x) = x^3 - 9/5 x^2 + 9/10 x - 1/10`; the stages are those of the cubic that meets the
//! equation there. The inverse of the Butcher matrix A has the characteristic polynomial `z^3 - 9 z^2 + 36 z - 60`, with
//! the roots `3 + 9^(1/3) - 3^(1/3)` and `3 + (3^(1/3) - 9^(1/3))/2 +- i sqrt(3)/2 (9^(1/3) + 3^(1/3))`. The eigenvector to a
//! root z has the entries `p(c_i)/p(1)`, where p is the cubic with `p' - z p = M` up to a factor and `p(0) = 0`. The columns of
//! [`FROM_MODES`] are the real one, and the real part and less the imaginary part of that to the root with `+i`; so for
//! increments `Z = T W` with `W = (w1, w2, w3)` the product `A^-1 Z` is `T (z1 w1, Re z2 (w2 + i w3), Im z2 (w2 + i w3))`.

use nalgebra::Complex;

/// Stages of the method, the last of which is its end. [exact]
pub(super) const RADAU_STAGES: usize = 3;

/// `sqrt(6)`. [exact]
const ROOT_6: f64 = 2.449_489_742_783_178;

/// The nodes, roots of M. [exact]
pub(super) const RADAU_NODES: [f64; RADAU_STAGES] =
    [(4.0 - ROOT_6) / 10.0, (4.0 + ROOT_6) / 10.0, 1.0];

/// The real eigenvalue of the inverse of the Butcher matrix. [exact]
pub(super) const REAL_EIGENVALUE: f64 = 3.637_834_252_744_496;
/// One of its two conjugate eigenvalues.
pub(super) const PAIR: Complex<f64> =
    Complex::new(2.681_082_873_627_752_3, 3.050_430_199_247_410_5);

/// T, from the modes of the inverse of the Butcher matrix to the stages. [exact]
pub(super) const FROM_MODES: [[f64; RADAU_STAGES]; RADAU_STAGES] = [
    [
        0.094_438_762_488_975_24,
        -0.141_255_295_020_954_2,
        -0.030_029_194_105_147_424,
    ],
    [
        0.250_213_122_965_333_3,
        0.204_129_352_293_799_94,
        0.382_942_112_757_261_9,
    ],
    [1.0, 1.0, 0.0],
];

/// The inverse of T. [exact]
pub(super) const TO_MODES: [[f64; RADAU_STAGES]; RADAU_STAGES] = [
    [
        4.178_718_591_551_905,
        0.327_682_820_761_062_37,
        0.523_376_445_499_449_5,
    ],
    [
        -4.178_718_591_551_905,
        -0.327_682_820_761_062_37,
        0.476_623_554_500_550_44,
    ],
    [
        -0.502_872_634_945_786_8,
        2.571_926_949_855_605,
        -0.596_039_204_828_224_9,
    ],
];

/// Weights of the increments in the error: with weight `h` of the rate at the start it is `1/g0` times the solution of order 3 less that of
/// order 5, where `1/g0` is the real eigenvalue. [exact]
pub(super) const RADAU_ERROR: [f64; RADAU_STAGES] = [
    (-13.0 - 7.0 * ROOT_6) / 3.0,
    (-13.0 + 7.0 * ROOT_6) / 3.0,
    -1.0 / 3.0,
];

/// A matrix of the method times three numbers.
#[inline]
pub(super) fn times(
    matrix: &[[f64; RADAU_STAGES]; RADAU_STAGES],
    x: [f64; RADAU_STAGES],
) -> [f64; RADAU_STAGES] {
    matrix.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, RowVector3, Vector3};

    /// The Butcher matrix: `sum_j a_ij c_j^(k-1) = c_i^k/k` for k = 1, 2, 3, solved.
    fn butcher() -> Matrix3<f64> {
        let power = |k: i32| Vector3::from(RADAU_NODES).map(|c| c.powi(k));
        let powers = Matrix3::from_columns(&[power(0), power(1), power(2)]);
        let integrals = Matrix3::from_columns(&[power(1), power(2) / 2.0, power(3) / 3.0]);
        integrals * powers.try_inverse().expect("distinct nodes")
    }

    fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| rows[i][j])
    }

    #[test]
    fn the_collocation_is_that_of_radau() {
        let r = 6.0_f64.sqrt();
        let known = matrix(&[
            [
                (88.0 - 7.0 * r) / 360.0,
                (296.0 - 169.0 * r) / 1800.0,
                (-2.0 + 3.0 * r) / 225.0,
            ],
            [
                (296.0 + 169.0 * r) / 1800.0,
                (88.0 + 7.0 * r) / 360.0,
                (-2.0 - 3.0 * r) / 225.0,
            ],
            [(16.0 - r) / 36.0, (16.0 + r) / 36.0, 1.0 / 9.0],
        ]);
        assert!((butcher() - known).amax() < 1e-15);
        for c in RADAU_NODES {
            assert!((((c - 1.8) * c + 0.9) * c - 0.1).abs() < 1e-16);
        }
        // The last row are the weights of a quadrature of order 5, which is that of the method with `C(3)` and `D(2)`.
        let (b, c) = (butcher().row(2).into_owned(), Vector3::from(RADAU_NODES));
        for k in 1..=5 {
            let sum = (b * c.map(|c| c.powi(k - 1)))[0];
            assert!((sum - 1.0 / f64::from(k)).abs() < 1e-15, "{k}");
        }
        for k in 1..=2 {
            let row = b.component_mul(&c.map(|c| c.powi(k - 1)).transpose()) * butcher();
            let exact = b.component_mul(&c.map(|c| (1.0 - c.powi(k)) / f64::from(k)).transpose());
            assert!((row - exact).amax() < 1e-15, "{k}");
        }
    }

    #[test]
    fn the_modes_diagonalise_the_inverse() {
        let inverse = butcher().try_inverse().expect("invertible");
        let (t, back) = (matrix(&FROM_MODES), matrix(&TO_MODES));
        assert!((back * t - Matrix3::identity()).amax() < 1e-15);
        let block = matrix(&[
            [REAL_EIGENVALUE, 0.0, 0.0],
            [0.0, PAIR.re, -PAIR.im],
            [0.0, PAIR.im, PAIR.re],
        ]);
        assert!((back * inverse * t - block).amax() < 1e-13);
        let (r3, r9) = (3.0_f64.cbrt(), 9.0_f64.cbrt());
        assert!((REAL_EIGENVALUE - (3.0 + r9 - r3)).abs() < 1e-15);
        let pair = Complex::new(3.0 + (r3 - r9) / 2.0, 0.75_f64.sqrt() * (r3 + r9));
        assert!((PAIR - pair).norm() < 1e-15);
    }

    #[test]
    fn the_error_is_that_of_an_embedded_formula_of_order_three() {
        // Weights of the rates at 0 and at the nodes in the embedded solution.
        let b = butcher().row(2) + RowVector3::from(RADAU_ERROR) / REAL_EIGENVALUE * butcher();
        for k in 1..=4 {
            let first = if k == 1 { 1.0 / REAL_EIGENVALUE } else { 0.0 };
            let sum = first + (b * Vector3::from(RADAU_NODES).map(|c| c.powi(k - 1)))[0];
            assert_eq!((sum - 1.0 / f64::from(k)).abs() < 1e-15, k <= 3, "{k}");
        }
    }
}

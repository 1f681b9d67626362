//! Small dense systems without allocation.

/// Solves `A x = b` in place for a symmetric positive definite A, by rows; A is overwritten. False where a pivot is not
/// positive.
pub(crate) fn solve_positive(a: &mut [f64], b: &mut [f64]) -> bool {
    let is_positive = factor_positive(a, b.len());
    if is_positive {
        solve_factored(a, b);
    }
    is_positive
}

/// The square-root-free Cholesky decomposition of a symmetric positive definite n by n matrix in its place, by rows: the
/// lower triangle holds `L D`. False where a pivot is not positive.
pub(crate) fn factor_positive(a: &mut [f64], n: usize) -> bool {
    for k in 0..n {
        let pivot = a[k * n + k];
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / pivot;
            for j in k + 1..=i {
                a[i * n + j] -= factor * a[j * n + k];
            }
        }
    }
    true
}

/// Solves `A x = b` in place with the decomposition of A.
pub(crate) fn solve_factored(a: &[f64], b: &mut [f64]) {
    let n = b.len();
    for k in 0..n {
        b[k] /= a[k * n + k];
        for i in k + 1..n {
            b[i] -= a[i * n + k] * b[k];
        }
    }
    for k in (0..n).rev() {
        let mut below = 0.0;
        for i in k + 1..n {
            below += a[i * n + k] * b[i];
        }
        b[k] -= below / a[k * n + k];
    }
}

/// Solves `A x = b` in place, A by rows, by elimination with row pivots. False where a pivot is not above the tolerance.
pub(crate) fn eliminate(a: &mut [f64], b: &mut [f64], tolerance: f64) -> bool {
    let n = b.len();
    for k in 0..n {
        let mut row = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[row * n + k].abs() {
                row = i;
            }
        }
        let pivot = a[row * n + k];
        if pivot.is_nan() || pivot.abs() <= tolerance {
            return false;
        }
        if row != k {
            for j in k..n {
                a.swap(row * n + j, k * n + j);
            }
            b.swap(row, k);
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / pivot;
            for j in k + 1..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let mut x = b[k];
        for j in k + 1..n {
            x -= a[k * n + j] * b[j];
        }
        b[k] = x / a[k * n + k];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn it_solves_what_nalgebra_solves() {
        for n in 1..7 {
            let g = DMatrix::from_fn(n, n, |i, j| ((3 * i + 5 * j) % 7) as f64 - 2.0);
            let a = &g * g.transpose() + DMatrix::identity(n, n);
            let b = DVector::from_fn(n, |i, _| 1.0 + i as f64);
            let mut flat: Vec<f64> = a.iter().copied().collect();
            let mut x: Vec<f64> = b.iter().copied().collect();
            assert!(solve_positive(&mut flat, &mut x));
            assert!((&a * DVector::from_vec(x) - b).amax() < 1e-11 * a.amax());
        }
        assert!(!solve_positive(&mut [1.0, 2.0, 2.0, 1.0], &mut [1.0, 1.0]));
        assert!(!solve_positive(&mut [f64::NAN], &mut [1.0]));
    }
}

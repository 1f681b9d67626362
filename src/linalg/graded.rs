//! `K phi = lambda M phi` where the coordinates are stiff by very different measures, as unknowns clamped by a penalty of 1e36 on the
//! diagonal of K: reductions by rotations of two coordinates at a time keep the digits of small eigenvalues, as far as the matrices
//! scaled to unit diagonals have them (J. Demmel, K. Veselic, SIAM J. Matrix Anal. Appl. 13 (1992) 1204). Others have errors relative
//! to the largest eigenvalue.

use crate::error::{Error, Result};
use crate::linalg::eigen::{SWEEPS_PER_ROW, rotation, solve};
use crate::tolerance::GRADED;
use nalgebra::{Cholesky, DMatrix, DVector};

/// The size of `K_ii/M_ii` of each coordinate.
pub(crate) fn squares(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Vec<f64> {
    let (stiffness, mass) = (stiffness.diagonal(), mass.diagonal());
    let both = stiffness.iter().zip(&mass);
    both.map(|(k, m)| (k / m).abs()).collect()
}

/// Whether one of them is a factor below the largest, and not zero.
pub(crate) fn are_apart(squares: &[f64], factor: f64) -> bool {
    let largest = squares.iter().fold(0.0, |most: f64, &x| most.max(x));
    squares.iter().any(|&x| x > 0.0 && x < largest / factor)
}

/// The coordinates in the order of `K_ii/M_ii`, where these are so far apart that errors relative to the largest eigenvalue take
/// digits of the smallest; `None` where they are not.
pub(crate) fn order(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Option<Vec<usize>> {
    let squares = squares(mass, stiffness);
    if !are_apart(&squares, GRADED) {
        return None;
    }
    let mut order: Vec<usize> = (0..squares.len()).collect();
    order.sort_by(|&i, &j| squares[i].total_cmp(&squares[j]));
    Some(order)
}

/// Eigenvalues (ascending) and M-orthonormal shapes, by coordinates in an order of [`order`].
///
/// # Errors
/// `Error::NoConvergence` if the rotations do not end.
pub(crate) fn symmetric_generalised(
    mass: &DMatrix<f64>,
    stiffness: &DMatrix<f64>,
    order: &[usize],
) -> Result<(DVector<f64>, DMatrix<f64>)> {
    let n = order.len();
    let sorted = |a: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| a[(order[i], order[j])]);
    let failed = |sweeps| Error::NoConvergence {
        stage: "the symmetric eigenproblem",
        iterations: sweeps,
        residual: f64::NAN,
    };
    // The stiffest last: L^-1 takes nothing of them to the others.
    let factor = Cholesky::new(sorted(mass))
        .ok_or_else(|| failed(0))?
        .unpack();
    let across = |b: &DMatrix<f64>| {
        factor
            .solve_lower_triangular(b)
            .expect("a Cholesky factor has a positive diagonal")
    };
    let reduced = across(&across(&sorted(stiffness)).transpose());
    let reduced = (&reduced + reduced.transpose()) * 0.5;
    let turned = solve(n, 3, move || Ok(rotated(reduced)))?;
    let (values, vectors) = turned.ok_or_else(|| failed(SWEEPS_PER_ROW))?;
    let shapes = factor
        .tr_solve_lower_triangular(&vectors)
        .expect("a Cholesky factor has a positive diagonal");
    let mut ascending: Vec<usize> = (0..n).collect();
    ascending.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let mut place = vec![0; n];
    for (i, &k) in order.iter().enumerate() {
        place[k] = i;
    }
    Ok((
        DVector::from_fn(n, |i, _| values[ascending[i]]),
        DMatrix::from_fn(n, n, |i, j| shapes[(place[i], ascending[j])]),
    ))
}

/// Eigenvalues and orthonormal eigenvectors of a symmetric matrix by Jacobi's rotations, until none changes a digit.
fn rotated(mut a: DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let n = a.nrows();
    let mut vectors = DMatrix::identity(n, n);
    for _ in 0..SWEEPS_PER_ROW {
        let mut is_done = true;
        for j in 1..n {
            for i in 0..j {
                let between = a[(i, j)];
                let least = a[(i, i)].abs().sqrt() * a[(j, j)].abs().sqrt() * f64::EPSILON;
                if between.abs() <= least.max(f64::MIN_POSITIVE) {
                    continue;
                }
                is_done = false;
                let (t, c, s) = rotation(a[(i, i)], between, a[(j, j)]);
                let (first, second) = (a[(i, i)] - t * between, a[(j, j)] + t * between);
                turn(&mut a, i, j, c, s);
                for k in 0..n {
                    (a[(i, k)], a[(j, k)]) = (a[(k, i)], a[(k, j)]);
                }
                (a[(i, i)], a[(j, j)]) = (first, second);
                (a[(i, j)], a[(j, i)]) = (0.0, 0.0);
                turn(&mut vectors, i, j, c, s);
            }
        }
        if is_done {
            return Some((a.diagonal(), vectors));
        }
    }
    None
}

/// Turns two columns of a matrix in their plane.
fn turn(a: &mut DMatrix<f64>, i: usize, j: usize, c: f64, s: f64) {
    for k in 0..a.nrows() {
        let (x, y) = (a[(k, i)], a[(k, j)]);
        (a[(k, i)], a[(k, j)]) = (c * x - s * y, s * x + c * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `K = T^T diag(k) T`, `M = T^T T` with a unit lower triangle T: the squared frequencies are k.
    fn structure(k: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = k.len();
        let turn = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Greater => 0.25 * (1.0 + (i * 3 + j) as f64).cos(),
        });
        let form = |d: DVector<f64>| turn.transpose() * DMatrix::from_diagonal(&d) * &turn;
        let own = DVector::from_column_slice(k);
        (form(DVector::from_element(n, 1.0)), form(own))
    }

    #[test]
    fn small_eigenvalues_keep_their_digits_beside_a_penalty() {
        // A penalty on the last unknown, of a structure of K = diag(1, 4, 9) and full M: that of the first three alone, as the
        // penalty tends to infinity.
        let (mass, _) = structure(&[1.0, 2.0, 3.0, 4.0]);
        let three = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0, 9.0]));
        let rest = mass.view((0, 0), (3, 3)).into_owned();
        let held = Cholesky::new(rest).expect("positive definite");
        let (exact, _) = crate::linalg::eigen::symmetric_generalised(&held, &three).expect("ends");
        for exponent in [18, 24, 36, 200] {
            let mut stiffness = DMatrix::zeros(4, 4);
            stiffness.view_mut((0, 0), (3, 3)).copy_from(&three);
            stiffness[(3, 3)] = 10f64.powi(exponent);
            let order = order(&mass, &stiffness).expect("far apart");
            let (values, shapes) = symmetric_generalised(&mass, &stiffness, &order).expect("ends");
            for k in 0..3 {
                let off = (values[k] / exact[k] - 1.0).abs();
                assert!(off < 1e-14, "{exponent} {k}: {off:e}");
            }
            let unit = shapes.transpose() * &mass * &shapes - DMatrix::identity(4, 4);
            assert!(unit.amax() < 1e-14, "{unit}");
            // The penalty alone, of the mass that the others leave: p/(M^-1)_33^-1.
            let left = mass.clone().try_inverse().expect("regular")[(3, 3)];
            assert!((values[3] / (stiffness[(3, 3)] * left) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn coordinates_of_one_stiffness_are_left_to_others() {
        let (mass, stiffness) = structure(&[1.0, 20.0, 300.0]);
        assert!(order(&mass, &stiffness).is_none());
        // Rows without stiffness say nothing of a scale.
        assert!(order(&DMatrix::identity(2, 2), &DMatrix::zeros(2, 2)).is_none());
    }

    #[test]
    fn rigid_body_motions_beside_a_penalty_have_no_frequency() {
        // Two masses on a spring, free, and a third unknown that is clamped.
        let mass = DMatrix::identity(3, 3);
        let stiffness =
            DMatrix::from_row_slice(3, 3, &[1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 1e36]);
        let order = order(&mass, &stiffness).expect("far apart");
        let (values, _) = symmetric_generalised(&mass, &stiffness, &order).expect("ends");
        assert!(values[0].abs() < 1e-15 && (values[1] - 2.0).abs() < 1e-15);
    }
}

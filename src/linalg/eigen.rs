//! Eigenproblems with guards: symmetric generalised (Cholesky reduction) and non-symmetric with eigenvectors (complex
//! Schur form). Every iteration has a cap: an uncapped QR iteration never ends on, say, cyclic permutations.

use crate::error::{Error, Result};
use crate::linalg::compensated::dot;
use crate::linalg::francis;
use crate::observer::apart;
use crate::quantity::room_for;
use crate::tolerance::{
    CLOSE_ROOTS, ROOT_REFINEMENT, SCHUR_SHIFT, UNBALANCED_RATIO, VECTOR_REFINEMENT,
};
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Cholesky, Complex, DMatrix, DVector, Dyn, SMatrix, Schur, SymmetricEigen};
use std::borrow::Cow;

/// Sweeps of the QR iteration allowed, for each row of the matrix. [work]
pub(super) const SWEEPS_PER_ROW: usize = 100;

/// Number of rows from which an eigenproblem takes so long that it is solved on a thread of its own, to be abandoned where the computation
/// is interrupted. [work]
const LARGE_EIGENPROBLEM: usize = 64;

/// Solves an eigenproblem of a matrix of so many rows, which takes so many matrices of its size.
pub(super) fn solve<T: Send + 'static>(
    rows: usize,
    matrices: usize,
    problem: impl FnOnce() -> Result<T> + Send + 'static,
) -> Result<T> {
    room_for("an eigenproblem", rows, rows.saturating_mul(matrices))?;
    if rows < LARGE_EIGENPROBLEM {
        return problem();
    }
    apart(problem)?
}

/// Eigenvalues (ascending) and orthonormal eigenvectors of a symmetric matrix.
pub(crate) fn symmetric(a: DMatrix<f64>) -> Result<(DVector<f64>, DMatrix<f64>)> {
    solve(a.nrows(), 3, move || symmetric_problem(a))
}

fn symmetric_problem(a: DMatrix<f64>) -> Result<(DVector<f64>, DMatrix<f64>)> {
    let n = a.nrows();
    if n == 2 {
        return Ok(symmetric_2(&a));
    }
    let cap = SWEEPS_PER_ROW * n;
    let eigen = SymmetricEigen::try_new(a, f64::EPSILON, cap).ok_or(Error::NoConvergence {
        stage: "the symmetric eigenproblem",
        iterations: cap,
        residual: f64::NAN,
    })?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let values = DVector::from_fn(n, |i, _| eigen.eigenvalues[order[i]]);
    let vectors = DMatrix::from_fn(n, n, |i, j| eigen.eigenvectors[(i, order[j])]);
    Ok((values, vectors))
}

/// The rotation that takes `[[p, q], [q, r]]` to `diag(p - t q, r + t q)` (Jacobi): its tangent t, cosine and sine.
pub(super) fn rotation(p: f64, q: f64, r: f64) -> (f64, f64, f64) {
    let t = if q == 0.0 {
        0.0
    } else {
        let tau = (r - p) / (2.0 * q);
        tau.signum() / (tau.abs() + tau.hypot(1.0))
    };
    let c = 1.0 / t.hypot(1.0);
    (t, c, t * c)
}

/// The 2 by 2 case by one Jacobi rotation, which keeps the relative accuracy of a small eigenvalue.
fn symmetric_2(a: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let (p, q, r) = (a[(0, 0)], 0.5 * (a[(0, 1)] + a[(1, 0)]), a[(1, 1)]);
    let (t, c, s) = rotation(p, q, r);
    let (first, second) = ((p - t * q, [c, -s]), (r + t * q, [s, c]));
    let (low, high) = if first.0 <= second.0 {
        (first, second)
    } else {
        (second, first)
    };
    let vectors = DMatrix::from_column_slice(2, 2, &[low.1[0], low.1[1], high.1[0], high.1[1]]);
    (DVector::from_vec(vec![low.0, high.0]), vectors)
}

/// `K phi = lambda M phi` with `Phi^T M Phi = I`, `lambda` ascending; `mass` is the Cholesky factor of M.
pub(crate) fn symmetric_generalised(
    mass: &Cholesky<f64, Dyn>,
    stiffness: &DMatrix<f64>,
) -> Result<(DVector<f64>, DMatrix<f64>)> {
    let l = mass.l();
    let solve = |b: &DMatrix<f64>| {
        l.solve_lower_triangular(b)
            .expect("a Cholesky factor has a positive diagonal")
    };
    let half = solve(stiffness);
    let reduced = solve(&half.transpose());
    let reduced = (&reduced + reduced.transpose()) * 0.5;
    let (values, vectors) = symmetric(reduced)?;
    let shapes = l
        .tr_solve_lower_triangular(&vectors)
        .expect("a Cholesky factor has a positive diagonal");
    Ok((values, shapes))
}

/// Complex Schur form `A = Q T Q^*`, retried on a shifted and on a rotated matrix when the iteration stalls.
fn complex_schur(a: &DMatrix<f64>) -> Result<(DMatrix<Complex<f64>>, DMatrix<Complex<f64>>)> {
    let n = a.nrows();
    let cap = SWEEPS_PER_ROW * n.max(1);
    let complex = |m: &DMatrix<f64>| m.map(|x| Complex::new(x, 0.0));
    if let Some(schur) = Schur::try_new(complex(a), f64::EPSILON, cap) {
        return Ok(schur.unpack());
    }
    let scale = a.amax().max(f64::MIN_POSITIVE);
    let shift = SCHUR_SHIFT * scale;
    if let Some(schur) = Schur::try_new(
        complex(&(a + DMatrix::identity(n, n) * shift)),
        f64::EPSILON,
        cap,
    ) {
        let (q, mut t) = schur.unpack();
        for i in 0..n {
            t[(i, i)] -= shift;
        }
        return Ok((q, t));
    }
    let rotation = fixed_orthogonal(n);
    let rotated = &rotation * a * rotation.transpose();
    let (q, t) = Schur::try_new(complex(&rotated), f64::EPSILON, cap)
        .ok_or(Error::NoConvergence {
            stage: "the Schur form",
            iterations: cap,
            residual: f64::NAN,
        })?
        .unpack();
    Ok((complex(&rotation.transpose()) * q, t))
}

/// A dense orthogonal matrix that is the same on every call: the Q of a matrix of incommensurable cosines.
fn fixed_orthogonal(n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| {
        (1.0 + 1.7 * i as f64 + 0.9 * (j * j) as f64).cos()
    })
    .qr()
    .q()
}

/// A matrix whose rows and columns are of one size, the same but for similarity; one that is not far from it as it is.
fn balanced(a: &DMatrix<f64>) -> Cow<'_, DMatrix<f64>> {
    let off = |i: usize, other: usize| if i == other { 0.0 } else { 1.0 };
    let is_far = (0..a.nrows()).any(|i| {
        let row = (0..a.ncols()).fold(0.0f64, |most, j| most.max(off(i, j) * a[(i, j)].abs()));
        let column = (0..a.nrows()).fold(0.0f64, |most, j| most.max(off(i, j) * a[(j, i)].abs()));
        row > UNBALANCED_RATIO * column && column > 0.0
            || column > UNBALANCED_RATIO * row && row > 0.0
    });
    if !is_far {
        return Cow::Borrowed(a);
    }
    let mut own = a.clone();
    balance_parlett_reinsch(&mut own);
    Cow::Owned(own)
}

/// Eigenvalues of a real square matrix: by real arithmetic, by the guarded complex Schur form where that stalls.
pub(crate) fn eigenvalues(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>> {
    let a = balanced(a);
    let values = match a.nrows() {
        // Two degrees of freedom are what most maps are made of: keep their matrices on the stack.
        4 => francis::eigenvalues(SMatrix::<f64, 4, 4>::from_column_slice(a.as_slice())),
        n => {
            let a = a.clone().into_owned();
            solve(n, 2, move || Ok(francis::eigenvalues(a)))?
        }
    };
    if let Some(values) = values {
        return Ok(values);
    }
    let a = a.into_owned();
    let (_, t) = solve(a.nrows(), 8, move || complex_schur(&a))?;
    Ok(t.diagonal().iter().copied().collect())
}

/// Eigenvalues and right eigenvectors (unit columns) of a real square matrix.
pub(crate) fn eigenvectors(
    a: &DMatrix<f64>,
) -> Result<(DVector<Complex<f64>>, DMatrix<Complex<f64>>)> {
    room_for("an eigenproblem", a.nrows(), a.nrows())?;
    let a = a.clone();
    solve(a.nrows(), 12, move || vectors_problem(&a))
}

fn vectors_problem(a: &DMatrix<f64>) -> Result<(DVector<Complex<f64>>, DMatrix<Complex<f64>>)> {
    let n = a.nrows();
    let (q, t) = complex_schur(a)?;
    let smallest = f64::EPSILON * t.iter().fold(f64::MIN_POSITIVE, |m, z| m.max(z.norm()));
    let mut vectors = DMatrix::<Complex<f64>>::zeros(n, n);
    for k in 0..n {
        vectors[(k, k)] = Complex::new(1.0, 0.0);
        for i in (0..k).rev() {
            let sum: Complex<f64> = (i + 1..=k).map(|j| t[(i, j)] * vectors[(j, k)]).sum();
            let mut pivot = t[(i, i)] - t[(k, k)];
            if pivot.norm() < smallest {
                pivot = Complex::new(smallest, 0.0);
            }
            vectors[(i, k)] = -sum / pivot;
        }
    }
    let (mut roots, mut vectors) = (t.diagonal(), q * vectors);
    // The QR iteration leaves each root and vector with a rounding of the whole matrix.
    normalise(&mut vectors);
    refine(a, &mut roots, &mut vectors);
    normalise(&mut vectors);
    Ok((roots, vectors))
}

/// Makes the columns unit vectors.
fn normalise(vectors: &mut DMatrix<Complex<f64>>) {
    for mut column in vectors.column_iter_mut() {
        let norm = column.norm();
        column.unscale_mut(norm);
    }
}

/// One Newton step on all roots and vectors at once: with `R = V^-1 (A V - V L)` the roots move by `R_jj`, the vectors by
/// `V E`, `E_ij = R_ij/(l_j - l_i)`. Nothing is done where that is no small step: to vectors that are nearly dependent.
/// What is left of `A V - V L` in doubles is rounding, which V^-1 makes as much larger as vectors are near to each other: it
/// is summed in twice the precision.
fn refine(
    a: &DMatrix<f64>,
    roots: &mut DVector<Complex<f64>>,
    vectors: &mut DMatrix<Complex<f64>>,
) {
    let Some(inverse) = vectors.clone().try_inverse() else {
        return;
    };
    let n = roots.len();
    let r = inverse * residual(a, roots, vectors);
    let turn = DMatrix::from_fn(n, n, |i, j| {
        let apart = roots[j] - roots[i];
        let is_near = apart.norm() <= CLOSE_ROOTS * roots[i].norm().max(roots[j].norm());
        if is_near {
            Complex::new(0.0, 0.0)
        } else {
            r[(i, j)] / apart
        }
    });
    let scale = roots
        .iter()
        .fold(0.0f64, |largest, z| largest.max(z.norm()));
    let is_small = |m: &DMatrix<Complex<f64>>, bound: f64| m.iter().all(|z| z.norm() <= bound);
    if is_small(&r, ROOT_REFINEMENT * scale) && is_small(&turn, VECTOR_REFINEMENT) {
        *vectors += &*vectors * turn;
        *roots += r.diagonal();
    }
}

/// `A V - V L`, each entry rounded once.
fn residual(
    a: &DMatrix<f64>,
    roots: &DVector<Complex<f64>>,
    vectors: &DMatrix<Complex<f64>>,
) -> DMatrix<Complex<f64>> {
    let parts = [vectors.map(|z| z.re), vectors.map(|z| z.im)];
    let rows = a.transpose();
    DMatrix::from_fn(a.nrows(), roots.len(), |i, j| {
        let (root, z) = (roots[j], vectors[(i, j)]);
        let less = |part: usize, by: [f64; 2]| {
            let row = rows.column(i).into_iter().copied();
            let column = parts[part].column(j).into_iter().copied();
            dot(row.chain(by), column.chain([z.re, z.im]))
        };
        Complex::new(less(0, [-root.re, root.im]), less(1, [-root.im, -root.re]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cyclic_permutation(n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| if (j + 1) % n == i { 1.0 } else { 0.0 })
    }

    #[test]
    fn cyclic_permutations_have_the_roots_of_unity() {
        for n in [2, 3, 6, 8, 10, 12, 16, 24] {
            let (values, vectors) = eigenvectors(&cyclic_permutation(n)).expect("guarded");
            for z in values.iter() {
                assert!((z.powu(u32::try_from(n).expect("small")) - 1.0).norm() < 1e-12);
            }
            let a = cyclic_permutation(n).map(|x| Complex::new(x, 0.0));
            let residual = &a * &vectors - &vectors * DMatrix::from_diagonal(&values);
            assert!(residual.norm() < 1e-12, "order {n}: {}", residual.norm());
        }
    }

    #[test]
    fn small_eigenvalue_of_a_graded_pair_keeps_its_digits() {
        // diag(1, 1e12) rotated by the exact rational angle of (3, 4, 5) would round; a graded matrix does not.
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1e12]);
        let (values, _) = symmetric(a).expect("closed form");
        // lambda = 1 - 1/(1e12 - 1) + O(1e-36)
        assert!((values[0] - (1.0 - 1.0 / (1e12 - 1.0))).abs() < 2e-16);
    }

    #[test]
    fn slow_and_fast_roots_keep_their_digits() {
        for (stiff, damper) in [(1e8, 200.0), (1e8, 3e3), (1e12, 1e3)] {
            let a = DMatrix::from_row_slice(
                4,
                4,
                &[
                    0.0, 0.0, 1.0, 0.0, //
                    0.0, 0.0, 0.0, 1.0, //
                    -stiff, 1.0, -damper, 0.0, //
                    1.0, -1.0, 0.0, -0.1,
                ],
            );
            let (values, vectors) = eigenvectors(&a).expect("guarded");
            // (z^2 + damper z + stiff)(z^2 + 0.1 z + 1) = 1, by z = -0.05 + i sqrt(0.9975 - 1/(z^2 + damper z + stiff)).
            let mut z = Complex::new(-0.05, 1.0);
            for _ in 0..20 {
                let coupling = 1.0 / (z * z + z * damper + stiff);
                z = Complex::new(-0.05, 0.0)
                    + Complex::<f64>::i() * (Complex::new(0.9975, 0.0) - coupling).sqrt();
            }
            let mut fast = Complex::new(-0.5 * damper, f64::sqrt(stiff));
            for _ in 0..20 {
                let coupling = 1.0 / (fast * fast + fast * 0.1 + 1.0);
                let below = Complex::from(stiff - 0.25 * damper * damper) - coupling;
                fast = Complex::<f64>::i() * below.sqrt() - 0.5 * damper;
            }
            let miss = values.iter().map(|v| (v - fast).norm());
            let miss = miss.fold(f64::INFINITY, f64::min) / fast.norm();
            assert!(miss < 4e-15, "{stiff:e} {damper:e} {miss:e}");
            let off = |k: usize| (values[k] - z).norm();
            let nearest = (0..4).min_by(|&i, &j| off(i).total_cmp(&off(j)));
            let k = nearest.expect("four roots");
            assert!(off(k) < 4e-15, "{stiff:e} {:e}", off(k));
            // The second coordinate of its vector moves by z times its position, and the first follows it by 1/stiff.
            let v = vectors.column(k);
            assert!((v[3] / v[1] - z).norm() < 1e-14);
            let follows = 1.0 / (z * z + z * damper + stiff);
            assert!((v[0] / v[1] / follows - 1.0).norm() < 1e-6);
        }
    }

    #[test]
    fn generalised_shapes_are_mass_orthonormal() {
        let m = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.0, 1.0, 3.0, 1.0, 0.0, 1.0, 2.0]);
        let k = DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]);
        let (values, phi) =
            symmetric_generalised(&Cholesky::new(m.clone()).expect("positive definite"), &k)
                .expect("converges");
        assert!((phi.transpose() * &m * &phi - DMatrix::identity(3, 3)).amax() < 1e-14);
        assert!((phi.transpose() * k * &phi - DMatrix::from_diagonal(&values)).amax() < 1e-14);
    }
}

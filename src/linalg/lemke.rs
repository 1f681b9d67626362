//! Lemke's method: the active set of a linear complementarity problem `0 <= x perp w = M x + q >= 0`, by pivoting along
//! the path of `w = M x + q + z 1` from a large z to z = 0. Ties are broken lexicographically, so the path cannot cycle.
//! R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem (1992), sections 4.4 and 4.9.

use crate::tolerance::TIE_TOL;
use nalgebra::DMatrix;

/// Pivots allowed per unknown; problems from mechanics take one or two. [work]
const PIVOTS_PER_UNKNOWN: usize = 50;

/// The indices of the unknowns in the basis where the path ends. It is the active set of a solution for every positive
/// semidefinite M whose problem has one; where the path ends otherwise (on a ray), it is no solution's: check it. Entries up
/// to `pivot_tol` are no pivots; the problem is scaled to entries of order one.
pub(crate) fn active_set(m: &DMatrix<f64>, q: &[f64], pivot_tol: f64) -> Vec<usize> {
    let k = q.len();
    if q.iter().all(|&q| q >= 0.0) {
        return Vec::new();
    }
    let mut tableau = Tableau::new(m, q);
    let mut entering = tableau.artificial();
    let mut row = Some(tableau.first_row());
    for _ in 0..PIVOTS_PER_UNKNOWN * k {
        let Some(leaving_row) = row else { break };
        let leaving = tableau.pivot(leaving_row, entering);
        if leaving == tableau.artificial() {
            break;
        }
        entering = if leaving < k {
            leaving + k
        } else {
            leaving - k
        };
        row = tableau.ratio_test(entering, pivot_tol);
    }
    let mut active: Vec<usize> = tableau
        .basis
        .iter()
        .filter(|&&variable| (k..2 * k).contains(&variable))
        .map(|variable| variable - k)
        .collect();
    active.sort_unstable();
    active
}

/// `I w - M x - 1 z = q`, in the current basis. Columns: k of w, k of x, z, the right-hand side.
struct Tableau {
    entries: DMatrix<f64>,
    /// The basic variable of each row.
    basis: Vec<usize>,
}

impl Tableau {
    fn new(m: &DMatrix<f64>, q: &[f64]) -> Self {
        let k = q.len();
        let size = q.iter().fold(0.0_f64, |size, q| size.max(q.abs()));
        let unit = if size > 0.0 { size } else { 1.0 };
        let entries = DMatrix::from_fn(k, 2 * k + 2, |i, j| match j {
            _ if j < k => f64::from(u8::from(i == j)),
            _ if j < 2 * k => -m[(i, j - k)],
            _ if j == 2 * k => -1.0,
            _ => q[i] / unit,
        });
        Self {
            entries,
            basis: (0..k).collect(),
        }
    }

    /// The column of z.
    fn artificial(&self) -> usize {
        2 * self.basis.len()
    }

    /// The row where z enters: the least `q_i`, the last of tied ones, which is lexicographically least.
    fn first_row(&self) -> usize {
        let right = self.entries.column(self.artificial() + 1);
        let least = right.min();
        right.iter().rposition(|&q| q <= least).unwrap_or(0)
    }

    /// Brings a variable into the basis; returns the one that leaves.
    fn pivot(&mut self, row: usize, entering: usize) -> usize {
        let pivot = self.entries[(row, entering)];
        for j in 0..self.entries.ncols() {
            self.entries[(row, j)] /= pivot;
        }
        for i in 0..self.basis.len() {
            let factor = self.entries[(i, entering)];
            if i != row && factor != 0.0 {
                for j in 0..self.entries.ncols() {
                    self.entries[(i, j)] -= factor * self.entries[(row, j)];
                }
            }
        }
        std::mem::replace(&mut self.basis[row], entering)
    }

    /// The row that first reaches zero as a variable grows: z's if it is among the tied ones, else the lexicographically
    /// least. None on a ray.
    fn ratio_test(&self, entering: usize, pivot_tol: f64) -> Option<usize> {
        let k = self.basis.len();
        let mut rows: Vec<usize> = (0..k)
            .filter(|&i| self.entries[(i, entering)] > pivot_tol)
            .collect();
        for column in std::iter::once(self.artificial() + 1).chain(0..k) {
            let ratio = |i: usize| self.entries[(i, column)] / self.entries[(i, entering)];
            let least = rows.iter().fold(f64::INFINITY, |r, &i| r.min(ratio(i)));
            rows.retain(|&i| ratio(i) <= least + TIE_TOL * (1.0 + least.abs()));
            if let Some(&end) = rows.iter().find(|&&i| self.basis[i] == self.artificial()) {
                return Some(end);
            }
            if rows.len() <= 1 {
                break;
            }
        }
        rows.first().copied()
    }
}

//! The kernel of a small matrix of functions that has one column more than rows, on an interval: by elimination with the pivots of the middle,
//! in units of which the rest is near the identity. It costs the cube of the size where determinants by expansion cost its power of two.

use crate::orbit::two_instants::taylor_model::TaylorModel;
use nalgebra::{DMatrix, DVector};

/// A vector that the matrix, given by its rows, takes to zero all over the interval; it vanishes only where the matrix loses two ranks.
/// `None` where the interval is too long for its pivots.
pub(super) fn kernel(matrix: &[TaylorModel], n_columns: usize) -> Option<Vec<TaylorModel>> {
    let Eliminated { table, columns } = Eliminated::new(matrix, n_columns)?;
    let rank = table.len() - 1;
    let left = |row: usize| [&table[row][rank], &table[row][rank + 1]];
    let [a, b] = left(rank);
    let minus = |of: &TaylorModel| TaylorModel::sum([(-1.0, of)].into_iter());
    let eliminated = (0..rank).map(|row| {
        let [by_a, by_b] = left(row);
        TaylorModel::sum_of_products([(-1.0, by_a, b), (1.0, by_b, a)].into_iter())
    });
    let by_order = eliminated.chain([*b, minus(a)]);
    let mut found = vec![TaylorModel::constant(0.0); n_columns];
    for (model, &column) in by_order.zip(&columns) {
        found[column] = model;
    }
    Some(found)
}

/// The determinant of a square matrix, given by its rows, over a factor that vanishes only where the matrix loses two ranks.
pub(super) fn determinant(matrix: &[TaylorModel], n_columns: usize) -> Option<TaylorModel> {
    let Eliminated { table, .. } = Eliminated::new(matrix, n_columns)?;
    Some(table[n_columns - 1][n_columns - 1])
}

/// A matrix of which all rows but the last have been solved for their pivots.
struct Eliminated {
    /// By rows, those that are left behind the pivots: what the pivot unknowns are of the others, with the sign of the left-hand side; last the
    /// condition on these.
    table: Vec<Vec<TaylorModel>>,
    /// The columns in their new order, those of the pivots first.
    columns: Vec<usize>,
}

impl Eliminated {
    fn new(matrix: &[TaylorModel], n_columns: usize) -> Option<Self> {
        let n_rows = matrix.len() / n_columns;
        let rank = n_rows - 1;
        let entry = |row: usize, column: usize| &matrix[row * n_columns + column];
        let centre = DMatrix::from_fn(n_rows, n_columns, |i, j| entry(i, j).at_origin());
        if centre.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let [rows, columns] = pivots(&centre);
        let pivotal = DMatrix::from_fn(rank, rank, |i, j| centre[(rows[i], columns[j])]);
        let inverse = pivotal.try_inverse()?;
        let near_identity = |i: usize, column: usize| {
            let terms = (0..rank).map(|k| (inverse[(i, k)], entry(rows[k], column)));
            TaylorModel::sum(terms)
        };
        let row = |i: usize| columns.iter().map(|&c| near_identity(i, c)).collect();
        let mut table: Vec<Vec<TaylorModel>> = (0..rank).map(row).collect();
        let last = columns.iter().map(|&column| *entry(rows[rank], column));
        table.push(last.collect());
        for k in 0..rank {
            let over_pivot = table[k][k].reciprocal()?;
            for own in &mut table[k][k + 1..] {
                *own = TaylorModel::sum_of_products([(1.0, &*own, &over_pivot)].into_iter());
            }
            let (above, below) = table.split_at_mut(k + 1);
            let eliminated = |row: &mut Vec<_>| eliminate(row, &above[k], k, k + 1..n_columns);
            below.iter_mut().for_each(eliminated);
        }
        for k in (1..rank).rev() {
            let (above, below) = table.split_at_mut(k);
            let eliminated = |row: &mut Vec<_>| eliminate(row, &below[0], k, rank..n_columns);
            above.iter_mut().for_each(eliminated);
        }
        Some(Self { table, columns })
    }
}

/// Takes a multiple of a row whose entry in a column is one from another, so that its own is zero there; in some columns.
fn eliminate(
    row: &mut [TaylorModel],
    by: &[TaylorModel],
    column: usize,
    columns: std::ops::Range<usize>,
) {
    let (one, factor) = (TaylorModel::constant(1.0), row[column]);
    for c in columns {
        row[c] = TaylorModel::sum_of_products(
            [(1.0, &one, &row[c]), (-1.0, &factor, &by[c])].into_iter(),
        );
    }
}

/// The rows and the columns of a matrix in the order in which its largest entries are pivots.
fn pivots(matrix: &DMatrix<f64>) -> [Vec<usize>; 2] {
    let lu = matrix.clone().full_piv_lu();
    let numbers = |count: usize| DVector::from_fn(count, |i, _| i);
    let mut rows = numbers(matrix.nrows());
    lu.p().permute_rows(&mut rows);
    let mut columns = numbers(matrix.ncols());
    lu.q().permute_rows(&mut columns);
    [rows, columns].map(|own| own.as_slice().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orbit::two_instants::green::{TimeInterval, turned};

    #[test]
    fn a_kernel_is_taken_to_zero_all_over() {
        let cell = TimeInterval {
            origin: 0.7,
            scale: 0.05,
            low: 0.65,
            high: 0.75,
        };
        let amplitudes = |k: usize| [(1.0 + 1.3 * k as f64).sin(), (0.4 - 2.1 * k as f64).cos()];
        let (n_rows, n_columns) = (4, 5);
        let entries: Vec<TaylorModel> = (0..n_rows * n_columns)
            .map(|k| turned(&cell, 0.3 + 0.2 * (k % 7) as f64, amplitudes(k))[0].series(1.0))
            .collect();
        let found = kernel(&entries, n_columns).expect("a short interval");
        for x in [-1.0, -0.4, 0.0, 0.7, 1.0] {
            let size = found
                .iter()
                .map(|own| own.value(x).abs())
                .fold(0.0, f64::max);
            assert!(size > 1e-3, "{size}");
            for row in entries.chunks(n_columns) {
                let sum: f64 = row
                    .iter()
                    .zip(&found)
                    .map(|(a, y)| a.value(x) * y.value(x))
                    .sum();
                let slack: f64 = found.iter().map(|own| 5.0 * own.remainder()).sum();
                assert!(
                    slack < 1e-6 && sum.abs() <= slack + 1e-14,
                    "{x} {sum:e} {slack:e}"
                );
            }
        }
        let wide = TimeInterval {
            origin: 3.0,
            scale: 3.0,
            low: 0.0,
            high: 6.0,
        };
        let entries: Vec<TaylorModel> = (0..n_rows * n_columns)
            .map(|k| turned(&wide, 4.0, amplitudes(k))[0].series(1.0))
            .collect();
        assert!(kernel(&entries, n_columns).is_none());
    }
}

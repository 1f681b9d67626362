//! Sums of products as if in twice the precision (T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci. Comput. 26 (2005) 1955): what a
//! slow mode of a stiff system is made of cancels in doubles.

use crate::tolerance::{COMPENSATED_LOSS, ENTRY_ROUNDINGS};
use nalgebra::{DMatrix, DVector};

/// `sum x_i y_i`, rounded once but for `n^2 eps^2` of the sum of the sizes.
pub(crate) fn dot(x: impl Iterator<Item = f64>, y: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut rest) = (0.0f64, 0.0f64);
    for (x, y) in x.zip(y) {
        let product = x * y;
        let lost = x.mul_add(y, -product);
        let next = sum + product;
        let part = next - sum;
        rest += ((sum - (next - part)) + (product - part)) + lost;
        sum = next;
    }
    sum + rest
}

/// The values `x_j.A x_j` of a form at the columns of a matrix.
pub(crate) fn quadratic(a: &DMatrix<f64>, columns: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_fn(columns.ncols(), |j, _| {
        form(a, columns.column(j).as_slice())
    })
}

/// What the rounding of A's entries may make of those values: some units in the last place of the sum of the sizes of the
/// terms.
pub(crate) fn quadratic_rounding(a: &DMatrix<f64>, columns: &DMatrix<f64>) -> DVector<f64> {
    let sizes = a.abs();
    DVector::from_fn(columns.ncols(), |j, _| {
        let x = columns.column(j).abs();
        ENTRY_ROUNDINGS * f64::EPSILON * x.dot(&(&sizes * &x))
    })
}

fn form(a: &DMatrix<f64>, x: &[f64]) -> f64 {
    let (mut value, mut size) = (0.0, 0.0);
    for (column, y) in a.column_iter().zip(x) {
        for (a, x) in column.iter().zip(x) {
            let term = a * x * y;
            value += term;
            size += term.abs();
        }
    }
    if size <= COMPENSATED_LOSS * value.abs() {
        return value;
    }
    let image = a
        .row_iter()
        .map(|row| dot(row.iter().copied(), x.iter().copied()));
    dot(image, x.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_is_summed_as_if_in_twice_the_precision() {
        // (1, 1 + d).A (1, 1 + d) = 1 + s d^2, all numbers powers of two: exact in doubles, lost in a plain sum.
        let (s, d) = (2f64.powi(50), 2f64.powi(-40));
        let a = DMatrix::from_row_slice(2, 2, &[s + 1.0, -s, -s, s]);
        assert_eq!(a[(0, 0)] - s, 1.0);
        let x = DMatrix::from_row_slice(2, 1, &[1.0, 1.0 + d]);
        assert_eq!(quadratic(&a, &x)[0], 1.0 + s * d * d);
    }
}

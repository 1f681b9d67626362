//! Taylor series as plain numbers: a unit of time, and the coefficients of each position in it.

use crate::model::PhysicalState;
use nalgebra::DVector;

/// How many numbers a Taylor series of n positions has, its unit of time with them.
pub(crate) fn series_width(order: usize, n: usize) -> usize {
    1 + n * (order + 2)
}

/// Writes Taylor series of n positions, each given by its coefficients, in a unit of time.
pub(crate) fn write_series<C: Iterator<Item = f64>>(
    unit: f64,
    coefficients: impl Fn(usize) -> C,
    n: usize,
    numbers: &mut Vec<f64>,
) {
    numbers.push(unit);
    for i in 0..n {
        let mut power = 1.0;
        for c in coefficients(i) {
            numbers.push(c * power);
            power *= unit;
        }
    }
}

/// Position and velocity a time after the start of Taylor series.
pub(crate) fn read_series(numbers: &[f64], order: usize, local: f64) -> PhysicalState {
    let (unit, rows) = (numbers[0], numbers[1..].chunks(order + 2));
    let x = local / unit;
    let (mut q, mut v) = (DVector::zeros(rows.len()), DVector::zeros(rows.len()));
    for (i, row) in rows.enumerate() {
        for c in row.iter().rev() {
            v[i] = v[i] * x + q[i];
            q[i] = q[i] * x + c;
        }
    }
    (q, v / unit)
}

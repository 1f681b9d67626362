//! Determinants of a small matrix of functions by expansion along its rows: no division, so nothing that a pole could
//! spoil, and zero entries cost nothing.

use crate::orbit::two_instants::taylor_model::TaylorModel;

/// The minors over the leading rows that the wanted determinants are made of.
pub(crate) struct Minors {
    columns: usize,
    /// Sets of columns, as bit masks, of 1, 2, ... members.
    levels: Vec<Vec<usize>>,
    table: Vec<TaylorModel>,
}

impl Minors {
    /// The plan for determinants over the given sets of columns, each as large as the number of rows.
    pub fn new(columns: usize, rows: usize, wanted: &[usize]) -> Self {
        let mut levels = vec![wanted.to_vec()];
        for _ in 1..rows {
            let mut below: Vec<usize> = levels[levels.len() - 1]
                .iter()
                .flat_map(|&set| {
                    (0..columns)
                        .filter(move |c| set >> c & 1 == 1)
                        .map(move |c| set & !(1 << c))
                })
                .collect();
            below.sort_unstable();
            below.dedup();
            levels.push(below);
        }
        levels.reverse();
        Self {
            columns,
            levels,
            table: vec![TaylorModel::constant(0.0); 1 << columns],
        }
    }

    /// Computes the determinants of a matrix given by rows; read them with `det`.
    pub fn compute(&mut self, matrix: &[TaylorModel]) {
        let columns = self.columns;
        self.table[0] = TaylorModel::constant(1.0);
        for (row, sets) in self.levels.iter().enumerate() {
            let entries = &matrix[row * columns..(row + 1) * columns];
            for &set in sets {
                let table = &self.table;
                // Members from the highest down: the last column has sign +.
                let members = (0..columns).rev().filter(|c| set >> c & 1 == 1);
                let terms = members.enumerate().filter_map(|(i, c)| {
                    let minor = &table[set & !(1 << c)];
                    let is_zero = entries[c].is_zero() || minor.is_zero();
                    (!is_zero).then_some((if i % 2 == 0 { 1.0 } else { -1.0 }, &entries[c], minor))
                });
                self.table[set] = TaylorModel::sum_of_products(terms);
            }
        }
    }

    /// The determinant over a set of columns.
    pub fn det(&self, set: usize) -> &TaylorModel {
        &self.table[set]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn determinants_over_chosen_columns() {
        let values = [
            2.0, -1.0, 0.0, 0.5, 3.0, 1.0, 4.0, -2.0, 0.3, 0.0, 0.7, 1.1, -0.4, 2.2, 5.0, 0.9, 0.2,
            0.1, 0.6, -1.0,
        ];
        let entries: Vec<TaylorModel> = values.iter().map(|&x| TaylorModel::constant(x)).collect();
        let matrix = DMatrix::from_row_slice(4, 5, &values);
        let wanted = [0b0_1111, 0b1_0111, 0b1_1011];
        let mut minors = Minors::new(5, 4, &wanted);
        minors.compute(&entries);
        for set in wanted {
            let columns: Vec<usize> = (0..5).filter(|c| set >> c & 1 == 1).collect();
            let expected = matrix.select_columns(&columns).determinant();
            assert!(
                (minors.det(set).at_origin() - expected).abs() < 1e-13,
                "{set:b}"
            );
        }
    }
}

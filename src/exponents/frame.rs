//! An orthonormal frame of deviations that is carried along a motion, and how its columns grow.

use crate::tolerance::{COLLAPSED_DIRECTION, TANGENT_DIGITS_LOST};
use nalgebra::{DMatrix, DVector};

/// Lengths whose squares neither overflow nor underflow, nor do sums of them. [exact]
const SQUARABLE_LENGTHS: std::ops::Range<f64> = 1e-140..1e140;

/// Products of lengths are kept within these, so that few logarithms are taken. [work]
const UNLOGGED_GROWTH: std::ops::Range<f64> = 1e-100..1e100;

/// Deviations from a motion, one a column, each the one that an exponent belongs to; those that contact has taken away are gone.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// The directions, orthonormal after each impact and each piece of a flight, shape (2n, k), [m, m/s], or in modal coordinates where the
    /// motion is followed in them.
    pub columns: DMatrix<f64>,
    /// The exponent of each column.
    owner: Vec<usize>,
    /// How much the direction of each exponent has grown: a logarithm, minus infinity where it is gone, and a factor beside it.
    growth: Vec<(f64, f64)>,
}

impl Frame {
    /// The first k directions of so many dimensions.
    pub fn new(dimensions: usize, k: usize) -> Self {
        Self {
            columns: DMatrix::identity(dimensions, k),
            owner: (0..k).collect(),
            growth: vec![(0.0, 1.0); k],
        }
    }

    /// Logarithms of how much the direction of each exponent has grown: minus infinity where it is gone.
    pub fn growth(&self) -> Vec<f64> {
        let each = self.growth.iter();
        each.map(|(log, factor)| log + factor.ln()).collect()
    }

    /// Whether nothing is left that could grow.
    pub fn is_empty(&self) -> bool {
        self.owner.is_empty()
    }

    /// Counts growth from here on, of all directions: those that are gone are given back, at right angles to those that are left.
    pub fn begin_anew(&mut self) {
        let dimensions = self.columns.nrows();
        let k = self.growth.len();
        let mut all: Vec<_> = self
            .columns
            .column_iter()
            .map(nalgebra::Matrix::into_owned)
            .collect();
        while all.len() < k
            && let Some(own) = beside(&all, dimensions)
        {
            all.push(own);
        }
        self.columns = DMatrix::from_columns(&all);
        self.owner = (0..k).collect();
        self.growth = vec![(0.0, 1.0); k];
    }

    /// Makes the columns orthonormal again, in their order, and takes note of how they have grown. The ratio of the most to the least, up
    /// to which digits are lost.
    pub fn orthonormalise(&mut self) -> f64 {
        let (mut most, mut least) = (0.0f64, f64::INFINITY);
        for j in 0..self.owner.len() {
            let length = self.straightened(j);
            self.grow(j, length);
            (most, least) = (most.max(length), least.min(length));
        }
        most / least
    }

    /// The same after a map whose determinant has a known logarithm: in a frame of all directions it gives the growth of the last one where
    /// that has lost its digits to the others.
    pub fn orthonormalise_of(&mut self, log_determinant: f64) {
        let last = self.owner.len() - 1;
        if last + 1 < self.columns.nrows() {
            self.orthonormalise();
            return;
        }
        let size = self.columns.amax();
        let mut grown = 0.0;
        for j in 0..last {
            let length = self.straightened(j);
            grown += length.ln();
            self.grow(j, length);
        }
        let length = self.straightened(last);
        if length > TANGENT_DIGITS_LOST * size {
            self.grow(last, length);
            return;
        }
        let others = self.columns.columns(0, last);
        let others: Vec<_> = (others.column_iter())
            .map(nalgebra::Matrix::into_owned)
            .collect();
        if let Some(own) = beside(&others, self.columns.nrows()) {
            self.columns.set_column(last, &own);
        }
        self.growth[self.owner[last]].0 += log_determinant - grown;
    }

    /// The same after a contact that leaves `left` directions at most: the others are taken away.
    pub fn collapse(&mut self, left: usize) {
        let gone = beyond(&self.columns, left);
        self.collapse_without(&gone);
    }

    /// The same where it is known which are, the last one first.
    pub fn collapse_without(&mut self, gone: &[usize]) {
        let sizes = self.columns.column_iter().map(|c| c.norm());
        let size = sizes.fold(0.0, f64::max);
        for &j in gone {
            self.take_away(j);
        }
        let mut j = 0;
        while j < self.owner.len() {
            let length = self.straightened(j);
            if length > COLLAPSED_DIRECTION * size {
                self.grow(j, length);
                j += 1;
            } else {
                self.take_away(j);
            }
        }
    }

    /// Takes column j away.
    fn take_away(&mut self, j: usize) {
        let columns = std::mem::take(&mut self.columns);
        self.columns = columns.remove_column(j);
        self.growth[self.owner.remove(j)] = (f64::NEG_INFINITY, 1.0);
    }

    /// Makes column j, of a length, one of length one.
    fn grow(&mut self, j: usize, length: f64) {
        self.columns.column_mut(j).unscale_mut(length);
        let (log, factor) = &mut self.growth[self.owner[j]];
        *factor *= length;
        if !UNLOGGED_GROWTH.contains(factor) {
            *log += factor.ln();
            *factor = 1.0;
        }
    }

    /// Takes what column j has of those before it away, and gives its length.
    fn straightened(&mut self, j: usize) -> f64 {
        straightened(&mut self.columns, j)
    }
}

/// Takes what column j of some has of those before it away, which are orthonormal, and gives its length.
fn straightened(columns: &mut DMatrix<f64>, j: usize) -> f64 {
    let (before, mut rest) = columns.columns_range_pair_mut(..j, j..);
    let mut column = rest.column_mut(0);
    // Twice is enough.
    for _ in 0..if j > 0 { 2 } else { 0 } {
        for other in before.column_iter() {
            let part = column.dot(&other);
            column.axpy(-part, &other, 1.0);
        }
    }
    // Squares of what is this small or large have no room.
    match column.amax() {
        size if size == 0.0 || SQUARABLE_LENGTHS.contains(&size) => column.norm(),
        size => size * (column / size).norm(),
    }
}

/// The columns beyond so many, the last one first: those of which the others leave least, which is the rounding of a contact.
pub(crate) fn beyond(columns: &DMatrix<f64>, left: usize) -> Vec<usize> {
    let count = columns.ncols();
    if count <= left {
        return Vec::new();
    }
    let mut own = columns.clone();
    let mut lengths = Vec::with_capacity(count);
    for j in 0..count {
        let length = straightened(&mut own, j);
        if length > 0.0 {
            own.column_mut(j).unscale_mut(length);
        }
        lengths.push(length);
    }
    let mut order: Vec<usize> = (0..count).rev().collect();
    order.sort_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
    order.truncate(count - left);
    order.sort_unstable_by(|a, b| b.cmp(a));
    order
}

/// A direction at right angles to others.
fn beside(others: &[DVector<f64>], dimensions: usize) -> Option<DVector<f64>> {
    let mut units = (0..dimensions).map(|i| {
        let mut unit = DVector::zeros(dimensions);
        unit[i] = 1.0;
        for _ in 0..2 {
            for known in others {
                unit -= known * known.dot(&unit);
            }
        }
        unit
    });
    // One of the unit vectors is at least this far from the span of fewer directions.
    let own = units.find(|unit| unit.norm() > 0.5 / (dimensions as f64).sqrt())?;
    Some(own.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn growth_is_that_of_areas() {
        let mut frame = Frame::new(3, 3);
        let map = dmatrix![2.0, 1.0, 0.0; 0.0, 0.5, 3.0; 1.0, 0.0, 0.1];
        for _ in 0..5 {
            frame.columns = &map * &frame.columns;
            assert!(frame.orthonormalise() < 100.0);
            let gram = frame.columns.tr_mul(&frame.columns);
            assert!((gram - DMatrix::identity(3, 3)).amax() < 1e-15);
        }
        let whole: f64 = frame.growth().iter().sum();
        assert!((whole - 5.0 * map.determinant().abs().ln()).abs() < 1e-13);
    }

    #[test]
    fn what_is_gone_is_gone_until_it_is_given_back() {
        let mut frame = Frame::new(4, 3);
        frame.columns = DMatrix::from_fn(4, 3, |i, j| ((3 * i + 5 * j) as f64).sin());
        frame.columns.row_mut(1).fill(0.0);
        frame.columns.row_mut(3).fill(0.0);
        frame.collapse(2);
        assert_eq!(frame.columns.ncols(), 2);
        assert_eq!(frame.growth()[2], f64::NEG_INFINITY);
        assert!(frame.growth()[0].is_finite() && frame.growth()[1].is_finite());
        // By rank as by rule.
        let mut by_rank = Frame::new(4, 3);
        by_rank.columns = DMatrix::from_fn(4, 3, |i, j| ((3 * i + 5 * j) as f64).sin());
        by_rank.columns.row_mut(1).fill(0.0);
        by_rank.columns.row_mut(3).fill(0.0);
        by_rank.collapse(4);
        assert_eq!(by_rank.growth(), frame.growth());
        frame.begin_anew();
        let gram = frame.columns.tr_mul(&frame.columns);
        assert!((gram - DMatrix::identity(3, 3)).amax() < 1e-15);
        assert_eq!(frame.growth(), [0.0; 3]);
        frame.columns.fill(0.0);
        frame.collapse(4);
        assert!(frame.is_empty());
    }

    #[test]
    fn what_goes_is_the_rounding_of_a_contact() {
        // The first coordinate is held, and its columns are no more than what is left of large terms.
        let mut frame = Frame::new(3, 3);
        frame.columns = dmatrix![1e-9, 3e-10, 0.0; 2e-10, 1e-9, 0.0; 4e-10, 0.0, 0.5];
        frame.collapse(1);
        assert_eq!(frame.growth()[..2], [f64::NEG_INFINITY; 2]);
        assert!((frame.growth()[2] - 0.5f64.ln()).abs() < 1e-15);
    }

    #[test]
    fn a_determinant_tells_what_rounding_hides() {
        // An impact: `-e` on the diagonal beside one large entry, of determinant e^2.
        for restitution in [0.5, 1e-3, 1e-9, 1e-30, 1e-200] {
            let map = dmatrix![-restitution, 0.0; 3.0, -restitution];
            let mut frame = Frame::new(2, 2);
            let log = 2.0 * f64::ln(restitution);
            for _ in 0..3 {
                frame.columns = &map * &frame.columns;
                frame.orthonormalise_of(log);
                let gram = frame.columns.tr_mul(&frame.columns);
                assert!((gram - DMatrix::identity(2, 2)).amax() < 1e-14);
            }
            let whole: f64 = frame.growth().iter().sum();
            assert!(
                (whole - 3.0 * log).abs() < 1e-10 * log.abs(),
                "{restitution}: {whole}"
            );
        }
        // Of fewer directions it tells nothing.
        let mut frame = Frame::new(3, 2);
        frame.columns *= 2.0;
        frame.orthonormalise_of(-50.0);
        assert_eq!(frame.growth(), [2f64.ln(); 2]);
    }
}

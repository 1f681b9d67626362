//! How states (q, v), one a row, are held against each other: velocities over the frequency of the forcing are positions.

use nalgebra::DMatrix;

/// A difference of angles the shorter way round.
pub(crate) fn shorter(off: f64, turn: f64) -> f64 {
    off - turn * (off / turn).round()
}

/// The metric of states: the largest difference of a coordinate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Measure {
    /// For each position the turn after which it is the same, zero for those that are no angles.
    turns: Vec<f64>,
    frequency: f64,
}

impl Measure {
    /// The metric of positions, some of them angles, and of velocities divided by a frequency.
    pub fn new(turns: &[f64], frequency: f64) -> Self {
        let turns = turns.to_vec();
        Self { turns, frequency }
    }

    /// Whether a coordinate is an angle.
    pub fn is_angle(&self, k: usize) -> bool {
        self.turns.get(k).is_some_and(|turn| *turn > 0.0)
    }

    /// A difference of a coordinate, as one of positions; of angles the shorter way round.
    pub fn part(&self, k: usize, off: f64) -> f64 {
        match self.turns.get(k) {
            None => off / self.frequency,
            Some(0.0) => off,
            Some(&turn) => shorter(off, turn),
        }
    }

    /// How far two states are apart: the largest difference, infinite where there is none.
    pub fn distance(&self, (a, i): (&DMatrix<f64>, usize), (b, j): (&DMatrix<f64>, usize)) -> f64 {
        let each = (0..a.ncols()).map(|k| self.part(k, a[(i, k)] - b[(j, k)]).abs());
        each.fold(0.0, |most, off| {
            if off.is_nan() {
                f64::INFINITY
            } else {
                off.max(most)
            }
        })
    }

    /// The size of a motion: its largest coordinate.
    pub fn size(&self, states: &DMatrix<f64>) -> f64 {
        let columns = states.column_iter().enumerate();
        let parts =
            columns.flat_map(|(k, all)| all.into_iter().map(move |x| self.part(k, *x).abs()));
        parts.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;
    use std::f64::consts::TAU;

    #[test]
    fn angles_are_the_shorter_way_apart_and_velocities_are_over_the_frequency() {
        let states = dmatrix![3.0, 1.0, 0.0, 8.0; -3.0, 1.5, 2.0, 8.0; f64::NAN, 0.0, 0.0, 0.0];
        let own = Measure::new(&[TAU, 0.0], 4.0);
        let apart = |i, j| own.distance((&states, i), (&states, j));
        assert!((apart(0, 1) - 0.5).abs() < 1e-15);
        assert_eq!(apart(0, 2), f64::INFINITY);
        assert_eq!(own.size(&states.rows(0, 2).into_owned()), 3.0);
    }
}

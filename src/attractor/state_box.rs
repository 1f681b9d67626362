//! The box of states in which attractors are sought and whose widths are the unit of distances: a difference of states is divided by the
//! width of the box in each coordinate \[-\]. Bounds are (q, v) in units of the scene; positions may be angles, equal a turn apart.

use crate::error::{Error, Result};
use crate::quantity::finite_vector;
use crate::recurrence::shorter;
use nalgebra::{DMatrix, DVector};

/// A box of states (q, v). Positions may be angles, which are the same a turn on.
#[derive(Debug, Clone, PartialEq)]
pub struct StateBox {
    low: DVector<f64>,
    high: DVector<f64>,
    /// The widths by which distances are measured: where a coordinate has none, the largest of its kind.
    widths: DVector<f64>,
    /// The turn of each coordinate, zero for those that are no angles.
    turns: DVector<f64>,
}

impl StateBox {
    /// From the lowest to the highest of each position, then of each velocity; shape `(2n,)` each.
    ///
    /// # Errors
    /// Arrays that do not fit, are not finite or upside down; a box without width in every position, or in every velocity.
    pub fn new(low: DVector<f64>, high: DVector<f64>) -> Result<Self> {
        finite_vector("box", &high, low.len())?;
        finite_vector("box", &low, low.len())?;
        if let Some(i) = (0..low.len()).find(|&i| low[i] > high[i]) {
            let value = format!("({}, {}) in row {i}", low[i], high[i]);
            return Err(Error::bad_value(
                "box",
                value,
                "the first must be the lower one",
            ));
        }
        let n = low.len() / 2;
        let width = |i: usize| high[i] - low[i];
        let largest = |half: usize| (0..n).map(|i| width(half * n + i)).fold(0.0, f64::max);
        let widths = DVector::from_fn(2 * n, |i, _| {
            if width(i) > 0.0 {
                width(i)
            } else {
                largest(i / n)
            }
        });
        if widths.iter().any(|width| *width == 0.0) {
            let rule =
                "some position and some velocity must have a range: distances are measured by them";
            return Err(Error::bad_value("box", "without width", rule));
        }
        let turns = DVector::zeros(2 * n);
        Ok(Self {
            low,
            high,
            widths,
            turns,
        })
    }

    /// The same box with a position that is an angle: equal a turn, such as 2 pi, apart.
    ///
    /// # Errors
    /// A position that there is not; a turn that is not positive and finite.
    pub fn with_turn(mut self, position: usize, turn: f64) -> Result<Self> {
        let n = self.low.len() / 2;
        if position >= n {
            let rule = format!("there are {n} positions, counted from 0");
            return Err(Error::bad_value("wrap", position, rule));
        }
        if !(turn > 0.0 && turn.is_finite()) {
            let rule = "a turn must be positive and finite";
            return Err(Error::bad_value(format!("wrap[{position}]"), turn, rule));
        }
        self.turns[position] = turn;
        Ok(self)
    }

    /// Refuses a box of another number of degrees of freedom.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
        let shape = |sides: usize| format!("({sides}, 2)");
        if self.low.len() == 2 * n {
            return Ok(());
        }
        Err(Error::bad_shape("box", shape(self.low.len()), shape(2 * n)))
    }

    /// The turns of the positions, zero for those that are no angles.
    pub(crate) fn turns(&self) -> &[f64] {
        &self.turns.as_slice()[..self.turns.len() / 2]
    }

    /// States, one a row, with angles within a turn from the lowest on.
    pub(crate) fn within_turns(&self, mut states: DMatrix<f64>) -> DMatrix<f64> {
        for (i, &turn) in self
            .turns
            .iter()
            .enumerate()
            .filter(|(_, turn)| **turn > 0.0)
        {
            let low = self.low[i];
            states
                .column_mut(i)
                .apply(|x| *x = low + (*x - low).rem_euclid(turn));
        }
        states
    }

    /// Whether the first coordinate is an angle.
    pub(crate) fn begins_with_an_angle(&self) -> bool {
        self.turns.iter().next().is_some_and(|turn| *turn > 0.0)
    }

    /// Writes a state in parts of the box: from its lowest corner, each coordinate over its width \[-\].
    pub(crate) fn place<'a>(&self, state: impl Iterator<Item = &'a f64>, place: &mut Vec<f64>) {
        let part = |(i, x): (usize, &f64)| (x - self.low[i]) / self.widths[i];
        place.clear();
        place.extend(state.enumerate().map(part));
    }

    /// The distance of two states in parts of the box: the largest difference of a coordinate \[-\].
    pub(crate) fn apart(&self, a: &[f64], b: &[f64]) -> f64 {
        self.largest(a.iter().zip(b).map(|(x, y)| x - y))
    }

    /// The largest of differences in parts of the box, those of angles the shorter way round.
    fn largest(&self, differences: impl Iterator<Item = f64>) -> f64 {
        let sides = self.turns.iter().zip(&self.widths);
        let sizes = differences
            .zip(sides)
            .map(|(off, (turn, width))| match *turn {
                0.0 => off.abs(),
                turn => shorter(off, turn / width).abs(),
            });
        sizes.fold(0.0, f64::max)
    }

    /// How far outside the box a state is, in parts of it \[-\]; an angle is never outside.
    pub(crate) fn beyond<'a>(&self, state: impl Iterator<Item = &'a f64>) -> f64 {
        let beyond = |(i, x): (usize, &f64)| {
            let off = (self.low[i] - x).max(x - self.high[i]) / self.widths[i];
            match off {
                off if off.is_nan() => f64::INFINITY,
                _ if self.turns[i] > 0.0 => 0.0,
                off => off,
            }
        };
        state.enumerate().map(beyond).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};
    use std::f64::consts::{PI, TAU};

    fn around() -> StateBox {
        let made = StateBox::new(dvector![-PI, 0.0, -2.0, 1.0], dvector![PI, 0.5, 2.0, 1.0]);
        made.and_then(|made| made.with_turn(0, TAU)).expect("a box")
    }

    #[test]
    fn angles_are_the_shorter_way_apart() {
        let states = dmatrix![3.0, 0.1, 0.0, 1.0; -3.0, 0.1, 0.0, 1.0; 3.0, 0.3, 2.0, 3.0; 3.0 + 5.0 * TAU, 0.1, 0.0, 1.0];
        let own = around();
        let place = |i: usize| {
            let mut place = Vec::new();
            own.place(states.row(i).iter(), &mut place);
            place
        };
        let apart = |i: usize, j: usize| own.apart(&place(i), &place(j));
        assert!((apart(0, 1) - (TAU - 6.0) / TAU).abs() < 1e-15);
        assert!(apart(0, 3) < 1e-15);
        // Speeds in parts of the widest where their own side has no width: 2 of 4 each.
        assert!((apart(0, 2) - 0.5).abs() < 1e-15);
        let within = own.within_turns(states);
        assert!(within.column(0).iter().all(|x| (-PI..PI).contains(x)));
        assert_eq!(own.turns(), [TAU, 0.0]);
        assert!(own.begins_with_an_angle());
    }

    #[test]
    fn no_angle_is_far_away() {
        let own = around();
        let beyond = |state: [f64; 4]| own.beyond(state.iter());
        assert_eq!(beyond([1e9, 0.2, 1.0, 1.0]), 0.0);
        assert_eq!(beyond([0.0, 1.0, 1.0, 1.0]), 1.0);
        assert_eq!(beyond([0.0, 0.2, -6.0, 1.0]), 1.0);
        assert_eq!(beyond([f64::NAN, 0.2, 0.0, 1.0]), f64::INFINITY);
    }
}

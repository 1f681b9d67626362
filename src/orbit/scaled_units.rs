//! Units of a motion: its largest positions and velocities, with what its frequency makes of each of the other.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Units in which mismatches and corrections are measured.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScaledUnits {
    pub position: f64,
    pub velocity: f64,
    pub time: f64,
}

impl ScaledUnits {
    /// Those of a motion that goes through some states in a period.
    pub fn of<'a>(states: impl Iterator<Item = &'a DVector<f64>> + Clone, period: f64) -> Self {
        Self::no_less([0.0; 2], states, period)
    }

    /// The same, of positions and velocities no less than some.
    pub fn no_less<'a>(
        least: [f64; 2],
        states: impl Iterator<Item = &'a DVector<f64>> + Clone,
        period: f64,
    ) -> Self {
        let time = period / TAU;
        let largest = largest_of(states);
        let [position, velocity] = [0, 1].map(|half| least[half].max(largest[half]));
        let or_one = |x: f64| if x > 0.0 { x } else { 1.0 };
        let position = or_one(position.max(velocity * time));
        Self {
            position,
            velocity: or_one(velocity.max(position / time)),
            time,
        }
    }

    /// The smaller of both: of what is integrated to a tolerance, absolute parts are of it.
    pub fn smaller(&self) -> f64 {
        self.position.min(self.velocity)
    }

    /// A Jacobian of states in them.
    pub fn scaled(&self, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        let n = jacobian.nrows() / 2;
        let unit = |i: usize| if i < n { self.position } else { self.velocity };
        DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| {
            jacobian[(i, j)] * unit(j) / unit(i)
        })
    }
}

/// The largest position and the largest velocity of some states.
pub(crate) fn largest_of<'a>(states: impl Iterator<Item = &'a DVector<f64>> + Clone) -> [f64; 2] {
    [0, 1].map(|half| {
        let sizes = states.clone().map(|x| {
            let n = x.len() / 2;
            x.rows(half * n, n).amax()
        });
        sizes.fold(0.0, f64::max)
    })
}

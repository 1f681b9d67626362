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

/// Those of a motion of which nothing is known.
impl Default for ScaledUnits {
    fn default() -> Self {
        Self {
            position: 1.0,
            velocity: 1.0,
            time: 1.0,
        }
    }
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
        let position = or_one(position.max(velocity * time));
        Self {
            position,
            velocity: or_one(velocity.max(position / time)),
            time,
        }
    }

    /// Those of one state with its rate, of which nothing is known beside: the time is that in which its speed changes.
    pub fn of_state(state: &DVector<f64>, rate: &DVector<f64>) -> Self {
        let [position, velocity] = largest_of(std::iter::once(state));
        let [_, acceleration] = largest_of(std::iter::once(rate));
        let time = or_one(velocity / acceleration);
        Self {
            position: or_one(position.max(velocity * time)),
            velocity: or_one(velocity),
            time,
        }
    }

    /// How large a deviation of a state and of its time is in them; what is no number is beyond all.
    pub fn size_of<'a>(&self, deviation: impl IntoIterator<Item = &'a f64>, delay: f64) -> f64 {
        let mut all = deviation.into_iter();
        let n = all.size_hint().0 / 2;
        let size = |x: f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
        let largest =
            |half: &mut dyn Iterator<Item = &'a f64>| half.fold(0.0f64, |m, x| m.max(size(*x)));
        let position = largest(&mut all.by_ref().take(n));
        let velocity = largest(&mut all);
        let each = [
            position / self.position,
            velocity / self.velocity,
            size(delay) / self.time,
        ];
        each.into_iter().fold(0.0, f64::max)
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

/// A positive number, or one.
fn or_one(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() { x } else { 1.0 }
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

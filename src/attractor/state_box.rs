//! A box of states, in which attractors are sought and by which distances are measured.

use crate::error::{Error, Result};
use crate::quantity::finite_vector;
use nalgebra::DVector;

/// A box of states (q, v).
#[derive(Debug, Clone, PartialEq)]
pub struct StateBox {
    pub(crate) low: DVector<f64>,
    pub(crate) high: DVector<f64>,
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
        let made = Self { low, high };
        if made.widths().iter().any(|width| *width == 0.0) {
            let rule =
                "some position and some velocity must have a range: distances are measured by them";
            return Err(Error::bad_value("box", "without width", rule));
        }
        Ok(made)
    }

    /// Refuses a box of another number of degrees of freedom.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
        let shape = |sides: usize| format!("({sides}, 2)");
        if self.low.len() == 2 * n {
            return Ok(());
        }
        Err(Error::bad_shape("box", shape(self.low.len()), shape(2 * n)))
    }

    /// The widths by which distances are measured: where a coordinate has none, the largest of its kind.
    pub(crate) fn widths(&self) -> DVector<f64> {
        let n = self.low.len() / 2;
        let width = |i: usize| self.high[i] - self.low[i];
        let largest = |half: usize| (0..n).map(|i| width(half * n + i)).fold(0.0, f64::max);
        DVector::from_fn(2 * n, |i, _| {
            if width(i) > 0.0 {
                width(i)
            } else {
                largest(i / n)
            }
        })
    }
}

//! A direction in the scaled unknowns of a curve (theory 20).

use crate::continuation::ScaledDirection;
use nalgebra::{DVector, Vector2};

/// A direction in the unknowns of a loop, in units of its motion, and in both numbers, in parts of their ranges; shape
/// `(n_unknowns + 2,)`, \[-\].
#[derive(Debug, Clone)]
pub(super) struct CurveDirection(pub DVector<f64>);

impl CurveDirection {
    /// The part in both numbers \[-\].
    pub fn numbers(&self) -> Vector2<f64> {
        let last = self.0.len() - 1;
        Vector2::new(self.0[last - 1], self.0[last])
    }
}

impl ScaledDirection for CurveDirection {
    fn of(components: &DVector<f64>) -> Self {
        Self(components.clone())
    }

    /// The mean over the unknowns of the loop, plus the product of the parts in both numbers.
    fn dot(&self, other: &Self) -> f64 {
        self.row().dot(&other.0)
    }

    fn row(&self) -> DVector<f64> {
        let count = self.0.len() - 2;
        let mut row = self.0.clone();
        row.rows_mut(0, count).unscale_mut(count as f64);
        row
    }

    fn scaled(&self, factor: f64) -> Self {
        Self(&self.0 * factor)
    }

    fn plus(&self, other: &Self) -> Self {
        Self(&self.0 + &other.0)
    }

    fn unit(&self) -> Self {
        Self(&self.0 / self.length())
    }
}

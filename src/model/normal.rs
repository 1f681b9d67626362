//! Directions of coordinates: normals of stops, directions of loads.

use crate::error::{Error, Result};
use crate::quantity::finite_vector;
use nalgebra::DVector;

/// The normal of a stop, or another direction: one coordinate, or a vector of any length.
#[derive(Debug, Clone, PartialEq)]
pub enum Normal {
    /// The unit vector of one coordinate, counted from 0.
    Coordinate(usize),
    /// Any vector, shape `(n,)`; that of a stop is not zero.
    Vector(DVector<f64>),
}

impl From<usize> for Normal {
    fn from(index: usize) -> Self {
        Self::Coordinate(index)
    }
}

impl From<DVector<f64>> for Normal {
    fn from(normal: DVector<f64>) -> Self {
        Self::Vector(normal)
    }
}

impl Normal {
    /// The vector of n entries.
    ///
    /// # Errors
    /// A coordinate that the system does not have, or a vector of another length or with entries that are not finite, by the name
    /// of the argument.
    pub(crate) fn vector(&self, n: usize, argument: &str) -> Result<DVector<f64>> {
        match self {
            Self::Coordinate(i) if *i < n => {
                Ok(DVector::from_fn(n, |row, _| f64::from(u8::from(row == *i))))
            }
            Self::Coordinate(i) => Err(Error::bad_value(
                argument,
                i,
                format!("the system has coordinates 0 to {}", n - 1),
            )),
            Self::Vector(v) => {
                finite_vector(argument, v, n)?;
                Ok(v.clone())
            }
        }
    }
}

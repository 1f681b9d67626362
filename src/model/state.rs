//! The state of a motion in the coordinates of its system.

use nalgebra::DVector;

/// Position and velocity, shape `(n,)` each.
pub(crate) type PhysicalState = (DVector<f64>, DVector<f64>);

//! A force along a direction that follows a signal.

use crate::error::Result;
use crate::model::normal::Normal;
use crate::model::signal::Signal;
use crate::quantity::finite_vector;
use nalgebra::DVector;

/// Force direction * signal(t) on the coordinates.
///
/// # Examples
/// ```
/// use nalgebra::dvector;
/// use vibroimpact::{Keep, LinearSystem, Load, Scene, Signal, SimulateOptions, Stop, simulate};
/// // A blow of one second on a mass at rest before a stop.
/// let blow = Signal::samples(&[0.0, 0.5, 1.0], &[0.0, 3.0, 0.0])?;
/// let system = LinearSystem::new(dvector![1.0], dvector![0.1], dvector![4.0])?;
/// let scene = Scene::new(system, Load::new(0, blow)?, [Stop::new(0, 0.2, 0.8)?])?;
/// let rest = dvector![0.0];
/// let run = simulate(&scene, &rest, &rest, (0.0, 10.0), &SimulateOptions::default())?;
/// assert!(!run.impacts().is_empty());
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    direction: Normal,
    pub(super) signal: Signal,
}

impl Load {
    /// A force along a direction: a coordinate, or a vector of shape `(n,)`.
    ///
    /// # Errors
    /// A direction that is not finite.
    pub fn new(direction: impl Into<Normal>, signal: Signal) -> Result<Self> {
        let direction = direction.into();
        if let Normal::Vector(d) = &direction {
            finite_vector("direction", d, d.len())?;
        }
        Ok(Self { direction, signal })
    }

    /// The direction as given.
    pub fn direction(&self) -> &Normal {
        &self.direction
    }

    /// The signal.
    pub fn signal(&self) -> &Signal {
        &self.signal
    }

    /// The direction as a vector of n entries.
    ///
    /// # Errors
    /// A coordinate that the system does not have, or a vector of another length.
    pub(crate) fn direction_vector(&self, n: usize) -> Result<DVector<f64>> {
        self.direction.vector(n, "forcing.direction")
    }
}

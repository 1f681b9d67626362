//! Places on a path, and components of the motion there.

use crate::error::{Error, Result};
use crate::model::{Normal, PhysicalState, Scene};
use crate::path::parts::PathPoint;
use crate::path::path::Path;
use nalgebra::DVector;

/// A state, and where on the path it is.
pub(crate) struct Located {
    pub point: PathPoint,
    pub state: PhysicalState,
}

impl Path {
    /// A point with the state there.
    pub fn locate(&self, point: PathPoint) -> Located {
        let state = self.state_in(point.arc, point.local);
        Located { point, state }
    }

    /// The end of the motion.
    pub fn end(&self) -> PathPoint {
        self.end_of(self.parts.arcs.len() - 1, self.span.1)
    }
}

/// A component of a motion: `n.q`, `n.v` or `n.a`.
pub(crate) struct Component {
    direction: DVector<f64>,
    derivative: usize,
}

impl Component {
    /// Along a direction of n coordinates: of the position, or of its first or second derivative.
    ///
    /// # Errors
    /// A coordinate that the motion does not have, a vector of another length or not finite, another derivative.
    pub fn new(direction: &Normal, derivative: usize, n: usize) -> Result<Self> {
        if derivative > 2 {
            let rule = "it must be 0 (position), 1 (velocity) or 2 (acceleration)";
            return Err(Error::bad_value("derivative", derivative, rule));
        }
        let direction = direction.vector(n, "direction")?;
        Ok(Self {
            direction,
            derivative,
        })
    }

    /// The component of a position or velocity; `None` of an acceleration, which a state does not have.
    pub fn of_state(&self, (q, v): &PhysicalState) -> Option<f64> {
        match self.derivative {
            0 => Some(self.direction.dot(q)),
            1 => Some(self.direction.dot(v)),
            _ => None,
        }
    }

    /// That of an acceleration.
    pub fn of(&self, acceleration: &DVector<f64>) -> f64 {
        self.direction.dot(acceleration)
    }
}

/// Refuses a stop that a scene does not have.
pub(crate) fn check_stop(scene: &Scene, stop: usize) -> Result<()> {
    let rule = match scene.stops().len() {
        count if stop < count => return Ok(()),
        0 => "the scene has no stops".to_owned(),
        count => format!("the scene has stops 0 to {}", count - 1),
    };
    Err(Error::bad_value("stop", stop, rule))
}

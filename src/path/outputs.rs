//! What is measured along a motion: components of position, velocity and acceleration, gaps, forces of stops in contact.

use crate::error::{Error, Result};
use crate::model::{Normal, PhysicalState, Scene};
use crate::observer::unless_broken_off;
use crate::path::equations::PathEquations;
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

    /// Points with the states there.
    pub fn located(&self, points: &[PathPoint]) -> impl Iterator<Item = Result<Located>> {
        points.iter().map(|&point| Ok(self.locate(point)))
    }

    /// The end of the motion.
    pub fn end(&self) -> PathPoint {
        self.end_of(self.parts.arcs.len() - 1, self.span.1)
    }
}

impl Located {
    /// The time and the position.
    pub fn position(self) -> (f64, DVector<f64>) {
        (self.point.time, self.state.0)
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

    /// Its values at some places of a path.
    ///
    /// # Errors
    /// Those of the places, and what the functions of a nonlinear scene report; `Error::Interrupted` where the caller's work is broken
    /// off.
    pub fn along(
        &self,
        (path, scene): (&Path, &Scene),
        places: impl Iterator<Item = Result<Located>>,
    ) -> Result<Vec<f64>> {
        let equations = (self.derivative == 2).then(|| PathEquations::new(path, scene));
        each(places, |Located { point, state }| match &equations {
            Some(equations) => Ok(self.direction.dot(&equations.acceleration(point, &state)?)),
            None => Ok(self.of_state(&state).unwrap_or_default()),
        })
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

/// The gap of a stop at some times and positions.
///
/// # Errors
/// Those of the positions, and what the gap function of a nonlinear stop reports; `Error::Interrupted` where the caller's work is
/// broken off.
pub(crate) fn gaps(
    scene: &Scene,
    stop: usize,
    positions: impl Iterator<Item = Result<(f64, DVector<f64>)>>,
) -> Result<Vec<f64>> {
    each(positions, |(t, q)| Ok(scene.gaps_at(&q, t)?[stop]))
}

/// The accelerations at some places of a path.
///
/// # Errors
/// As [`Component::along`].
pub(crate) fn accelerations(
    (path, scene): (&Path, &Scene),
    places: impl Iterator<Item = Result<Located>>,
) -> Result<Vec<DVector<f64>>> {
    let equations = PathEquations::new(path, scene);
    each(places, |Located { point, state }| {
        equations.acceleration(point, &state)
    })
}

/// The force of a stop in lasting contact at some places of a path.
///
/// # Errors
/// As [`Component::along`].
pub(crate) fn contact_forces(
    (path, scene): (&Path, &Scene),
    stop: usize,
    places: impl Iterator<Item = Result<Located>>,
) -> Result<Vec<f64>> {
    let equations = PathEquations::new(path, scene);
    each(places, |Located { point, state }| {
        equations.contact_force(stop, point, &state)
    })
}

/// What each of some things gives, while the caller's work goes on.
fn each<T, U>(
    things: impl Iterator<Item = Result<T>>,
    of: impl Fn(T) -> Result<U>,
) -> Result<Vec<U>> {
    let value = |thing| {
        unless_broken_off()?;
        of(thing?)
    };
    things.map(value).collect()
}

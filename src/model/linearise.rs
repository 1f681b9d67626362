//! The linear scene about the equilibrium q = 0: system, walls and base motion.

use crate::error::Result;
use crate::model::{Constraint, Scene, System};

/// The linear scene of small angles: linear system, walls as plane stops, the same forcing.
///
/// # Errors
/// A pendulum whose mass matrix is singular in double precision.
pub fn linearise(scene: &Scene) -> Result<Scene> {
    let system = match scene.system() {
        System::Linear(_) => return Ok(scene.clone()),
        System::DoublePendulum(s) => s.linearise()?,
        System::PendulumChain(s) => s.linearise()?,
    };
    let lengths = scene.system().link_lengths();
    let stops: Vec<Constraint> = scene
        .stops()
        .iter()
        .map(|constraint| match (constraint, &lengths) {
            (Constraint::Wall(wall), Some(lengths)) => {
                wall.linearise(lengths).map(Constraint::Stop)
            }
            (other, _) => Ok(other.clone()),
        })
        .collect::<Result<_>>()?;
    Scene::new(system, scene.forcing().clone(), stops)
}

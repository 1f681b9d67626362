//! The linear scene about the equilibrium q = 0: system, walls, nonlinear stops and base motion.

use crate::error::Result;
use crate::model::constraint::Constraint;
use crate::model::scene::Scene;
use crate::model::system::System;

/// The linear scene of small motions: linear system, walls and nonlinear stops as plane stops, the same forcing.
///
/// # Errors
/// A pendulum whose mass matrix is singular in double precision; what [`NonlinearSystem::linearise`] reports; a nonlinear
/// stop whose gap does not change with the coordinates at q = 0.
///
/// [`NonlinearSystem::linearise`]: crate::NonlinearSystem::linearise
pub fn linearise(scene: &Scene) -> Result<Scene> {
    let system = match scene.system() {
        System::Linear(s) => System::Linear(s.clone()),
        System::DoublePendulum(s) => s.linearise()?.into(),
        System::PendulumChain(s) => s.linearise()?.into(),
        System::Nonlinear(s) => s.linearise()?.into(),
    };
    let lengths = scene.system().link_lengths();
    let stops: Vec<Constraint> = scene
        .stops()
        .iter()
        .map(|constraint| match (constraint, &lengths) {
            (Constraint::Wall(wall), Some(lengths)) => {
                wall.linearise(lengths).map(Constraint::Stop)
            }
            (Constraint::Nonlinear(stop), _) => stop.linearise(scene.n_dof()).map(Constraint::Stop),
            (other, _) => Ok(other.clone()),
        })
        .collect::<Result<_>>()?;
    Scene::new(system, scene.forcing().clone(), stops)
}

//! The motion of whatever a scene's system is.

use crate::error::Result;
use crate::model::dynamics::{ChainMotion, DoublePendulumMotion, NonlinearMotion};
use crate::model::linear_motion::{Diagonals, Full, LinearMotion};
use crate::model::{Driven, Dynamics, Moment, Scene, System, Undriven};

/// The motion of a scene's system. Steps have code of their own for each; who asks seldom takes it as one.
#[derive(Debug, Clone)]
pub(crate) enum SceneMotion {
    Linear(LinearMotion<Full, Undriven>),
    DrivenLinear(LinearMotion<Full, Driven>),
    Diagonal(LinearMotion<Diagonals, Undriven>),
    DrivenDiagonal(LinearMotion<Diagonals, Driven>),
    DoublePendulum(DoublePendulumMotion<Undriven>),
    DrivenDoublePendulum(DoublePendulumMotion<Driven>),
    Chain(ChainMotion),
    Nonlinear(NonlinearMotion),
}

impl SceneMotion {
    /// The motion of a scene.
    pub fn new(scene: &Scene) -> Self {
        let forcing = scene.forcing();
        match scene.system() {
            System::Linear(system) => {
                match (Diagonals::of(system), Driven::over_mass(system, forcing)) {
                    (Some(diagonals), None) => {
                        Self::Diagonal(LinearMotion::new(diagonals, Undriven))
                    }
                    (Some(diagonals), Some(input)) => {
                        Self::DrivenDiagonal(LinearMotion::new(diagonals, input))
                    }
                    (None, None) => Self::Linear(LinearMotion::new(Full::new(system), Undriven)),
                    (None, Some(input)) => {
                        Self::DrivenLinear(LinearMotion::new(Full::new(system), input))
                    }
                }
            }
            System::DoublePendulum(system) => match Driven::new(forcing) {
                None => Self::DoublePendulum(DoublePendulumMotion::new(system, Undriven)),
                Some(input) => Self::DrivenDoublePendulum(DoublePendulumMotion::new(system, input)),
            },
            System::PendulumChain(system) => Self::Chain(ChainMotion::new(system, forcing)),
            System::Nonlinear(system) => Self::Nonlinear(NonlinearMotion::new(system, forcing)),
        }
    }
}

/// Runs a block of code with the motion of a scene, whatever its type.
macro_rules! with_motion {
    ($scene_motion:expr, $motion:ident => $body:expr) => {
        match $scene_motion {
            SceneMotion::Linear($motion) => $body,
            SceneMotion::DrivenLinear($motion) => $body,
            SceneMotion::Diagonal($motion) => $body,
            SceneMotion::DrivenDiagonal($motion) => $body,
            SceneMotion::DoublePendulum($motion) => $body,
            SceneMotion::DrivenDoublePendulum($motion) => $body,
            SceneMotion::Chain($motion) => $body,
            SceneMotion::Nonlinear($motion) => $body,
        }
    };
}

impl Dynamics for SceneMotion {
    fn n_dof(&self) -> usize {
        with_motion!(self, motion => motion.n_dof())
    }

    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        with_motion!(self, motion => motion.acceleration(at, q, v, a))
    }
}

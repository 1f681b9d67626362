//! The motion of whatever a scene's system is.

use crate::error::Result;
use crate::model::dynamics::{ChainMotion, DoublePendulumMotion, Dynamics, NonlinearMotion};
use crate::model::input::Driven;
use crate::model::linear_motion::LinearMotion;
use crate::model::moment::Moment;
use crate::model::parameter::Parameter;
use crate::model::ramp::SteadyRamp;
use crate::model::scene::Scene;
use crate::model::system::System;
use nalgebra::{DMatrix, DVector};

/// The number of coordinates up to which the product with a full matrix is no slower than that with its diagonal. [work]
const LARGEST_FULL_MATRIX: usize = 2;

/// A linear motion with or without damping, driven or not.
type AnyLinear<O> = LinearMotion<O, Option<O>, Option<Driven>>;

/// The motion of a scene's system.
#[derive(Debug, Clone)]
pub(crate) enum SceneMotion {
    Full(AnyLinear<DMatrix<f64>>),
    Diagonal(AnyLinear<DVector<f64>>),
    DoublePendulum(DoublePendulumMotion<Option<Driven>>),
    Chain(ChainMotion),
    Nonlinear(NonlinearMotion),
    Fading(FadingDamping),
}

/// A motion whose damping drifts.
#[derive(Debug, Clone)]
pub(crate) struct FadingDamping {
    damped: Box<SceneMotion>,
    undamped: Box<SceneMotion>,
    factor: SteadyRamp,
}

impl SceneMotion {
    /// The motion of a scene.
    pub fn new(scene: &Scene) -> Self {
        if let Some(factor) = scene.drifting_damping() {
            let damped = scene.clone().with_laws(Vec::new(), None);
            let undamped = damped.replace(Parameter::DampingScale.change(0.0));
            let undamped = undamped.expect("the damping drifts by its factor");
            return Self::Fading(FadingDamping {
                damped: Box::new(Self::new(&damped)),
                undamped: Box::new(Self::new(&undamped)),
                factor,
            });
        }
        let excitation = scene.excitation();
        match scene.system() {
            System::Linear(system) => {
                let input = Driven::new(&excitation.over_mass(system));
                let diagonal = || LinearMotion::diagonal(system, input.clone());
                match (system.n_dof() > LARGEST_FULL_MATRIX)
                    .then(diagonal)
                    .flatten()
                {
                    Some(motion) => Self::Diagonal(motion),
                    None => Self::Full(LinearMotion::full(system, input)),
                }
            }
            System::DoublePendulum(system) => {
                let input = Driven::new(&excitation);
                Self::DoublePendulum(DoublePendulumMotion::new(system, input))
            }
            System::PendulumChain(system) => Self::Chain(ChainMotion::new(system, &excitation)),
            System::Nonlinear(system) => Self::Nonlinear(NonlinearMotion::new(system, &excitation)),
        }
    }
}

/// Runs a block of code with the motion of a scene, whatever its type.
macro_rules! with_motion {
    ($scene_motion:expr, $motion:ident => $body:expr) => {{
        match $scene_motion {
            SceneMotion::Full($motion) => $body,
            SceneMotion::Diagonal($motion) => $body,
            SceneMotion::DoublePendulum($motion) => $body,
            SceneMotion::Chain($motion) => $body,
            SceneMotion::Nonlinear($motion) => $body,
            SceneMotion::Fading($motion) => $body,
        }
    }};
}

/// The acceleration is linear in the damping.
impl Dynamics for FadingDamping {
    type Drive = Moment;

    fn n_dof(&self) -> usize {
        self.damped.n_dof()
    }

    fn drive(&self, at: Moment) -> Moment {
        at
    }

    fn driven(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let mut without = vec![0.0; a.len()];
        self.damped.acceleration(at, q, v, a)?;
        self.undamped.acceleration(at, q, v, &mut without)?;
        let factor = self.factor.value(at.time);
        for (a, without) in a.iter_mut().zip(without) {
            *a = without + factor * (*a - without);
        }
        Ok(())
    }
}

impl Dynamics for SceneMotion {
    type Drive = Moment;

    fn n_dof(&self) -> usize {
        with_motion!(self, motion => motion.n_dof())
    }

    fn drive(&self, at: Moment) -> Moment {
        at
    }

    #[allow(
        clippy::inline_always,
        reason = "a part of every stage, whose rate is a function of its own"
    )]
    #[inline(always)]
    fn driven(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        with_motion!(self, motion => motion.acceleration(at, q, v, a))
    }

    fn jacobian(&self, at: Moment, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        with_motion!(self, motion => motion.jacobian(at, q, v))
    }
}

//! The continuation parameter of a branch: a number of the scene, a value of which scenes are made, or the energy of the motion.

use crate::branch::continued::{continuation, continuation_of, continuation_over_energy};
use crate::branch::options::ContinuationOptions;
use crate::branch::result::Branch;
use crate::error::{Error, Result};
use crate::model::{Parameter, Scene};
use crate::orbit::PeriodicOrbit;

/// What varies along a branch.
#[derive(Clone, Copy)]
pub enum ContinuationParameter<'a> {
    /// A number of the scene. A factor counts from the scene of the orbit with which a branch begins.
    Number(Parameter),
    /// A value of which a function makes the scene.
    Scenes(&'a dyn Fn(f64) -> Result<Scene>),
    /// The energy of the motion, in one scene.
    Energy,
}

impl From<Parameter> for ContinuationParameter<'_> {
    fn from(parameter: Parameter) -> Self {
        Self::Number(parameter)
    }
}

impl<'a, F: Fn(f64) -> Result<Scene>> From<&'a F> for ContinuationParameter<'a> {
    fn from(make: &'a F) -> Self {
        Self::Scenes(make)
    }
}

impl ContinuationParameter<'_> {
    /// The scene of a value, from an orbit which is that of another.
    pub(super) fn scene(self, orbit: &PeriodicOrbit, start: f64, value: f64) -> Result<Scene> {
        match self {
            Self::Number(parameter) if parameter.is_factor() => {
                orbit.scene().with_value(parameter, value / start)
            }
            Self::Number(parameter) => orbit.scene().with_value(parameter, value),
            Self::Scenes(make) => make(value),
            Self::Energy => Ok(orbit.scene().clone()),
        }
    }

    /// Whether it may be a value that counts from another, none of which is zero.
    pub(super) fn is_factor(self) -> bool {
        matches!(self, Self::Number(parameter) if parameter.is_factor())
    }

    /// The branch of an orbit, which is that of a value; without one that of its own scene.
    pub(crate) fn continuation(
        self,
        (orbit, start): (&PeriodicOrbit, Option<f64>),
        between: (f64, f64),
        options: &ContinuationOptions,
    ) -> Result<Branch> {
        match (self, start) {
            (Self::Energy, _) => continuation_over_energy(orbit, between, options),
            (Self::Number(parameter), None) => continuation(orbit, parameter, between, options),
            (Self::Number(parameter), Some(_)) if !self.is_factor() => {
                continuation(orbit, parameter, between, options)
            }
            (_, Some(start)) => {
                let make = |value: f64| self.scene(orbit, start, value);
                continuation_of(orbit, &make, start, between, options)
            }
            (Self::Scenes(_), None) => {
                let rule = "of scenes that are made of values it must be the value of the orbit";
                Err(Error::bad_value("start", "none", rule))
            }
        }
    }
}

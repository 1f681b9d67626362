//! What varies along branches and curves, as Python says it.

use crate::branch::ContinuationParameter;
use crate::error::{Error, Result};
use crate::model::{Parameter, Scene};
use crate::python::answered::called_here;
use crate::python::argument;
use crate::python::made::made;
use crate::python::named::amplitude_given;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Mutex;

/// What varies along a branch.
pub(crate) enum Varied<'a> {
    Number(Parameter),
    /// A factor on what an orbit has, which is that of a value; the amplitude of a base is one on that which the scene has.
    Factor(Parameter, f64),
    /// The energy of the motion, in one scene.
    Energy,
    Made(&'a Py<PyAny>, f64),
}

impl Varied<'_> {
    /// The value at the orbit, of what its scene does not say.
    pub fn start(&self) -> Option<f64> {
        match self {
            Self::Number(_) | Self::Energy => None,
            Self::Factor(_, start) | Self::Made(_, start) => Some(*start),
        }
    }

    /// Hands it to a function of the core.
    pub fn with<T>(
        &self,
        own: &Scene,
        raised: &Mutex<Option<PyErr>>,
        ask: impl FnOnce(ContinuationParameter<'_>) -> T,
    ) -> T {
        match self {
            Self::Number(parameter) | Self::Factor(parameter, _) => {
                ask(ContinuationParameter::Number(*parameter))
            }
            Self::Energy => ask(ContinuationParameter::Energy),
            Self::Made(..) => {
                let make = |value: f64| self.scene(own, value, raised);
                ask(ContinuationParameter::Scenes(&make))
            }
        }
    }

    /// The value in the scene of an orbit.
    pub fn start_in(&self, scene: &Scene) -> Result<f64> {
        match self {
            Self::Number(parameter) => scene.start_of(*parameter, "parameters"),
            Self::Energy => {
                let rule =
                    "each must be a number of the scene, which the energy of a motion is not";
                Err(Error::bad_value("parameters", "\"energy\"", rule))
            }
            Self::Factor(_, start) | Self::Made(_, start) => Ok(*start),
        }
    }

    /// The scene of a value, from that of the orbit.
    pub fn scene(&self, own: &Scene, value: f64, raised: &Mutex<Option<PyErr>>) -> Result<Scene> {
        match self {
            Self::Number(parameter) => own.with_value(*parameter, value),
            Self::Energy => Ok(own.clone()),
            Self::Factor(parameter, start) => own.with_value(*parameter, value / start),
            Self::Made(function, _) => made(function, (value,), raised),
        }
    }
}

pub(crate) fn varied<'a>(
    scene: &Scene,
    name: Option<&str>,
    make: Option<&'a Py<PyAny>>,
    start: Option<f64>,
) -> PyResult<Varied<'a>> {
    match (name, make, start) {
        (Some("energy"), ..) => Ok(Varied::Energy),
        (Some("amplitude"), ..) => {
            let given = amplitude_given("parameter", scene)?;
            Ok(Varied::Factor(Parameter::ForcingScale, given))
        }
        (Some(name), _, start) => name.parse().map(|parameter| match start {
            Some(start) if Parameter::is_factor(parameter) => Varied::Factor(parameter, start),
            _ => Varied::Number(parameter),
        }).map_err(|_| {
            let names = argument::NUMBERS;
            PyValueError::new_err(format!(
                "parameter is {name:?}{}, but it must be a number of Scene.replace ({names}), \"energy\" or a callable p -> Scene",
                called_here(name)
            ))
        }),
        (None, Some(make), Some(start)) => Ok(Varied::Made(make, start)),
        (None, ..) => Err(PyValueError::new_err(
            "start is None, but with a callable it must be the value of p at the orbit",
        )),
    }
}

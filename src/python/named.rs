//! Numbers of scenes by the names that Python has for them.

use crate::model::{BaseMotion, Forcing, Parameter, Scene};
use crate::python::answered::called_here;
use crate::python::argument::NUMBERS;
use crate::python::text::shown;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;

/// A number of a scene by its name, and what one of it is in the unit that the scene counts in.
pub(super) struct Named {
    pub parameter: Parameter,
    pub unit: f64,
}

/// A number by its name.
pub(super) fn named(argument: &str, scene: &Scene, name: &str) -> PyResult<Named> {
    if name == "amplitude" {
        let unit = 1.0 / amplitude_given(argument, scene)?;
        let parameter = Parameter::ForcingScale;
        return Ok(Named { parameter, unit });
    }
    let parameter = name.parse().map_err(|_| {
        PyValueError::new_err(format!(
            "{argument} has {name:?}{}, but each must be a number of Scene.replace ({NUMBERS})",
            called_here(name)
        ))
    })?;
    Ok(Named {
        parameter,
        unit: 1.0,
    })
}

/// The names of a list, or one alone.
pub(super) fn names(
    argument: &str,
    parameters: &Bound<'_, PyAny>,
    needed: &str,
) -> PyResult<Vec<String>> {
    if parameters.is_instance_of::<PyString>() {
        return Ok(vec![parameters.extract()?]);
    }
    let names: Vec<String> = parameters.extract().map_err(|_| {
        let found = shown(parameters);
        PyTypeError::new_err(format!("{argument} is {found}, but {needed} are needed"))
    })?;
    let is_twice = |(k, name): (usize, &String)| names[..k].contains(name);
    if names.is_empty() || names.iter().enumerate().any(is_twice) {
        let found = shown(parameters);
        let rule = "but one name at least is needed, and each once";
        return Err(PyValueError::new_err(format!(
            "{argument} is {found}, {rule}"
        )));
    }
    Ok(names)
}

/// The amplitude of a base motion that is one real number.
fn single(base: &BaseMotion) -> Option<f64> {
    match base.amplitudes() {
        [one] if one[0].im == 0.0 => Some(one[0].re),
        _ => None,
    }
}

/// The amplitude of the one motion of the base that a scene has.
pub(super) fn amplitude_given(argument: &str, scene: &Scene) -> PyResult<f64> {
    match scene.forcing() {
        Forcing::BaseMotion(base) if single(base).is_some_and(|a| a != 0.0) => {
            Ok(single(base).unwrap_or_default())
        }
        forcing => {
            let reason = match forcing {
                Forcing::BaseMotion(base) if single(base).is_some() => {
                    "the scene's is zero, of which others are no multiple"
                }
                Forcing::BaseMotion(_) => {
                    "that of the base is several numbers, and only one is varied"
                }
                Forcing::Harmonic(_) => {
                    "that of a Harmonic is an array, and only numbers are varied"
                }
                Forcing::Fourier(_) => {
                    "that of a Fourier is several arrays, and only numbers are varied"
                }
                Forcing::Several(_) => "the scene has several forcings",
                Forcing::Load(_) | Forcing::BaseAcceleration(_) => "what follows a signal has none",
                Forcing::Unforced => "the scene has no forcing",
            };
            Err(PyValueError::new_err(format!(
                "{argument} is \"amplitude\", but {reason}; \"forcing_scale\" is a factor on the amplitude"
            )))
        }
    }
}

//! Objectives of optimisers in Python: a value of an orbit and its gradient at other numbers of its scene.

use crate::derivative::{self, Objective, ObjectiveValue, OrbitDerivatives, OrbitEntry};
use crate::error::Error;
use crate::orbit::PeriodicOrbit;
use crate::python::array::{number, vector};
use crate::python::derivative::{of_callable, out};
use crate::python::interrupt;
use crate::python::made::{NumberSlice, made, raised_or};
use crate::python::orbit::PyOrbit;
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Mutex;

/// The value at numbers, the gradient, and the orbit there, which is followed from that of others.
#[pyfunction]
pub(crate) fn _objective_at<'py>(
    py: Python<'py>,
    orbit: PyRef<'py, PyOrbit>,
    make: Py<PyAny>,
    value: &Bound<'py, PyAny>,
    start: &Bound<'py, PyAny>,
    p: &Bound<'py, PyAny>,
) -> PyResult<(f64, Bound<'py, PyArray1<f64>>, PyOrbit)> {
    let (from, to) = (vector("start", start)?, vector("p", p)?);
    let entry = match value.extract::<String>() {
        Ok(name) => Some(OrbitEntry::of(&name, &orbit.0)?),
        Err(_) => None,
    };
    let (value, raised) = (value.clone().unbind(), Mutex::new(None));
    let function = |orbit: &PeriodicOrbit, found: &OrbitDerivatives| {
        let asked = |py: Python<'_>| -> PyResult<(f64, Vec<f64>)> {
            let found = out(py, None, found.clone())?;
            let given = value.bind(py).call1((PyOrbit(orbit.clone()), found))?;
            let (value, gradient): (Bound<'_, PyAny>, Bound<'_, PyAny>) = given.extract()?;
            let gradient = vector("the gradient of value", &gradient)?;
            if gradient.len() != to.len() {
                let (found, wanted) = (gradient.len(), to.len());
                let message = format!(
                    "the gradient of value has shape ({found},), but ({wanted},) is needed"
                );
                return Err(PyValueError::new_err(message));
            }
            Ok((number("value", &value)?, gradient.as_slice().to_vec()))
        };
        Python::attach(asked).map_err(Error::function)
    };
    let own = &orbit.0;
    let found = interrupt::run(py, false, || {
        let mut objective = Objective {
            make: &|p: &[f64]| made(&make, (NumberSlice(p),), &raised),
            value: entry.map_or(ObjectiveValue::Function(&function), ObjectiveValue::Entry),
            orbit: own.clone(),
            p: from.as_slice().to_vec(),
        };
        let found = objective.at(to.as_slice())?;
        Ok((found, objective.orbit))
    });
    let ((value, gradient), orbit) = raised_or(found, raised)?;
    Ok((value, gradient.into_pyarray(py), PyOrbit(orbit)))
}

/// Refuses the name of an entry that an orbit has not.
#[pyfunction]
pub(crate) fn _check_entry(name: &str, orbit: PyRef<'_, PyOrbit>) -> PyResult<()> {
    OrbitEntry::of(name, &orbit.0)?;
    Ok(())
}

/// The derivatives of an orbit but those of its multipliers.
#[pyfunction]
pub(crate) fn _derivatives_but_multipliers<'py>(
    py: Python<'py>,
    orbit: PyRef<'py, PyOrbit>,
    make: &Bound<'py, PyAny>,
    start: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let derived = derivative::derivatives_but_multipliers;
    of_callable(py, &orbit.0, make, start, derived)
}

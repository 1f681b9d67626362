//! Scenes that a function of Python makes of numbers.

use crate::error::{Error, Result};
use crate::model::Scene;
use crate::python::model::PyScene;
use crate::python::text::shown;
use numpy::PyArray1;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::convert::Infallible;
use std::fmt;
use std::sync::Mutex;

/// Numbers that Python receives as an array.
#[derive(Clone, Copy)]
pub(crate) struct NumberSlice<'a>(pub &'a [f64]);

impl<'py> IntoPyObject<'py> for NumberSlice<'_> {
    type Target = PyArray1<f64>;
    type Output = Bound<'py, PyArray1<f64>>;
    type Error = Infallible;

    fn into_pyobject(self, py: Python<'py>) -> std::result::Result<Self::Output, Infallible> {
        Ok(PyArray1::from_slice(py, self.0))
    }
}

impl fmt::Debug for NumberSlice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.0, f)
    }
}

/// The scene that a function makes of values: those that it refuses by a `ValueError` are outside its domain; any other exception is kept, and
/// breaks off.
pub(crate) fn made<V>(make: &Py<PyAny>, values: V, raised: &Mutex<Option<PyErr>>) -> Result<Scene>
where
    V: for<'py> PyCallArgs<'py> + fmt::Debug + Copy,
{
    Python::attach(|py| {
        let given = format!("{values:?}");
        let given = given.trim_matches(['(', ')', ',']);
        let found = make.bind(py).call1(values).and_then(|scene| {
            let found = scene.extract::<PyRef<'_, PyScene>>();
            found.map(|scene| scene.0.clone()).map_err(|_| {
                let found = shown(&scene);
                PyTypeError::new_err(format!(
                    "parameter({given}) is {found}, but a Scene is needed"
                ))
            })
        });
        found.map_err(|error| {
            if error.is_instance_of::<PyValueError>(py) {
                return Error::bad_value("p", given, error.value(py).to_string());
            }
            if let Ok(mut raised) = raised.lock() {
                *raised = Some(error);
            }
            Error::Interrupted
        })
    })
}

/// What comes of some work with such a function: its exception, if it broke off.
pub(crate) fn raised_or<T>(found: PyResult<T>, raised: Mutex<Option<PyErr>>) -> PyResult<T> {
    match raised.into_inner().ok().flatten() {
        Some(raised) => Err(raised),
        None => found,
    }
}

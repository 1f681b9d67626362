//! Arguments of a fixed type. `PyO3` names one of a wrong type in a note beside the message; here the message names it.

use crate::python::text::shown;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;

/// The numbers of a scene, as `Scene.replace` has them.
pub(crate) const NUMBERS: &str = "frequency, amplitude, clearance, clearance[0], restitution, restitution[0], forcing_scale or damping_scale";

/// A type of arguments, as a message calls it.
pub(crate) trait ArgumentKind {
    const KIND: &'static str;
}

macro_rules! kinds {
    ($($type:ty: $kind:literal,)*) => {$(
        impl ArgumentKind for $type {
            const KIND: &'static str = $kind;
        }
    )*};
}

kinds! {
    f64: "a number",
    i64: "a whole number",
    bool: "True or False",
    &str: "a str",
    String: "a str",
    (f64, f64): "a pair of numbers",
    (f64, f64, f64): "three numbers",
}

impl<T: ArgumentKind> ArgumentKind for Option<T> {
    const KIND: &'static str = T::KIND;
}

/// The value of an argument: `TypeError` where its type is wrong, `ValueError` where it is a number that has no double.
pub(crate) fn given<'a, 'py, T>(argument: &str, value: &'a Bound<'py, PyAny>) -> PyResult<T>
where
    T: FromPyObject<'a, 'py> + ArgumentKind,
{
    let message = || format!("{argument} is {}, but {} is needed", shown(value), T::KIND);
    // To Python a truth value is a number.
    if value.is_instance_of::<PyBool>() && T::KIND != bool::KIND {
        return Err(PyTypeError::new_err(message()));
    }
    value.extract().map_err(|error: T::Error| {
        let (py, error): (_, PyErr) = (value.py(), error.into());
        if error.is_instance_of::<PyTypeError>(py) {
            PyTypeError::new_err(message())
        } else if error.is_instance_of::<PyOverflowError>(py) {
            PyValueError::new_err(format!("{} of a size that a machine holds", message()))
        } else {
            error
        }
    })
}

/// A part of a saved object; one of a wrong type or size is refused by its name.
pub(crate) fn saved<'a, 'py, T>(part: &str, value: &'a Bound<'py, PyAny>) -> PyResult<T>
where
    T: FromPyObject<'a, 'py>,
{
    value.extract().map_err(|error: T::Error| {
        let (py, error): (_, PyErr) = (value.py(), error.into());
        let message = format!("{part} of the saved object: {}", error.value(py));
        if error.is_instance_of::<PyTypeError>(py) {
            PyTypeError::new_err(message)
        } else {
            PyValueError::new_err(message)
        }
    })
}

/// For each name the function that takes the argument of this name, as `from_py_with` asks for it.
macro_rules! arguments {
    ($($name:ident)*) => {$(
        pub(crate) fn $name<'a, 'py, T>(value: &'a Bound<'py, PyAny>) -> PyResult<T>
        where
            T: FromPyObject<'a, 'py> + ArgumentKind,
        {
            given(stringify!($name), value)
        }
    )*};
}

arguments! {
    atol between clearance curvature damping derivative dissipation dwell exponent free frequency gravity keep kind law length_ratio levels linear mass mass_ratio
    max_impacts method n_dof name n_harmonics n_periods over parameter period phase position preload progress rate release restitution rtol
    scene side span speed start stiffness t to
}

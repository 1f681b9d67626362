//! Errors of the core as Python exceptions: bad input is `ValueError`, a failed computation `ConvergenceError`,
//! too little memory `MemoryError`.

use crate::error::{Error, FunctionError};
use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

pyo3::import_exception!(vibroimpact.errors, ConvergenceError);

/// The exception that a user's function raised, itself.
fn function_error(error: &FunctionError) -> PyErr {
    let inner: &(dyn std::error::Error + 'static) = error.inner();
    match inner.downcast_ref::<PyErr>() {
        Some(raised) => Python::attach(|py| raised.clone_ref(py)),
        None => PyRuntimeError::new_err(error.to_string()),
    }
}

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        match error {
            Error::Function(error) => function_error(&error),
            Error::BadValue { .. } | Error::BadShape { .. } => {
                PyValueError::new_err(error.to_string())
            }
            Error::NoConvergence { .. } | Error::NotReached { .. } => {
                ConvergenceError::new_err(error.to_string())
            }
            Error::OutOfMemory { .. } => PyMemoryError::new_err(error.to_string()),
            Error::Interrupted => PyKeyboardInterrupt::new_err(()),
        }
    }
}

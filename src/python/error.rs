//! Errors of the core as Python exceptions: bad input is `ValueError`, a failed computation `ConvergenceError`.

use crate::error::Error;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};

pyo3::import_exception!(vibroimpact.errors, ConvergenceError);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        match error {
            Error::BadValue { .. } | Error::BadShape { .. } => {
                PyValueError::new_err(error.to_string())
            }
            Error::NoConvergence { .. } => ConvergenceError::new_err(error.to_string()),
            Error::Interrupted => PyKeyboardInterrupt::new_err(()),
        }
    }
}

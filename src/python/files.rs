//! Results out: into files and labelled arrays, by modules of Python.

use pyo3::prelude::*;

/// Writes a result to a file.
pub(crate) fn save(result: &Bound<'_, PyAny>, path: &Bound<'_, PyAny>) -> PyResult<()> {
    let files = result.py().import("vibroimpact.results.archive")?;
    files.call_method1("save", (result, path)).map(|_| ())
}

/// A result as a dataset of xarray.
pub(crate) fn to_xarray<'py>(result: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let labelled = result.py().import("vibroimpact.results.labelled")?;
    labelled.call_method1("to_xarray", (result,))
}

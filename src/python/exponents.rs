//! Lyapunov exponents in Python.

use crate::exponents::{LyapunovOptions, lyapunov_exponents};
use crate::python::array::vector;
use crate::python::model::PyScene;
use crate::python::options::Options;
use crate::python::record::fields;
use crate::python::simulate::span;
use crate::python::{argument, interrupt};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// How fast small deviations from a motion grow.
#[pyfunction]
pub(crate) fn _lyapunov_exponents<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    q0: &Bound<'py, PyAny>,
    v0: &Bound<'py, PyAny>,
    t_span: &Bound<'py, PyAny>,
    options: Options<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let (q0, v0) = (vector("q0", q0)?, vector("v0", v0)?);
    let t_span = span(t_span)?;
    let own = LyapunovOptions {
        skip: options.get("skip")?,
        n_exponents: options.count_or_none("n_exponents", 0)?,
        solver: options.solver()?,
    };
    let scene = &scene.0;
    let found = interrupt::run(py, options.get("progress")?, || {
        lyapunov_exponents(scene, &q0, &v0, t_span, &own)
    })?;
    Ok(fields!(py, found =>
        exponents errors sum expected_sum history n_impacts n_landings n_grazes n_clashes verdict status message
    ))
}

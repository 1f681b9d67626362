//! Lyapunov exponents in Python.

use crate::exponents::{LyapunovOptions, lyapunov_exponents};
use crate::python::array::{out_matrix, vector};
use crate::python::model::PyScene;
use crate::python::simulate::{count, solver, span};
use crate::python::{argument, interrupt};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// Exponents, errors, their sum and the one expected, the history; impacts, landings, grazes, clashes; verdict, status, message.
type Exponents<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    f64,
    f64,
    Bound<'py, PyAny>,
    usize,
    usize,
    usize,
    usize,
    &'static str,
    &'static str,
    String,
);

/// How fast small deviations from a motion grow.
#[pyfunction]
pub(crate) fn _lyapunov_exponents<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    q0: &Bound<'py, PyAny>,
    v0: &Bound<'py, PyAny>,
    t_span: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::skip)] skip: f64,
    #[pyo3(from_py_with = argument::n_exponents)] n_exponents: Option<i64>,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: Option<f64>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<Exponents<'py>> {
    let (q0, v0) = (vector("q0", q0)?, vector("v0", v0)?);
    let (start, end) = span(t_span)?;
    let options = LyapunovOptions {
        skip,
        n_exponents: count("n_exponents", n_exponents)?,
        solver: solver(method, rtol, atol)?,
    };
    let scene = &scene.0;
    let found = interrupt::run(py, progress, || {
        lyapunov_exponents(scene, &q0, &v0, (start, end), &options)
    })?;
    Ok((
        found.exponents.into_pyarray(py),
        found.errors.into_pyarray(py),
        found.sum,
        found.expected_sum,
        out_matrix(py, &found.history)?.into_any(),
        found.n_impacts,
        found.n_landings,
        found.n_grazes,
        found.n_clashes,
        found.verdict.name(),
        found.status.name(),
        found.message,
    ))
}

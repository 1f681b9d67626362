//! Cells of basins in Python.

use crate::attractor::{Attractor, AttractorKind};
use crate::basin::{BasinOptions, basin_cells};
use crate::orbit::Pattern;
use crate::python::array::{matrix, times};
use crate::python::attractor::state_box;
use crate::python::diagram::count;
use crate::python::model::PyScene;
use crate::python::orbit::PyOrbit;
use crate::python::simulate::solver;
use crate::python::{argument, interrupt};
use crate::sweep::SweepOptions;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// An attractor as Python gives it: kind, orbit, periods of the forcing, points.
type GivenAttractor<'py> = (
    String,
    Option<PyRef<'py, PyOrbit>>,
    usize,
    Bound<'py, PyAny>,
);

fn attractor(given: GivenAttractor<'_>) -> PyResult<Attractor> {
    let (kind, orbit, n_periods, points) = given;
    Ok(Attractor {
        kind: AttractorKind::from_name(&kind)?,
        orbit: orbit.map(|orbit| orbit.0.clone()),
        n_periods,
        points: matrix("points", &points)?,
        exponents: Vec::new(),
        pattern: Pattern::none(),
        reason: String::new(),
        fraction: 0.0,
    })
}

/// Of each state, each at a phase of its own, its label and the periods until it was decided.
#[pyfunction]
pub(crate) fn _basin_cells<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    attractors: Vec<GivenAttractor<'py>>,
    r#box: &Bound<'py, PyAny>,
    wrap: Vec<(i64, f64)>,
    states: &Bound<'py, PyAny>,
    phases: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::phase)] phase: f64,
    #[pyo3(from_py_with = argument::max_periods)] max_periods: i64,
    hits: Option<i64>,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: Option<f64>,
    threads: Option<usize>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
    ask: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyArray1<i16>>, Bound<'py, PyArray1<i32>>)> {
    let scene = &scene.0;
    let around = state_box(r#box, wrap, scene)?;
    let each = attractors.into_iter().map(attractor);
    let attractors = each.collect::<PyResult<Vec<_>>>()?;
    let (states, phases) = (matrix("states", states)?, times("phases", phases)?.0);
    let options = BasinOptions {
        phase,
        max_periods: count("max_periods", max_periods, 0)?,
        hits: hits.map(|hits| count("hits", hits, 1)).transpose()?,
        solver: solver(method, rtol, atol)?,
        sweep: SweepOptions { threads },
    };
    let found = interrupt::run_asking(py, progress, ask.as_ref(), || {
        basin_cells(scene, &attractors, &around, (&states, &phases), &options)
    })?;
    let labels: Vec<i16> = found.labels.iter().map(|label| label.number()).collect();
    let periods = found.iterations.iter();
    let periods: Vec<i32> = periods
        .map(|&k| i32::try_from(k).unwrap_or(i32::MAX))
        .collect();
    Ok((labels.into_pyarray(py), periods.into_pyarray(py)))
}

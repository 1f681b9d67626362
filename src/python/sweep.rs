//! Existence maps and ensembles in Python: whole on threads, or in tiles that any executor can take.

use crate::error::Error;
use crate::model::{BaseMotion, Forcing, Parameter, Scene};
use crate::orbit::Pattern;
use crate::python::array::{out_matrix, rows, times};
use crate::python::model::PyScene;
use crate::python::pattern::pattern;
use crate::python::simulate::{count, method, span};
use crate::python::{argument, interrupt};
use crate::simulate::{Keep, SimulateOptions};
use crate::sweep::{self, Axis, ExistenceCell, Progress, SweepOptions};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

type Cells<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<f64>>,
);

fn out_cells<'py>(py: Python<'py>, cells: &[ExistenceCell]) -> Cells<'py> {
    (
        cells
            .iter()
            .map(|c| i64::from(c.n_orbits))
            .collect::<Vec<_>>()
            .into_pyarray(py),
        cells
            .iter()
            .map(|c| c.is_admissible)
            .collect::<Vec<_>>()
            .into_pyarray(py),
        cells
            .iter()
            .map(|c| c.is_stable)
            .collect::<Vec<_>>()
            .into_pyarray(py),
        cells
            .iter()
            .map(|c| c.multiplier)
            .collect::<Vec<_>>()
            .into_pyarray(py),
    )
}

/// The amplitude of a base motion that is one real number.
fn single(base: &BaseMotion) -> Option<f64> {
    match base.amplitudes().as_slice() {
        [one] if one.im == 0.0 => Some(one.re),
        _ => None,
    }
}

/// An axis of a map. The amplitude of a base motion, one number, is varied as the factor on it.
fn axis(
    argument: &str,
    scene: &Scene,
    (name, values): (&str, &Bound<'_, PyAny>),
) -> PyResult<Axis> {
    let values = times(argument, values)?.0;
    if name == "amplitude" {
        let given = match scene.forcing() {
            Forcing::BaseMotion(base) if single(base).is_some_and(|a| a != 0.0) => {
                single(base).unwrap_or_default()
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
                    Forcing::Load(_) | Forcing::BaseAcceleration(_) => {
                        "what follows a signal has none"
                    }
                    Forcing::Unforced => "the scene has no forcing",
                };
                return Err(PyValueError::new_err(format!(
                    "{argument} is \"amplitude\", but {reason}; \"forcing_scale\" is a factor on the amplitude"
                )));
            }
        };
        let factors = values.iter().map(|amplitude| amplitude / given);
        return Ok(Axis::new(Parameter::ForcingScale, factors));
    }
    let parameter: Parameter = name
        .parse()
        .map_err(|e: crate::Error| PyValueError::new_err(format!("{argument}: {e}")))?;
    Ok(Axis::new(parameter, values))
}

fn periods(n_periods: i64) -> PyResult<usize> {
    usize::try_from(n_periods).map_err(|_| {
        PyValueError::new_err(format!(
            "n_periods is {n_periods}, but it must be at least 1"
        ))
    })
}

struct Question {
    pattern: Pattern,
    x: Axis,
    y: Axis,
    n_periods: usize,
}

fn question(
    scene: &Scene,
    pattern: &Bound<'_, PyAny>,
    x: &(String, Bound<'_, PyAny>),
    y: &(String, Bound<'_, PyAny>),
    n_periods: i64,
) -> PyResult<Question> {
    Ok(Question {
        pattern: self::pattern(pattern)?,
        x: axis("x", scene, (&x.0, &x.1))?,
        y: axis("y", scene, (&y.0, &y.1))?,
        n_periods: periods(n_periods)?,
    })
}

fn fraction(p: Progress) -> f64 {
    if p.total == 0 {
        1.0
    } else {
        p.done as f64 / p.total as f64
    }
}

/// All cells of a map, row by row, on threads.
#[pyfunction]
pub(crate) fn _existence_cells<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'py, PyAny>,
    x: (String, Bound<'py, PyAny>),
    y: (String, Bound<'py, PyAny>),
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
    threads: Option<usize>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<Cells<'py>> {
    let q = question(&scene.0, pattern, &x, &y, n_periods)?;
    let model = &scene.0;
    let map = interrupt::run(py, progress, |observe| {
        let options = SweepOptions { threads };
        sweep::existence_map(
            model,
            &q.pattern,
            (&q.x, &q.y),
            q.n_periods,
            options,
            &mut |p| observe(fraction(p)),
        )
    })?;
    let cells: Vec<ExistenceCell> = (0..map.y.len())
        .flat_map(|j| (0..map.x.len()).map(move |i| (i, j)))
        .map(|(i, j)| map.cell(i, j))
        .collect();
    Ok(out_cells(py, &cells))
}

/// The cells from the first to before the second of a map, row by row, on the calling thread.
#[pyfunction]
pub(crate) fn _existence_tile<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'py, PyAny>,
    x: (String, Bound<'py, PyAny>),
    y: (String, Bound<'py, PyAny>),
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
    cells: (usize, usize),
    ask: Option<Py<PyAny>>,
) -> PyResult<Cells<'py>> {
    let q = question(&scene.0, pattern, &x, &y, n_periods)?;
    let (model, range) = (&scene.0, cells.0..cells.1);
    let cells = interrupt::run_asking(py, false, ask.as_ref(), |observe| {
        let axes = (&q.x, &q.y);
        let observer = &mut |p| observe(fraction(p));
        sweep::existence_tile_observed(model, &q.pattern, axes, q.n_periods, range, observer)
    })?;
    Ok(out_cells(py, &cells))
}

/// The cell that one scene stands for: number of orbits, admissible, stable, largest multiplier.
#[pyfunction]
pub(crate) fn _existence_at(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
    ask: Option<Py<PyAny>>,
) -> PyResult<(u32, bool, bool, f64)> {
    let (pattern, n_periods) = (self::pattern(pattern)?, periods(n_periods)?);
    let model = &scene.0;
    let cell = interrupt::run_asking(py, false, ask.as_ref(), |observe| {
        sweep::existence_at_observed(model, &pattern, n_periods, &mut || observe(0.0))
    })?;
    Ok((
        cell.n_orbits,
        cell.is_admissible,
        cell.is_stable,
        cell.multiplier,
    ))
}

type Ends<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i64>>,
    Vec<&'static str>,
);

/// Which rows of all the states these are, in an error: the first of them is so many rows down.
fn counted_from(first: usize, error: Error) -> Error {
    let Error::BadValue {
        argument,
        value,
        rule,
    } = error
    else {
        return error;
    };
    let row = argument.strip_prefix("row ").and_then(|text| {
        let (row, rest) = text.split_once(':')?;
        let row: usize = row.parse().ok()?;
        Some(format!("row {}:{rest}", first + row))
    });
    Error::bad_value(row.unwrap_or(argument), value, rule)
}

/// The ends of many trajectories, on threads; ``first``: the number of the first row, for errors.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the public signature, and the threads
pub(crate) fn _simulate_rows<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    q0: &Bound<'py, PyAny>,
    v0: &Bound<'py, PyAny>,
    t_span: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: f64,
    #[pyo3(from_py_with = argument::max_impacts)] max_impacts: Option<i64>,
    threads: Option<usize>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
    first: usize,
    ask: Option<Py<PyAny>>,
) -> PyResult<Ends<'py>> {
    let model = &scene.0;
    let (t_span, max_impacts) = (span(t_span)?, count("max_impacts", max_impacts)?);
    let (q0, v0) = (
        rows("q0", q0, model.n_dof())?,
        rows("v0", v0, model.n_dof())?,
    );
    let options = SimulateOptions {
        method: self::method(method)?,
        keep: Keep::Final,
        rtol,
        atol,
        max_impacts,
        ..Default::default()
    };
    let ends = interrupt::run_asking(py, progress, ask.as_ref(), |observe| {
        let sweep = SweepOptions { threads };
        let observer = &mut |p| observe(fraction(p));
        sweep::simulate_many(model, (&q0, &v0), t_span, &options, sweep, observer)
            .map_err(|error| counted_from(first, error))
    })?;
    let impacts: Vec<i64> = ends
        .n_impacts
        .iter()
        .map(|&k| i64::try_from(k).unwrap_or(i64::MAX))
        .collect();
    let status = ends.status.iter().map(|s| s.name()).collect();
    Ok((
        out_matrix(py, &ends.q)?,
        out_matrix(py, &ends.v)?,
        impacts.into_pyarray(py),
        status,
    ))
}

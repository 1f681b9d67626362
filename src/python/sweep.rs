//! Existence maps and ensembles in Python: whole on threads, or in tiles that any executor can take.

use crate::error::Error;
use crate::model::{Parameter, Scene};
use crate::orbit::Pattern;
use crate::python::answered::called_here;
use crate::python::array::{rows, times, vector};
use crate::python::model::PyScene;
use crate::python::named::amplitude_given;
use crate::python::options::{Engine, Options};
use crate::python::pattern::pattern;
use crate::python::ramp::ramps;
use crate::python::record::{Field, fields};
use crate::python::rows::{out_contacts_of_runs, out_impacts_of_runs};
use crate::python::simulate::{count, keep, span};
use crate::python::text::shown;
use crate::python::{argument, interrupt};
use crate::simulate::{Samples, SimulateOptions};
use crate::sweep::{self, Axis, Scenes};
use nalgebra::DMatrix;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An axis of a map. The amplitude of a base motion, one number, is varied as the factor on it.
pub(super) fn axis(
    argument: &str,
    scene: &Scene,
    (name, values): (&str, &Bound<'_, PyAny>),
) -> PyResult<Axis> {
    let values = times(argument, values)?.0;
    if name == "amplitude" {
        let given = amplitude_given(argument, scene)?;
        let factors = values.iter().map(|amplitude| amplitude / given);
        return Ok(Axis::new(Parameter::ForcingScale, factors));
    }
    let parameter: Parameter = name.parse().map_err(|e: crate::Error| {
        PyValueError::new_err(format!("{argument}: {e}{}", called_here(name)))
    })?;
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

/// All cells of a map, row by row, on threads.
#[pyfunction]
pub(crate) fn _existence_cells<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'py, PyAny>,
    x: (String, Bound<'py, PyAny>),
    y: (String, Bound<'py, PyAny>),
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
    engine: Engine<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let (model, q) = (&scene.0, question(&scene.0, pattern, &x, &y, n_periods)?);
    let (axes, options) = ((&q.x, &q.y), engine.sweep());
    let map = engine.run(|| sweep::existence_map(model, &q.pattern, axes, q.n_periods, options))?;
    Ok(fields!(py, map => n_orbits is_admissible is_stable multiplier))
}

/// Refuses what a map refuses before anything is computed.
#[pyfunction]
pub(crate) fn _check_existence(
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'_, PyAny>,
    x: (String, Bound<'_, PyAny>),
    y: (String, Bound<'_, PyAny>),
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
) -> PyResult<()> {
    let q = question(&scene.0, pattern, &x, &y, n_periods)?;
    sweep::existence_tile(&scene.0, &q.pattern, (&q.x, &q.y), q.n_periods, 0..0)?;
    Ok(())
}

/// The cell that one scene stands for: number of orbits, admissible, stable, largest multiplier.
#[pyfunction]
pub(crate) fn _existence_at<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
    ask: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (pattern, n_periods) = (self::pattern(pattern)?, periods(n_periods)?);
    let model = &scene.0;
    let cell = interrupt::run_asking(py, false, ask.as_ref(), || {
        sweep::existence_at(model, &pattern, n_periods)
    })?;
    Ok(fields!(py, cell => n_orbits is_admissible is_stable multiplier))
}

/// One scene, or as many as there are runs.
pub(super) fn scenes(value: &Bound<'_, PyAny>) -> PyResult<(Vec<Scene>, bool)> {
    if let Ok(one) = value.extract::<PyRef<'_, PyScene>>() {
        return Ok((vec![one.0.clone()], true));
    }
    let wrong = || {
        let found = shown(value);
        PyTypeError::new_err(format!(
            "scene is {found}, but a Scene, a sequence of them or a callable is needed"
        ))
    };
    let each = value.try_iter().map_err(|_| wrong())?;
    let each = each.map(|item| {
        let item = item?;
        let scene = item.extract::<PyRef<'_, PyScene>>().map_err(|_| wrong())?;
        Ok(scene.0.clone())
    });
    Ok((each.collect::<PyResult<_>>()?, false))
}

/// Samples of all runs, shape (k, m, n), nan after an early end.
fn out_samples<'py>(
    py: Python<'py>,
    samples: &[Samples],
    (m, n): (usize, usize),
    of: impl Fn(&Samples) -> &DMatrix<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut all = vec![f64::NAN; samples.len() * m * n];
    for (run, place) in samples.iter().zip(all.chunks_mut((m * n).max(1))) {
        let own = of(run);
        for i in 0..own.nrows() {
            for j in 0..n {
                place[i * n + j] = own[(i, j)];
            }
        }
    }
    let shape = [samples.len(), m, n];
    Ok(all.into_pyarray(py).reshape(shape)?.into_any())
}

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
    scene: &Bound<'py, PyAny>,
    q0: &Bound<'py, PyAny>,
    v0: &Bound<'py, PyAny>,
    t_span: &Bound<'py, PyAny>,
    options: Options<'py>,
    first: usize,
    engine: Engine<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let (models, is_one) = scenes(scene)?;
    let n = models.first().map_or(0, Scene::n_dof);
    let t_span = span(t_span)?;
    let (q0, v0) = (rows_or_one("q0", q0, n)?, rows_or_one("v0", v0, n)?);
    let t_eval = options
        .any_or_none("t_eval")?
        .map(|t| times("t_eval", &t))
        .transpose()?;
    let options = SimulateOptions {
        solver: options.solver()?,
        keep: keep(&options.get::<String>("keep")?)?,
        t_eval: t_eval.map(|t| t.0),
        max_impacts: count("max_impacts", options.get("max_impacts")?)?,
        ramps: ramps(options.any_or_none("ramp")?.as_ref())?,
    };
    let sweep = engine.sweep();
    let ends = engine.run(|| {
        let scenes = if is_one {
            Scenes::One(&models[0])
        } else {
            Scenes::Each(&models)
        };
        sweep::simulate_many(scenes, (&q0, &v0), t_span, &options, sweep)
            .map_err(|error| counted_from(first, error))
    })?;
    let (q, v) = match (&ends.samples, &options.t_eval) {
        (Some(samples), Some(times)) => {
            let shape = (times.len(), n);
            (
                out_samples(py, samples, shape, |own| &own.1)?,
                out_samples(py, samples, shape, |own| &own.2)?,
            )
        }
        _ => (ends.q.field(py)?, ends.v.field(py)?),
    };
    let (runs, impacts) = by_runs(&ends.impacts, first);
    let impacts = out_impacts_of_runs(py, &runs, &impacts)?;
    let (runs, contacts) = by_runs(&ends.contacts, first);
    let contacts = out_contacts_of_runs(py, &runs, &contacts)?;
    Ok(fields!(py, ends => n_impacts status; q: q; v: v; impacts: impacts; contacts: contacts))
}

/// What happens in each of some runs, run after run, with the numbers of the runs.
fn by_runs<T: Copy>(each: &[Vec<T>], first: usize) -> (Vec<usize>, Vec<T>) {
    let runs = each.iter().zip(first..);
    let runs = runs.flat_map(|(own, run)| own.iter().map(move |part| (run, *part)));
    runs.unzip()
}

/// Rows of states, or one of them, which may be given without its axis.
fn rows_or_one(argument: &str, value: &Bound<'_, PyAny>, n: usize) -> PyResult<DMatrix<f64>> {
    rows(argument, value, n).or_else(|error| match vector(argument, value) {
        Ok(one) if one.len() == n => Ok(DMatrix::from_row_slice(1, n, one.as_slice())),
        _ => Err(error),
    })
}

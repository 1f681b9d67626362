//! Attractors in Python: what starts settle on, and which of them is which.

use crate::attractor::{
    Attractor, AttractorKind, AttractorOptions, SeedOutcome, StateBox, gathered_seeds, settle_seeds,
};
use crate::model::Scene;
use crate::python::array::{matrix, out_matrix};
use crate::python::diagram::count;
use crate::python::model::PyScene;
use crate::python::orbit::PyOrbit;
use crate::python::pattern::{out_pattern, pattern};
use crate::python::simulate::solver;
use crate::python::{argument, interrupt};
use crate::sweep::SweepOptions;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// The box from an array of lows and highs, shape (2n, 2), and the turns of positions that are angles.
pub(crate) fn state_box(
    value: &Bound<'_, PyAny>,
    wrap: Vec<(i64, f64)>,
    scene: &Scene,
) -> PyResult<StateBox> {
    let sides = matrix("box", value)?;
    let (found, wanted) = (sides.shape(), (2 * scene.n_dof(), 2));
    if found != wanted {
        let message = format!("box has shape {found:?}, but {wanted:?} is needed");
        return Err(pyo3::exceptions::PyValueError::new_err(message));
    }
    let column = |k: usize| sides.column(k).into_owned();
    let turned = |around: StateBox, (position, turn): (i64, f64)| {
        let position = usize::try_from(position).unwrap_or(usize::MAX);
        around.with_turn(position, turn)
    };
    Ok(wrap
        .into_iter()
        .try_fold(StateBox::new(column(0), column(1))?, turned)?)
}

/// Of each start what it settles on: "inside", "lost", "drifting", "undecided", the states of what is unclear, or kind, orbit, period,
/// points, exponents, pattern and reason.
#[pyfunction]
pub(crate) fn _settle_seeds<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    r#box: &Bound<'py, PyAny>,
    wrap: Vec<(i64, f64)>,
    seeds: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::phase)] phase: f64,
    #[pyo3(from_py_with = argument::longest_period)] longest_period: i64,
    #[pyo3(from_py_with = argument::transient)] transient: i64,
    #[pyo3(from_py_with = argument::max_periods)] max_periods: i64,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: Option<f64>,
    threads: Option<usize>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
    ask: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyList>> {
    let scene = &scene.0;
    let around = state_box(r#box, wrap, scene)?;
    let seeds = matrix("seeds", seeds)?;
    let options = AttractorOptions {
        phase,
        longest_period: count("longest_period", longest_period, 1)?,
        transient: count("transient", transient, 0)?,
        max_periods: count("max_periods", max_periods, 0)?,
        solver: solver(method, rtol, atol)?,
        sweep: SweepOptions { threads },
    };
    let found = interrupt::run_asking(py, progress, ask.as_ref(), || {
        settle_seeds(scene, &around, &seeds, &options)
    })?;
    let each = found.into_iter().map(|own| out_found(py, own));
    PyList::new(py, each.collect::<PyResult<Vec<_>>>()?)
}

fn out_found(py: Python<'_>, found: SeedOutcome) -> PyResult<Bound<'_, PyAny>> {
    let named = |name: &str| Ok(name.into_pyobject(py)?.into_any());
    match found {
        SeedOutcome::Inside => named("inside"),
        SeedOutcome::Lost => named("lost"),
        SeedOutcome::Drifting => named("drifting"),
        SeedOutcome::Undecided => named("undecided"),
        SeedOutcome::Unclear(states) => Ok(out_matrix(py, &states)?.into_any()),
        SeedOutcome::Attractor(own) => Ok(out_attractor(py, *own)?.into_pyobject(py)?.into_any()),
    }
}

/// An attractor as its parts: kind, orbit, period, points, exponents, pattern, reason.
type Parts<'py> = (
    &'static str,
    Option<Py<PyOrbit>>,
    usize,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Bound<'py, PyList>,
    String,
);

fn out_attractor(py: Python<'_>, own: Attractor) -> PyResult<Parts<'_>> {
    let orbit = own.orbit.map(|orbit| Py::new(py, PyOrbit(orbit)));
    Ok((
        own.kind.name(),
        orbit.transpose()?,
        own.n_periods,
        out_matrix(py, &own.points)?.into_any(),
        numpy::PyArray1::from_vec(py, own.exponents).into_any(),
        out_pattern(py, &own.pattern)?,
        own.reason,
    ))
}

/// The same as Python hands it back.
type Read<'py> = (
    String,
    Option<PyRef<'py, PyOrbit>>,
    usize,
    Bound<'py, PyAny>,
    Vec<f64>,
    Bound<'py, PyAny>,
    String,
);

/// What a start has settled on, as [`_settle_seeds`] gives it.
fn read_found(found: &Bound<'_, PyAny>) -> PyResult<SeedOutcome> {
    if let Ok(name) = found.extract::<String>() {
        return Ok(match name.as_str() {
            "inside" => SeedOutcome::Inside,
            "lost" => SeedOutcome::Lost,
            "drifting" => SeedOutcome::Drifting,
            _ => SeedOutcome::Undecided,
        });
    }
    if !found.is_instance_of::<PyTuple>() {
        return Ok(SeedOutcome::Unclear(matrix("points", found)?));
    }
    let (kind, orbit, n_periods, points, exponents, stops, reason): Read<'_> = found.extract()?;
    Ok(SeedOutcome::Attractor(Box::new(Attractor {
        kind: AttractorKind::from_name(&kind)?,
        orbit: orbit.map(|orbit| orbit.0.clone()),
        n_periods,
        points: matrix("points", &points)?,
        exponents,
        pattern: pattern(&stops)?,
        reason,
        fraction: 0.0,
    })))
}

/// Of what starts have settled on, as [`_settle_seeds`] gives it, the attractors, and of each start the place of its own: -1 undecided, -2
/// lost, -3 inside a stop, -4 drifting.
#[pyfunction]
pub(crate) fn _group_attractors<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    r#box: &Bound<'py, PyAny>,
    wrap: Vec<(i64, f64)>,
    found: Vec<Bound<'py, PyAny>>,
    #[pyo3(from_py_with = argument::phase)] phase: f64,
    #[pyo3(from_py_with = argument::longest_period)] longest_period: i64,
    #[pyo3(from_py_with = argument::transient)] transient: i64,
    #[pyo3(from_py_with = argument::max_periods)] max_periods: i64,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: Option<f64>,
) -> PyResult<(Vec<i64>, Vec<Parts<'py>>)> {
    let scene = &scene.0;
    let around = state_box(r#box, wrap, scene)?;
    let options = AttractorOptions {
        phase,
        longest_period: count("longest_period", longest_period, 1)?,
        transient: count("transient", transient, 0)?,
        max_periods: count("max_periods", max_periods, 0)?,
        solver: solver(method, rtol, atol)?,
        sweep: SweepOptions::default(),
    };
    let found = found.iter().map(read_found).collect::<PyResult<Vec<_>>>()?;
    let all = interrupt::run(py, false, || {
        gathered_seeds(scene, &around, &found, &options)
    })?;
    let code = |(own, place): (&SeedOutcome, &Option<usize>)| match (place, own) {
        (Some(place), _) => i64::try_from(*place).unwrap_or(i64::MAX),
        (None, SeedOutcome::Lost) => -2,
        (None, SeedOutcome::Inside) => -3,
        (None, SeedOutcome::Drifting) => -4,
        (None, _) => -1,
    };
    let codes = found.iter().zip(&all.of_seed).map(code).collect();
    let each = all.all.into_iter().map(|own| out_attractor(py, own));
    Ok((codes, each.collect::<PyResult<Vec<_>>>()?))
}

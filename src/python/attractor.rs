//! Attractors in Python: what starts settle on, and which of them is which.

use crate::attractor::{AttractorKind, AttractorOptions, Found, StateBox, groups, settle_seeds};
use crate::model::Scene;
use crate::python::array::{matrix, out_matrix};
use crate::python::diagram::count;
use crate::python::model::PyScene;
use crate::python::orbit::PyOrbit;
use crate::python::pattern::out_pattern;
use crate::python::simulate::method;
use crate::python::sweep::fraction;
use crate::python::{argument, interrupt};
use crate::sweep::SweepOptions;
use pyo3::prelude::*;
use pyo3::types::PyList;

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

/// Of each start what it settles on: "inside", "lost", "undecided", or kind, orbit, period, points, exponents, pattern and reason.
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
    #[pyo3(from_py_with = argument::atol)] atol: f64,
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
        method: self::method(method)?,
        rtol,
        atol,
        sweep: SweepOptions { threads },
    };
    let found = interrupt::run_asking(py, progress, ask.as_ref(), |observe| {
        let observer = &mut |p| observe(fraction(p));
        settle_seeds(scene, &around, &seeds, &options, observer)
    })?;
    let each = found.into_iter().map(|own| out_found(py, own));
    PyList::new(py, each.collect::<PyResult<Vec<_>>>()?)
}

fn out_found(py: Python<'_>, found: Found) -> PyResult<Bound<'_, PyAny>> {
    let named = |name: &str| Ok(name.into_pyobject(py)?.into_any());
    let own = match found {
        Found::Inside => return named("inside"),
        Found::Lost => return named("lost"),
        Found::Undecided => return named("undecided"),
        Found::Attractor(own) => *own,
    };
    let orbit = own
        .orbit
        .map(|orbit| Py::new(py, PyOrbit(orbit)))
        .transpose()?;
    let parts = (
        own.kind.name(),
        orbit,
        own.n_periods,
        out_matrix(py, &own.points)?,
        numpy::PyArray1::from_vec(py, own.exponents),
        out_pattern(py, &own.pattern)?,
        own.reason,
    );
    Ok(parts.into_pyobject(py)?.into_any())
}

/// For each (kind, period, points) or None the place of its attractor, -1 without; for each attractor the place of the one that stands for it.
#[pyfunction]
pub(crate) fn _group_attractors(
    seen: Vec<Option<(String, usize, Bound<'_, PyAny>)>>,
    r#box: &Bound<'_, PyAny>,
    wrap: Vec<(i64, f64)>,
    scene: PyRef<'_, PyScene>,
) -> PyResult<(Vec<i64>, Vec<usize>)> {
    let around = state_box(r#box, wrap, &scene.0)?;
    let read = |own: Option<(String, usize, Bound<'_, PyAny>)>| {
        own.map(|(kind, period, points)| {
            Ok::<_, PyErr>((
                AttractorKind::from_name(&kind)?,
                period,
                matrix("points", &points)?,
            ))
        })
        .transpose()
    };
    let seen = seen.into_iter().map(read).collect::<PyResult<Vec<_>>>()?;
    let found = groups(&seen, &around);
    let place = |own: &Option<usize>| own.map_or(-1, |k| i64::try_from(k).unwrap_or(i64::MAX));
    Ok((
        found.of_each.iter().map(place).collect(),
        found.all.iter().map(|group| group.first).collect(),
    ))
}

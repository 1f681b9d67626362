//! Sections and bifurcation diagrams in Python.

use crate::model::Scene;
use crate::python::array::{out_matrix, times, vector};
use crate::python::orbit::PyOrbit;
use crate::python::pattern::{out_pattern, stop_set};
use crate::python::simulate::solver;
use crate::python::sweep::{axis, scenes};
use crate::python::text::shown;
use crate::python::trajectory::PyTrajectory;
use crate::python::{argument, interrupt};
use crate::section::{Motion, PoincarePoints, Section, poincare_points};
use crate::sweep::{self, DiagramOptions, Direction, SweepOptions};
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyList;

/// Times, stops (-1 for none), speeds, phases, positions, velocities.
type Points<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
);

/// Counts as Python has them.
fn counts(py: Python<'_>, counts: impl IntoIterator<Item = usize>) -> Bound<'_, PyArray1<i64>> {
    let each = counts.into_iter();
    let each = each.map(|count| i64::try_from(count).unwrap_or(i64::MAX));
    each.collect::<Vec<_>>().into_pyarray(py)
}

fn out_points(py: Python<'_>, points: PoincarePoints) -> PyResult<Points<'_>> {
    let stops = points.stop.into_iter();
    let stops = stops.map(|stop| stop.and_then(|stop| i64::try_from(stop).ok()).unwrap_or(-1));
    Ok((
        points.t.into_pyarray(py),
        stops.collect::<Vec<_>>().into_pyarray(py),
        points.speed_before.into_pyarray(py),
        points.phase.into_pyarray(py),
        out_matrix(py, &points.q)?.into_any(),
        out_matrix(py, &points.v)?.into_any(),
    ))
}

/// Stops of a section: all where none are given.
fn stops(value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<usize>> {
    value.map_or_else(|| Ok(Vec::new()), |value| stop_set("stops", value))
}

/// A row of numbers for each position and velocity, and the value through which it rises.
fn plane(value: &Bound<'_, PyAny>) -> PyResult<Section> {
    let Ok((row, value)) = value.extract::<(Bound<'_, PyAny>, f64)>() else {
        let message = format!(
            "plane is {}, but a pair (row, value) is needed",
            shown(value)
        );
        return Err(PyTypeError::new_err(message));
    };
    let row = vector("plane", &row)?;
    Ok(Section::Plane { row, value })
}

/// The points of a section of a trajectory or an orbit.
#[pyfunction]
pub(crate) fn _poincare_points<'py>(
    py: Python<'py>,
    motion: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::phase)] phase: Option<f64>,
    stops: Option<&Bound<'py, PyAny>>,
    plane: Option<&Bound<'py, PyAny>>,
) -> PyResult<Points<'py>> {
    let section = match (phase, stops, plane) {
        (Some(phase), None, None) => Section::Phase(phase),
        (None, None, Some(plane)) => self::plane(plane)?,
        (None, stops, None) => Section::Impacts(self::stops(stops)?),
        _ => {
            let message =
                "several of phase, stops and plane are given, but a section is at one of them";
            return Err(PyValueError::new_err(message));
        }
    };
    let points = if let Ok(run) = motion.extract::<PyRef<'_, PyTrajectory>>() {
        poincare_points(Motion::Trajectory(&run.core), &section)?
    } else if let Ok(orbit) = motion.extract::<PyRef<'_, PyOrbit>>() {
        poincare_points(Motion::Orbit(&orbit.0), &section)?
    } else {
        let message = format!(
            "motion is {}, but a Trajectory or an Orbit is needed",
            shown(motion)
        );
        return Err(PyTypeError::new_err(message));
    };
    out_points(py, points)
}

/// A whole number that counts something.
pub(crate) fn count(argument: &str, value: i64, least: i64) -> PyResult<usize> {
    usize::try_from(value)
        .ok()
        .filter(|_| value >= least)
        .ok_or_else(|| {
            PyValueError::new_err(format!(
                "{argument} is {value}, but it must be at least {least}"
            ))
        })
}

/// The one of three values that stands for the direction "up", "down" or "both".
pub(crate) fn by_direction<T>(direction: &str, [up, down, both]: [T; 3]) -> PyResult<T> {
    match direction {
        "up" => Ok(up),
        "down" => Ok(down),
        "both" => Ok(both),
        _ => {
            let message = format!(
                "direction is \"{direction}\", but it must be \"up\", \"down\" or \"both\""
            );
            Err(PyValueError::new_err(message))
        }
    }
}

/// Values, directions, periods, impacts, patterns, status; the place of the value of each point, and the points.
type Diagram<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    Vec<Bound<'py, PyList>>,
    Vec<&'static str>,
    Bound<'py, PyArray1<i64>>,
    Points<'py>,
);

/// A diagram of one scene over a number of it, or of scenes one for each value.
#[pyfunction]
pub(crate) fn _bifurcation_diagram<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyAny>,
    name: Option<String>,
    values: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::direction)] direction: &str,
    q0: Option<&Bound<'py, PyAny>>,
    v0: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = argument::transient)] transient: i64,
    #[pyo3(from_py_with = argument::periods)] periods: i64,
    #[pyo3(from_py_with = argument::section)] section: &str,
    #[pyo3(from_py_with = argument::phase)] phase: f64,
    stops: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = argument::carry)] carry: bool,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: Option<f64>,
    threads: Option<usize>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
    ask: Option<Py<PyAny>>,
) -> PyResult<Diagram<'py>> {
    let (models, _) = scenes(scene)?;
    let n = models.first().map_or(0, Scene::n_dof);
    let axis = match &name {
        Some(name) => Some(axis("axis", &models[0], (name, values))?),
        None => None,
    };
    let values = times("axis", values)?.0;
    let stops = Section::Impacts(self::stops(stops)?);
    models.iter().try_for_each(|scene| stops.check(scene))?;
    let part = |argument: &str, value: Option<&Bound<'py, PyAny>>| match value {
        Some(value) => vector(argument, value),
        None => Ok(nalgebra::DVector::zeros(n)),
    };
    let options = DiagramOptions {
        direction: by_direction(direction, [Direction::Up, Direction::Down, Direction::Both])?,
        start: (q0.is_some() || v0.is_some())
            .then(|| Ok::<_, PyErr>((part("q0", q0)?, part("v0", v0)?)))
            .transpose()?,
        transient: count("transient", transient, 0)?,
        periods: count("periods", periods, 1)?,
        section: match section {
            "phase" => Section::Phase(phase),
            "impact" => stops,
            _ => {
                let message =
                    format!("section is \"{section}\", but it must be \"phase\" or \"impact\"");
                return Err(PyValueError::new_err(message));
            }
        },
        carry,
        solver: solver(method, rtol, atol)?,
        sweep: SweepOptions { threads },
    };
    let found = interrupt::run_asking(py, progress, ask.as_ref(), || match &axis {
        Some(axis) => sweep::bifurcation_diagram(&models[0], axis, &options),
        None => sweep::bifurcation_diagram_of(&values, &models, &options),
    })?;
    let direction = found.is_up.iter().map(|&is_up| if is_up { 1 } else { -1 });
    let patterns = found.pattern.iter().map(|pattern| out_pattern(py, pattern));
    Ok((
        found.parameter.into_pyarray(py),
        direction.collect::<Vec<i64>>().into_pyarray(py),
        counts(py, found.n_periods),
        counts(py, found.n_impacts),
        patterns.collect::<PyResult<_>>()?,
        found.status.iter().map(|status| status.name()).collect(),
        counts(py, found.index),
        out_points(py, found.points)?,
    ))
}

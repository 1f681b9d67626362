//! Curves of special points in Python.

use crate::branch::{
    BranchEnd, ContinuationOptions, CurveOf, EndReason, Heading, Special, bifurcation_curve_of,
};
use crate::error::Result;
use crate::model::Scene;
use crate::orbit::PeriodicOrbit;
use crate::python::branch::{SpecialGiven, Varied, special_of, varied};
use crate::python::diagram::{by_direction, count};
use crate::python::made::made;
use crate::python::orbit::PyOrbit;
use crate::python::{argument, interrupt};
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use std::sync::Mutex;

/// Orbits, first and second numbers, arclengths, whether each breaks a rule of contact; points of two things at once; ends.
type CurveTuple<'py> = (
    Vec<Py<PyOrbit>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Vec<OutPoint>,
    Vec<(&'static str, String)>,
);

/// Kind, numbers, errors, arclength, orbit.
type OutPoint = (&'static str, [f64; 2], [f64; 2], f64, Py<PyOrbit>);

/// What varies on a plane.
enum Plane<'a> {
    Numbers([Varied<'a>; 2]),
    Made(&'a Py<PyAny>),
}

impl Plane<'_> {
    fn scene(&self, own: &Scene, x: f64, y: f64, raised: &Mutex<Option<PyErr>>) -> Result<Scene> {
        match self {
            Self::Numbers([first, second]) => {
                let scene = first.scene(own, x, raised)?;
                second.scene(&scene, y, raised)
            }
            Self::Made(make) => made(make, (x, y), raised),
        }
    }
}

/// The curve of a special point, or of an orbit that hits stops at one instant, over two numbers of its scene.
#[pyfunction]
pub(crate) fn _bifurcation_curve<'py>(
    py: Python<'py>,
    point: Option<SpecialGiven>,
    orbit: &Bound<'_, PyOrbit>,
    names: Option<(String, String)>,
    make: Option<Py<PyAny>>,
    start: (Option<f64>, Option<f64>),
    between: ((f64, f64), (f64, f64)),
    #[pyo3(from_py_with = argument::direction)] direction: &str,
    #[pyo3(from_py_with = argument::max_points)] max_points: i64,
    #[pyo3(from_py_with = argument::step)] step: (f64, f64, f64),
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<CurveTuple<'py>> {
    let options = ContinuationOptions {
        heading: by_direction(direction, [Heading::Up, Heading::Down, Heading::Both])?,
        max_points: count("max_points", max_points, 1)?,
        steps: [step.0, step.1, step.2],
        ..ContinuationOptions::default()
    };
    let own: PeriodicOrbit = orbit.get().0.clone();
    let scene = own.scene().clone();
    let (plane, begin) = match (&names, &make, start) {
        (Some((first, second)), ..) => {
            let first = varied(&scene, Some(first), None, start.0)?;
            let second = varied(&scene, Some(second), None, start.1)?;
            let begin = [first.start_in(&scene)?, second.start_in(&scene)?];
            (Plane::Numbers([first, second]), begin)
        }
        (None, Some(make), (Some(x), Some(y))) => (Plane::Made(make), [x, y]),
        _ => {
            return Err(PyValueError::new_err(
                "start is None, but with a callable it must be the pair of values at the orbit",
            ));
        }
    };
    let kind = point.as_ref().map(|point| point.0.clone());
    let special: Option<Special> = point.and_then(|point| special_of(point, own.clone()));
    if let (Some(kind), None) = (kind, &special) {
        return Err(PyValueError::new_err(format!(
            "special is a {kind}, but a zero of a monitor has no curve"
        )));
    }
    let of = special
        .as_ref()
        .map_or(CurveOf::Orbit(&own), CurveOf::Special);
    let raised = Mutex::new(None);
    let between = [between.0, between.1];
    let (found, signal) = interrupt::run_keeping(py, progress, None, || {
        let make = |x: f64, y: f64| plane.scene(&scene, x, y, &raised);
        bifurcation_curve_of(of, &make, begin, between, &options)
    })?;
    let raised = raised.into_inner().ok().flatten();
    // Broken off by hand, the curve so far is kept; before there is one, nothing is.
    let is_by_hand = |raised: &PyErr| raised.is_instance_of::<PyKeyboardInterrupt>(py);
    let found = match (found, raised) {
        (found, Some(raised)) if found.is_err() || !is_by_hand(&raised) => return Err(raised),
        (Ok(found), _) => found,
        (Err(error), _) => return Err(signal.unwrap_or_else(|| error.into())),
    };
    let orbits = found
        .orbits
        .into_iter()
        .map(|orbit| Py::new(py, PyOrbit(orbit)));
    let special = found.special.into_iter().map(|own| {
        let orbit = Py::new(py, PyOrbit(own.orbit))?;
        Ok((own.kind, own.parameters, own.error, own.arclength, orbit))
    });
    let end = |BranchEnd { reason, detail }: BranchEnd| (EndReason::name(reason), detail);
    Ok((
        orbits.collect::<PyResult<_>>()?,
        found.x.into_pyarray(py),
        found.y.into_pyarray(py),
        found.arclength.into_pyarray(py),
        found.is_virtual.into_pyarray(py),
        special.collect::<PyResult<_>>()?,
        found.ends.into_iter().map(end).collect(),
    ))
}

//! Curves of special points in Python.

use crate::branch::{CurveOf, CurvePoint, bifurcation_curve_of};
use crate::error::Result;
use crate::model::Scene;
use crate::python::interrupt;
use crate::python::made::made;
use crate::python::options::Options;
use crate::python::orbit::PyOrbit;
use crate::python::record::{field, fields, objects};
use crate::python::special::GivenSpecial;
use crate::python::varied::{Varied, varied};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;

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
    begin: &Bound<'py, PyAny>,
    names: Option<(String, String)>,
    make: Option<Py<PyAny>>,
    start: (Option<f64>, Option<f64>),
    between: [(f64, f64); 2],
    options: Options<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let given: PyResult<PyRef<'_, PyOrbit>> = begin.extract().map_err(PyErr::from);
    let (point, own) = if let Ok(orbit) = given {
        (None, orbit.0.clone())
    } else {
        let point: GivenSpecial = begin.extract()?;
        let orbit = point.orbit.get().0.clone();
        (Some(point), orbit)
    };
    let progress = options.get("progress")?;
    let options = options.of_continuation()?;
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
    let special = point.as_ref().and_then(GivenSpecial::read);
    if let (Some(GivenSpecial { kind, .. }), None) = (&point, &special) {
        return Err(PyValueError::new_err(format!(
            "special is a {kind}, but a zero of a monitor has no curve"
        )));
    }
    let of = special
        .as_ref()
        .map_or(CurveOf::Orbit(&own), CurveOf::Special);
    let raised = Mutex::new(None);
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
    Ok(fields!(py, found => orbits x y arclength is_virtual special ends))
}

field!(Vec<CurvePoint> => |own, py| objects(py, own)?);
field!(CurvePoint => |own, py| fields!(py, own => kind error arclength orbit; parameter: own.parameters));

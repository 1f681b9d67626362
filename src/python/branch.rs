//! Branches in Python.

use crate::branch::{self, Branch, BranchEnd, ContinuationOptions, EndReason, Heading, Virtual};
use crate::error::Result;
use crate::model::{Parameter, Scene};
use crate::python::array::out_matrix;
use crate::python::diagram::{count, way};
use crate::python::made::made;
use crate::python::orbit::PyOrbit;
use crate::python::sweep::amplitude_given;
use crate::python::text::shown;
use crate::python::{argument, interrupt};
use nalgebra::{Complex, DMatrix};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::sync::Mutex;

/// Orbits, values, arclengths; whether each is admissible, is stable; multipliers outside the circle (-1: undefined), multipliers; special
/// points; ends, whether it is closed; the exception of a function that broke it off.
type Out<'py> = (
    Vec<Py<PyOrbit>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<Complex<f64>>>,
    Vec<OutSpecial>,
    Vec<(&'static str, String)>,
    bool,
    Option<PyErr>,
);

/// Kind, value and its error, arclength, orbit, stop, time.
type OutSpecial = (
    &'static str,
    f64,
    f64,
    f64,
    Py<PyOrbit>,
    Option<usize>,
    Option<f64>,
);

/// What varies along a branch.
enum Varied<'a> {
    Number(Parameter),
    /// The amplitude of a base, as a factor on the one that the scene has.
    Amplitude(f64),
    Made(&'a Py<PyAny>, f64),
}

fn varied<'a>(
    scene: &Scene,
    name: Option<&str>,
    make: Option<&'a Py<PyAny>>,
    start: Option<f64>,
) -> PyResult<Varied<'a>> {
    match (name, make, start) {
        (Some("amplitude"), ..) => Ok(Varied::Amplitude(amplitude_given("parameter", scene)?)),
        (Some(name), ..) => name.parse().map(Varied::Number).map_err(|_| {
            let names = "frequency, amplitude, clearance, clearance[0], restitution, restitution[0], forcing_scale or damping_scale";
            PyValueError::new_err(format!(
                "parameter is {name:?}, but it must be a number of Scene.replace ({names}) or a callable p -> Scene"
            ))
        }),
        (None, Some(make), Some(start)) => Ok(Varied::Made(make, start)),
        (None, ..) => Err(PyValueError::new_err(
            "start is None, but with a callable it must be the value of p at the orbit",
        )),
    }
}

/// The branch of an orbit over a number of its scene, or over scenes that a function makes.
#[pyfunction]
pub(crate) fn _continuation<'py>(
    py: Python<'py>,
    orbit: &Bound<'py, PyAny>,
    name: Option<String>,
    make: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::start)] start: Option<f64>,
    #[pyo3(from_py_with = argument::between)] between: (f64, f64),
    #[pyo3(from_py_with = argument::direction)] direction: &str,
    #[pyo3(from_py_with = argument::max_points)] max_points: i64,
    #[pyo3(from_py_with = argument::step)] step: (f64, f64, f64),
    keeps_virtual: bool,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<Out<'py>> {
    let options = ContinuationOptions {
        heading: way(direction, [Heading::Up, Heading::Down, Heading::Both])?,
        max_points: count("max_points", max_points, 1)?,
        steps: [step.0, step.1, step.2],
        beyond: if keeps_virtual {
            Virtual::Keep
        } else {
            Virtual::Stop
        },
    };
    let orbit = orbit.extract::<PyRef<'_, PyOrbit>>().map_err(|_| {
        let found = shown(orbit);
        PyTypeError::new_err(format!("orbit is {found}, but an Orbit is needed"))
    })?;
    let own = &orbit.0;
    let varied = varied(own.scene(), name.as_deref(), make.as_ref(), start)?;
    let raised = Mutex::new(None);
    let (found, signal) = interrupt::run_keeping(py, progress, None, |observe| {
        let (low, high) = between;
        let observer = &mut |value: f64| observe((value - low) / (high - low));
        let found = match &varied {
            Varied::Number(parameter) => {
                branch::continuation(own, *parameter, between, &options, observer)
            }
            Varied::Amplitude(given) => {
                let scene = own.scene();
                let make =
                    |value: f64| scene.replace(Parameter::ForcingScale.change(value / given));
                branch::continuation_of(own, &make, *given, between, &options, observer)
            }
            Varied::Made(function, start) => {
                let make = |value: f64| made(function, (value,), &raised);
                branch::continuation_of(own, &make, *start, between, &options, observer)
            }
        };
        found.and_then(judged)
    })?;
    let raised = raised.into_inner().ok().flatten();
    let (found, raised) = match (found, raised) {
        (Ok(found), raised) => (found, raised.or(signal)),
        // Before there is a branch.
        (Err(_), Some(raised)) => return Err(raised),
        (Err(error), None) => return Err(signal.unwrap_or_else(|| error.into())),
    };
    out(py, found, raised)
}

/// A branch whose orbits have been judged, with what was found.
struct Judged {
    branch: Branch,
    is_admissible: Vec<bool>,
    is_stable: Vec<bool>,
    n_unstable: Vec<i64>,
    multipliers: DMatrix<Complex<f64>>,
}

fn judged(branch: Branch) -> Result<Judged> {
    let nan = Complex::new(f64::NAN, f64::NAN);
    let width = 2 * branch
        .orbits
        .first()
        .map_or(0, |orbit| orbit.scene().n_dof());
    let mut multipliers = DMatrix::from_element(branch.orbits.len(), width, nan);
    for (k, orbit) in branch.orbits.iter().enumerate() {
        let stability = orbit.stability()?;
        if let Some(order) = stability.orders.first() {
            multipliers.set_row(k, &order.multipliers.transpose());
        }
    }
    let is_stable = branch.is_stable()?.into_iter();
    let counts = branch.n_unstable()?.into_iter();
    let counts = counts.map(|count| {
        count
            .and_then(|count| i64::try_from(count).ok())
            .unwrap_or(-1)
    });
    Ok(Judged {
        n_unstable: counts.collect(),
        is_admissible: branch
            .orbits
            .iter()
            .map(|orbit| orbit.is_admissible() == Some(true))
            .collect(),
        is_stable: is_stable.map(|verdict| verdict == Some(true)).collect(),
        multipliers,
        branch,
    })
}

fn out(py: Python<'_>, found: Judged, raised: Option<PyErr>) -> PyResult<Out<'_>> {
    let Branch {
        orbits,
        parameter,
        arclength,
        special,
        ends,
        is_closed,
    } = found.branch;
    let special = special.into_iter().map(|own| {
        let orbit = Py::new(py, PyOrbit(own.orbit))?;
        let (kind, error) = (own.kind.name(), own.error);
        Ok((
            kind,
            own.parameter,
            error,
            own.arclength,
            orbit,
            own.stop,
            own.time,
        ))
    });
    let orbits = orbits.into_iter().map(|orbit| Py::new(py, PyOrbit(orbit)));
    let end = |BranchEnd { reason, detail }: BranchEnd| (EndReason::name(reason), detail);
    Ok((
        orbits.collect::<PyResult<_>>()?,
        parameter.into_pyarray(py),
        arclength.into_pyarray(py),
        found.is_admissible.into_pyarray(py),
        found.is_stable.into_pyarray(py),
        found.n_unstable.into_pyarray(py),
        out_matrix(py, &found.multipliers)?,
        special.collect::<PyResult<_>>()?,
        ends.into_iter().map(end).collect(),
        is_closed,
        raised,
    ))
}

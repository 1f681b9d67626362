//! Branches in Python.

use crate::branch::{
    self, Branch, BranchEnd, ContinuationOptions, EndReason, Heading, Special, SpecialKind, Virtual,
};
use crate::error::{Error, Result};
use crate::model::{Parameter, Scene};
use crate::observer::unobserved;
use crate::orbit::PeriodicOrbit;
use crate::python::answered::called_here;
use crate::python::array::out_matrix;
use crate::python::diagram::{by_direction, count};
use crate::python::made::{made, raised_or};
use crate::python::model::PyScene;
use crate::python::named::amplitude_given;
use crate::python::orbit::PyOrbit;
use crate::python::text::shown;
use crate::python::{argument, interrupt};
use nalgebra::{Complex, DMatrix};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::sync::Mutex;

/// Orbits, values, arclengths; whether each is admissible, is stable; multipliers outside the circle (-1: undefined), multipliers; special
/// points; ends, whether it is closed; the exception of a function that broke it off.
type BranchTuple<'py> = (
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

/// Kind, value and its error, arclength, orbit, stop, time, rotation number, direction.
type OutSpecial = (
    &'static str,
    f64,
    f64,
    f64,
    Py<PyOrbit>,
    Option<usize>,
    Option<f64>,
    Option<f64>,
    Vec<f64>,
);

/// What varies along a branch.
pub(super) enum Varied<'a> {
    Number(Parameter),
    /// A factor on what an orbit has, which is that of a value; the amplitude of a base is one on that which the scene has.
    Factor(Parameter, f64),
    /// The energy of the motion, in one scene.
    Energy,
    Made(&'a Py<PyAny>, f64),
}

impl Varied<'_> {
    /// The value at the orbit, of all but a number.
    fn start(&self) -> f64 {
        match self {
            Self::Number(_) | Self::Energy => 1.0,
            Self::Factor(_, start) | Self::Made(_, start) => *start,
        }
    }

    /// The value in the scene of an orbit.
    pub fn start_in(&self, scene: &Scene) -> Result<f64> {
        match self {
            Self::Number(parameter) => scene.start_of(*parameter, "parameters"),
            Self::Energy => {
                let rule =
                    "each must be a number of the scene, which the energy of a motion is not";
                Err(Error::bad_value("parameters", "\"energy\"", rule))
            }
            _ => Ok(self.start()),
        }
    }

    /// The scene of a value, from that of the orbit.
    pub fn scene(&self, own: &Scene, value: f64, raised: &Mutex<Option<PyErr>>) -> Result<Scene> {
        match self {
            Self::Number(parameter) => own.with_value(*parameter, value),
            Self::Energy => Ok(own.clone()),
            Self::Factor(parameter, start) => own.with_value(*parameter, value / start),
            Self::Made(function, _) => made(function, (value,), raised),
        }
    }
}

pub(super) fn varied<'a>(
    scene: &Scene,
    name: Option<&str>,
    make: Option<&'a Py<PyAny>>,
    start: Option<f64>,
) -> PyResult<Varied<'a>> {
    match (name, make, start) {
        (Some("energy"), ..) => Ok(Varied::Energy),
        (Some("amplitude"), ..) => {
            let given = amplitude_given("parameter", scene)?;
            Ok(Varied::Factor(Parameter::ForcingScale, given))
        }
        (Some(name), _, start) => name.parse().map(|parameter| match start {
            Some(start) if Parameter::is_factor(parameter) => Varied::Factor(parameter, start),
            _ => Varied::Number(parameter),
        }).map_err(|_| {
            let names = argument::NUMBERS;
            PyValueError::new_err(format!(
                "parameter is {name:?}{}, but it must be a number of Scene.replace ({names}), \"energy\" or a callable p -> Scene",
                called_here(name)
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
    symmetric: Option<bool>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<BranchTuple<'py>> {
    let options = ContinuationOptions {
        heading: by_direction(direction, [Heading::Up, Heading::Down, Heading::Both])?,
        max_points: count("max_points", max_points, 1)?,
        steps: [step.0, step.1, step.2],
        beyond: if keeps_virtual {
            Virtual::Keep
        } else {
            Virtual::Stop
        },
        symmetric,
    };
    let orbit = orbit.extract::<PyRef<'_, PyOrbit>>().map_err(|_| {
        let found = shown(orbit);
        PyTypeError::new_err(format!("orbit is {found}, but an Orbit is needed"))
    })?;
    let own = &orbit.0;
    let varied = varied(own.scene(), name.as_deref(), make.as_ref(), start)?;
    let raised = Mutex::new(None);
    let (found, signal) = interrupt::run_keeping(py, progress, None, || {
        let found = match &varied {
            Varied::Number(parameter) => branch::continuation(own, *parameter, between, &options),
            Varied::Energy => branch::continuation_over_energy(own, between, &options),
            Varied::Factor(..) | Varied::Made(..) => {
                let make = |value: f64| varied.scene(own.scene(), value, &raised);
                branch::continuation_of(own, &make, varied.start(), between, &options)
            }
        };
        // What was followed is kept, and judged, when the rest is broken off.
        found.and_then(|branch| unobserved(|| judged(branch)))
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

/// Kind, value, stop, time, direction.
pub(super) type SpecialGiven = (String, f64, Option<usize>, Option<f64>, Vec<f64>);

/// A special point from what Python has of it.
pub(super) fn special_of(point: SpecialGiven, orbit: PeriodicOrbit) -> Option<Special> {
    let (kind, parameter, stop, time, direction) = point;
    let kind = SpecialKind::ALL
        .into_iter()
        .find(|own| own.name() == kind)?;
    Some(Special {
        kind,
        parameter,
        error: 0.0,
        arclength: 0.0,
        orbit,
        stop,
        time,
        rotation: None,
        direction: direction.into(),
    })
}

/// The branches that meet a branch at a special point: an orbit of each, its value, whether that is above the point's.
#[pyfunction]
pub(crate) fn _branches(
    py: Python<'_>,
    point: SpecialGiven,
    orbit: &Bound<'_, PyOrbit>,
    name: Option<String>,
    make: Option<Py<PyAny>>,
    between: (f64, f64),
) -> PyResult<Vec<(PyOrbit, f64, bool)>> {
    let parameter = point.1;
    let Some(special) = special_of(point, orbit.get().0.clone()) else {
        return Ok(Vec::new());
    };
    let scene = special.orbit.scene().clone();
    let varied = varied(&scene, name.as_deref(), make.as_ref(), Some(parameter))?;
    let raised = Mutex::new(None);
    let found = py.detach(|| {
        let make = |value: f64| varied.scene(&scene, value, &raised);
        match varied {
            Varied::Energy => branch::branches_over_energy(&special, between),
            _ => branch::branches_of(&special, &make, between),
        }
    });
    let each = raised_or(found.map_err(PyErr::from), raised)?.into_iter();
    Ok(each
        .map(|own| (PyOrbit(own.orbit), own.parameter, own.is_above))
        .collect())
}

/// The border towards which grazes accumulate; none of elastic impacts.
#[pyfunction]
pub(crate) fn _accumulation(
    py: Python<'_>,
    point: SpecialGiven,
    orbit: &Bound<'_, PyOrbit>,
    name: Option<String>,
    make: Option<Py<PyAny>>,
    between: (f64, f64),
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<Option<OutSpecial>> {
    let parameter = point.1;
    let Some(special) = special_of(point, orbit.get().0.clone()) else {
        return Ok(None);
    };
    let scene = special.orbit.scene().clone();
    let varied = varied(&scene, name.as_deref(), make.as_ref(), Some(parameter))?;
    let raised = Mutex::new(None);
    let found = interrupt::run(py, progress, || {
        let make = |value: f64| varied.scene(&scene, value, &raised);
        match varied {
            Varied::Energy => Ok(None),
            _ => branch::accumulation_of(&special, &make, between),
        }
    });
    let found = raised_or(found, raised)?;
    found.map(|own| out_special(py, own)).transpose()
}

/// The scene of a value, from that of an orbit which is that of another.
#[pyfunction]
pub(crate) fn _scene_at(
    scene: &PyScene,
    name: Option<String>,
    make: Option<Py<PyAny>>,
    start: f64,
    value: f64,
) -> PyResult<PyScene> {
    let varied = varied(&scene.0, name.as_deref(), make.as_ref(), Some(start))?;
    let raised = Mutex::new(None);
    let found = varied.scene(&scene.0, value, &raised);
    raised_or(found.map_err(PyErr::from), raised).map(PyScene)
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
    // Of many modes they were counted without an eigenproblem.
    let known = if branch.outside.is_none() {
        branch.orbits.as_slice()
    } else {
        &[]
    };
    for (k, orbit) in known.iter().enumerate() {
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

fn out(py: Python<'_>, found: Judged, raised: Option<PyErr>) -> PyResult<BranchTuple<'_>> {
    let Branch {
        orbits,
        parameter,
        arclength,
        special,
        ends,
        is_closed,
        ..
    } = found.branch;
    let special = special.into_iter().map(|own| out_special(py, own));
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

fn out_special(py: Python<'_>, own: Special) -> PyResult<OutSpecial> {
    Ok((
        own.kind.name(),
        own.parameter,
        own.error,
        own.arclength,
        Py::new(py, PyOrbit(own.orbit))?,
        own.stop,
        own.time,
        own.rotation,
        own.direction.as_slice().to_vec(),
    ))
}

//! Derivatives of orbits in Python.

use crate::derivative::{self, Derivatives};
use crate::error::Result;
use crate::model::{Parameter, Scene};
use crate::orbit::PeriodicOrbit;
use crate::python::argument::NUMBERS;
use crate::python::array::{out_matrix, vector};
use crate::python::interrupt;
use crate::python::made::{Numbers, made, raised_or};
use crate::python::sweep::amplitude_given;
use crate::python::text::shown;
use nalgebra::DVector;
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::sync::Mutex;

/// A number of a scene by its name, and what one of it is in the unit that the scene counts in.
struct Named {
    parameter: Parameter,
    unit: f64,
}

fn named(scene: &Scene, name: &str) -> PyResult<Named> {
    if name == "amplitude" {
        let unit = 1.0 / amplitude_given("parameters", scene)?;
        let parameter = Parameter::ForcingScale;
        return Ok(Named { parameter, unit });
    }
    let parameter = name.parse().map_err(|_| {
        PyValueError::new_err(format!(
            "parameters has {name:?}, but each must be a number of Scene.replace ({NUMBERS})"
        ))
    })?;
    Ok(Named {
        parameter,
        unit: 1.0,
    })
}

/// The names of a list, or one alone.
fn names(parameters: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if parameters.is_instance_of::<PyString>() {
        return Ok(vec![parameters.extract()?]);
    }
    parameters.extract().map_err(|_| {
        let found = shown(parameters);
        PyTypeError::new_err(format!(
            "parameters is {found}, but numbers of Scene.replace or a callable p (d,) -> Scene are needed"
        ))
    })
}

/// The derivatives of an orbit, as an object of Python.
pub(crate) fn derivatives<'py>(
    py: Python<'py>,
    orbit: &PeriodicOrbit,
    parameters: &Bound<'py, PyAny>,
    start: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if parameters.is_callable() {
        let Some(start) = start else {
            return Err(PyValueError::new_err(
                "start is None, but with a callable it must be the value of p at the orbit",
            ));
        };
        return of_callable(py, orbit, parameters, start, derivative::derivatives_of);
    }
    let names = names(parameters)?;
    if let Some(start) = start {
        return Err(PyValueError::new_err(format!(
            "start is {}, but it is that of a callable: the orbit has its own numbers",
            shown(start)
        )));
    }
    let each = names.iter().map(|name| named(orbit.scene(), name));
    let each: Vec<Named> = each.collect::<PyResult<_>>()?;
    let numbers: Vec<Parameter> = each.iter().map(|own| own.parameter).collect();
    let mut found = interrupt::run(py, false, |_| derivative::derivatives(orbit, &numbers))?;
    for (i, own) in each.iter().enumerate() {
        if own.unit != 1.0 {
            scale(&mut found, i, own.unit);
        }
    }
    out(py, Some(names), found)
}

/// Derivatives by what a callable makes scenes of, taken by a function of the core.
pub(crate) fn of_callable<'py>(
    py: Python<'py>,
    orbit: &PeriodicOrbit,
    make: &Bound<'py, PyAny>,
    start: &Bound<'py, PyAny>,
    derived: fn(&PeriodicOrbit, &dyn Fn(&[f64]) -> Result<Scene>, &[f64]) -> Result<Derivatives>,
) -> PyResult<Bound<'py, PyAny>> {
    let (start, make) = (vector("start", start)?, make.clone().unbind());
    let raised = Mutex::new(None);
    let found = interrupt::run(py, false, |_| {
        let make = |p: &[f64]| made(&make, (Numbers(p),), &raised);
        derived(orbit, &make, start.as_slice())
    });
    out(py, None, raised_or(found, raised)?)
}

/// Takes one of the numbers in another unit.
fn scale(found: &mut Derivatives, i: usize, unit: f64) {
    for matrix in [
        &mut found.q0,
        &mut found.v0,
        &mut found.speeds_before,
        &mut found.times,
        &mut found.min_gap,
        &mut found.max_displacement,
    ] {
        matrix.column_mut(i).scale_mut(unit);
    }
    found.phase[i] *= unit;
    found.period[i] *= unit;
    found.multipliers.column_mut(i).scale_mut(unit);
}

fn out<'py>(
    py: Python<'py>,
    names: Option<Vec<String>>,
    found: Derivatives,
) -> PyResult<Bound<'py, PyAny>> {
    let row =
        |x: &DVector<f64>| -> Bound<'py, PyArray1<f64>> { x.as_slice().to_vec().into_pyarray(py) };
    let class = py
        .import("vibroimpact.derivative")?
        .getattr("Derivatives")?;
    class.call1((
        names,
        out_matrix(py, &found.q0)?,
        out_matrix(py, &found.v0)?,
        row(&found.phase),
        row(&found.period),
        out_matrix(py, &found.speeds_before)?,
        out_matrix(py, &found.times)?,
        out_matrix(py, &found.multipliers)?,
        out_matrix(py, &found.min_gap)?,
        out_matrix(py, &found.max_displacement)?,
        found.reason,
    ))
}

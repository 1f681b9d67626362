//! Derivatives of orbits in Python.

use crate::derivative::{self, OrbitDerivatives};
use crate::error::Result;
use crate::model::{Parameter, Scene};
use crate::orbit::PeriodicOrbit;
use crate::python::array::vector;
use crate::python::interrupt;
use crate::python::made::{NumberSlice, made, raised_or};
use crate::python::named::{Named, named, names};
use crate::python::record::fields;
use crate::python::text::shown;
use crate::simulate::Trajectory;
use nalgebra::DMatrix;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Mutex;

/// How the states of a run change with numbers of its scene.
pub(crate) struct OfRun {
    /// The numbers, and for each the derivatives of (q, v) by it at some times, shape `(m, 2n)`, or at the end, shape `(1, 2n)`, \[units of q
    /// and v over that of the number\].
    pub by: Vec<(String, DMatrix<f64>)>,
    pub is_of_end: bool,
    /// Why there are none from some time on.
    pub reason: Option<String>,
}

/// The numbers that a run is to be derived by, of names that a scene has.
pub(crate) fn names_for_run(scene: &Scene, given: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let names = names("derivatives", given, "numbers of Scene.replace")?;
    for name in &names {
        let parameter = named("derivatives", scene, name)?.parameter;
        scene.start_of(parameter, "derivatives")?;
    }
    Ok(names)
}

/// The derivatives of a run at some times, of those after it is over none, or at its end.
pub(crate) fn of_run(
    py: Python<'_>,
    run: &Trajectory,
    names: Vec<String>,
    times: Option<&[f64]>,
) -> PyResult<OfRun> {
    let scene = run.scene();
    let each = names.iter().map(|name| named("derivatives", scene, name));
    let each: Vec<Named> = each.collect::<PyResult<_>>()?;
    let numbers: Vec<Parameter> = each.iter().map(|own| own.parameter).collect();
    let end = [run.t_end()];
    let asked = times.unwrap_or(&end);
    let within = asked.partition_point(|&t| t <= end[0]);
    let asked_of = &asked[..within];
    let found = interrupt::run(py, false, || {
        derivative::derivatives_of_run(run, &numbers, asked_of)
    })?;
    let whole = |(own, by): (&Named, DMatrix<f64>)| {
        let by = by * own.unit;
        by.resize_vertically(asked.len(), f64::NAN)
    };
    let by = each.iter().zip(found.by).map(whole);
    Ok(OfRun {
        by: names.into_iter().zip(by).collect(),
        is_of_end: times.is_none(),
        reason: found.reason,
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
    let needed = "numbers of Scene.replace or a callable p (d,) -> Scene";
    let names = names("parameters", parameters, needed)?;
    if let Some(start) = start {
        return Err(PyValueError::new_err(format!(
            "start is {}, but it is that of a callable: the orbit has its own numbers",
            shown(start)
        )));
    }
    let each = names
        .iter()
        .map(|name| named("parameters", orbit.scene(), name));
    let each: Vec<Named> = each.collect::<PyResult<_>>()?;
    let numbers: Vec<Parameter> = each.iter().map(|own| own.parameter).collect();
    let mut found = interrupt::run(py, false, || derivative::derivatives(orbit, &numbers))?;
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
    derived: fn(
        &PeriodicOrbit,
        &dyn Fn(&[f64]) -> Result<Scene>,
        &[f64],
    ) -> Result<OrbitDerivatives>,
) -> PyResult<Bound<'py, PyAny>> {
    let (start, make) = (vector("start", start)?, make.clone().unbind());
    let raised = Mutex::new(None);
    let found = interrupt::run(py, false, || {
        let make = |p: &[f64]| made(&make, (NumberSlice(p),), &raised);
        derived(orbit, &make, start.as_slice())
    });
    out(py, None, raised_or(found, raised)?)
}

/// Takes one of the numbers in another unit.
fn scale(found: &mut OrbitDerivatives, i: usize, unit: f64) {
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

/// Derivatives as an object of Python.
pub(crate) fn out(
    py: Python<'_>,
    parameters: Option<Vec<String>>,
    found: OrbitDerivatives,
) -> PyResult<Bound<'_, PyAny>> {
    let class = py.import("vibroimpact")?.getattr("Derivatives")?;
    let fields = fields!(py, found =>
        q0 v0 phase period speeds_before times multipliers min_gap max_displacement reason;
        parameters: parameters;
    );
    class.call((), Some(&fields))
}

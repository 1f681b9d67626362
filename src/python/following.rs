//! What an objective asks of the core: orbits followed from one set of numbers of their scene to another, and their derivatives.

use crate::derivative;
use crate::python::array::vector;
use crate::python::derivative::of_callable;
use crate::python::interrupt;
use crate::python::made::{NumberSlice, made, raised_or};
use crate::python::orbit::PyOrbit;
use pyo3::prelude::*;
use std::sync::Mutex;

/// An orbit followed to the scene of other numbers.
#[pyfunction]
pub(crate) fn _continued_orbit(
    py: Python<'_>,
    orbit: PyRef<'_, PyOrbit>,
    make: Py<PyAny>,
    start: &Bound<'_, PyAny>,
    p: &Bound<'_, PyAny>,
) -> PyResult<PyOrbit> {
    let (start, p) = (vector("start", start)?, vector("p", p)?);
    let (own, raised) = (&orbit.0, Mutex::new(None));
    let found = interrupt::run(py, false, || {
        let make = |p: &[f64]| made(&make, (NumberSlice(p),), &raised);
        let way = (start.as_slice(), p.as_slice());
        derivative::follow_orbit(own, &make, way)
    });
    raised_or(found, raised).map(PyOrbit)
}

/// The derivatives of an orbit but those of its multipliers.
#[pyfunction]
pub(crate) fn _derivatives_but_multipliers<'py>(
    py: Python<'py>,
    orbit: PyRef<'_, PyOrbit>,
    make: &Bound<'py, PyAny>,
    start: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let derived = derivative::derivatives_but_multipliers;
    of_callable(py, &orbit.0, make, start, derived)
}

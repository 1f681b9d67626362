//! Arguments and arrays of what is measured along a motion, the same for trajectories and orbits.

use crate::python::array::{times, vector};
use crate::python::rows::is_before;
use crate::simulate::ImpactSide;
use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Times, or none for the points for drawing; and whether a single one was given.
pub(crate) fn times_or_points(t: Option<&Bound<'_, PyAny>>) -> PyResult<(Option<Vec<f64>>, bool)> {
    let Some(t) = t else {
        return Ok((None, false));
    };
    let (times, is_single) = times("t", t)?;
    Ok((Some(times), is_single))
}

/// A side of an impact by its name.
pub(crate) fn side(name: &str) -> PyResult<ImpactSide> {
    let before = is_before(name)?;
    Ok(if before {
        ImpactSide::Before
    } else {
        ImpactSide::After
    })
}

/// The order of a derivative, none below zero.
pub(crate) fn derivative(order: i64) -> PyResult<usize> {
    usize::try_from(order).map_err(|_| {
        PyValueError::new_err(format!(
            "derivative is {order}, but it must be 0 (position), 1 (velocity) or 2 (acceleration)"
        ))
    })
}

/// A span of times, or none.
pub(crate) fn window(span: Option<&Bound<'_, PyAny>>) -> PyResult<Option<(f64, f64)>> {
    let Some(span) = span else {
        return Ok(None);
    };
    match vector("span", span)?.as_slice() {
        &[start, end] => Ok(Some((start, end))),
        other => Err(PyValueError::new_err(format!(
            "span has shape ({},), but (start, end) is needed",
            other.len()
        ))),
    }
}

/// Values at times as shape (m,), or () for a single one.
pub(crate) fn out_values(
    py: Python<'_>,
    values: Vec<f64>,
    is_single: bool,
) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    let shape = if is_single {
        Vec::new()
    } else {
        vec![values.len()]
    };
    values.into_pyarray(py).reshape(shape)
}

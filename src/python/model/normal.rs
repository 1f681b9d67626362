//! Directions in Python: the index of a coordinate, or a vector.

use crate::model::Normal;
use crate::python::array::vector;
use crate::python::pattern::stop_index;
use pyo3::prelude::*;

fn is_whole_number(value: &Bound<'_, PyAny>) -> bool {
    value.hasattr("__index__").unwrap_or(false)
        && value
            .getattr("shape")
            .map_or(true, |s| s.len().unwrap_or(0) == 0)
}

/// A direction: the index of a coordinate, or a vector.
pub(crate) fn normal(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Normal> {
    if is_whole_number(value) {
        Ok(Normal::Coordinate(stop_index(argument, value)?))
    } else {
        Ok(vector(argument, value)?.into())
    }
}

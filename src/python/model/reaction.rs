//! Reaction directions, in and out.

use crate::model::Reaction;
use crate::python::array::{out_vector, vector};
use crate::python::model::bad;
use pyo3::prelude::*;

/// A reaction from what is given.
pub(super) fn reaction(value: Option<&Bound<'_, PyAny>>) -> PyResult<Reaction> {
    let Some(value) = value else {
        return Ok(Reaction::Inertia);
    };
    match value.extract::<String>() {
        Ok(name) if name == "inertia" => Ok(Reaction::Inertia),
        Ok(name) if name == "coordinate" => Ok(Reaction::Coordinate),
        Ok(name) => Err(bad(format!(
            "reaction is {name:?}, but it must be \"inertia\", \"coordinate\" or a direction of shape (n,)"
        ))),
        Err(_) => Ok(Reaction::Direction(vector("reaction", value)?)),
    }
}

/// A reaction as it is given.
pub(super) fn out_reaction<'py>(
    py: Python<'py>,
    reaction: &Reaction,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(match reaction {
        Reaction::Inertia => "inertia".into_pyobject(py)?.into_any(),
        Reaction::Coordinate => "coordinate".into_pyobject(py)?.into_any(),
        Reaction::Direction(b) => out_vector(py, b).into_any(),
    })
}

//! Patterns as Python lists: an index is an instant with one stop, a tuple one with several.

use crate::orbit::Pattern;
use crate::python::text::shown as as_python;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// A stop's index; negative ones are refused, they are not "the other side".
pub(crate) fn stop_index(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
    if value.is_instance_of::<pyo3::types::PyBool>() {
        return Err(PyValueError::new_err(format!(
            "{argument} is {}, but an index is needed",
            as_python(value)
        )));
    }
    let index: i64 = value
        .call_method0("__index__")
        .and_then(|i| i.extract())
        .map_err(|_| {
            PyValueError::new_err(format!(
                "{argument} is {}, but an index is needed",
                as_python(value)
            ))
        })?;
    usize::try_from(index).map_err(|_| {
        PyValueError::new_err(format!(
            "{argument} is {index}, but indices count from 0 upwards"
        ))
    })
}

/// Stops hit together: one index or several.
pub(crate) fn stop_set(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    match value.try_iter() {
        Ok(items) => items.map(|item| stop_index(argument, &item?)).collect(),
        Err(_) => Ok(vec![stop_index(argument, value)?]),
    }
}

/// A pattern from a list of indices and tuples of indices.
pub(crate) fn pattern(value: &Bound<'_, PyAny>) -> PyResult<Pattern> {
    let items = value.try_iter().map_err(|_| {
        PyValueError::new_err("pattern must be a list of stops, such as [1], [(0, 1)] or []; a tuple is hit at one instant")
    })?;
    let instants = items
        .enumerate()
        .map(|(k, item)| stop_set(&format!("pattern[{k}]"), &item?))
        .collect::<PyResult<Vec<_>>>()?;
    Ok(Pattern::new(instants)?)
}

/// The pattern as Python writes it.
pub(crate) fn out_pattern<'py>(py: Python<'py>, pattern: &Pattern) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for instant in pattern.instants() {
        match instant.as_slice() {
            [stop] => list.append(stop)?,
            stops => list.append(PyTuple::new(py, stops)?)?,
        }
    }
    Ok(list)
}

/// One instant as text.
fn shown_instant(instant: &[usize]) -> String {
    match instant {
        [stop] => stop.to_string(),
        stops => {
            let stops: Vec<String> = stops.iter().map(ToString::to_string).collect();
            format!("({})", stops.join(", "))
        }
    }
}

/// The pattern as text in which an instant that comes more than three times in a row is counted.
pub(crate) fn shown(pattern: &Pattern) -> String {
    let runs = pattern.instants().chunk_by(|a, b| a == b);
    let parts = runs.flat_map(|run| {
        let one = shown_instant(&run[0]);
        if run.len() > 3 {
            vec![format!("{one} x {}", run.len())]
        } else {
            vec![one; run.len()]
        }
    });
    format!("[{}]", parts.collect::<Vec<_>>().join(", "))
}

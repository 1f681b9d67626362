//! The arrays of impacts, touches, segments and states that orbits and trajectories share.

use crate::impact::Impact;
use crate::python::array::{out_rows, out_vector, structured};
use crate::simulate::Segment;
use nalgebra::DVector;
use numpy::IntoPyArray;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Which side of an impact is meant, from its name.
pub(crate) fn is_before(side: &str) -> PyResult<bool> {
    match side {
        "after" => Ok(false),
        "before" => Ok(true),
        _ => Err(PyValueError::new_err(format!(
            "side is {side:?}, but it must be \"after\" or \"before\""
        ))),
    }
}

/// Impacts as a structured array.
pub(crate) fn out_impacts<'py>(py: Python<'py>, impacts: &[Impact]) -> PyResult<Bound<'py, PyAny>> {
    let column = |f: &dyn Fn(&Impact) -> f64| {
        impacts
            .iter()
            .map(f)
            .collect::<Vec<f64>>()
            .into_pyarray(py)
            .into_any()
    };
    let stops: Vec<i64> = impacts
        .iter()
        .map(|i| i64::try_from(i.stop).unwrap_or(i64::MAX))
        .collect();
    structured(
        py,
        impacts.len(),
        vec![
            ("time", "f8", column(&|i| i.time)),
            ("stop", "i8", stops.into_pyarray(py).into_any()),
            ("speed_before", "f8", column(&|i| i.approach)),
            ("speed_after", "f8", column(&|i| i.departure)),
            ("impulse", "f8", column(&|i| i.impulse)),
            ("phase", "f8", column(&|i| i.phase)),
        ],
    )
}

/// Grazes, each a time, a stop and a depth, as a structured array.
pub(crate) fn out_grazes(
    py: Python<'_>,
    grazes: impl Iterator<Item = (f64, usize, f64)>,
) -> PyResult<Bound<'_, PyAny>> {
    let (mut times, mut stops, mut depths) = (Vec::new(), Vec::new(), Vec::new());
    for (time, stop, depth) in grazes {
        times.push(time);
        stops.push(i64::try_from(stop).unwrap_or(i64::MAX));
        depths.push(depth);
    }
    structured(
        py,
        times.len(),
        vec![
            ("time", "f8", times.into_pyarray(py).into_any()),
            ("stop", "i8", stops.into_pyarray(py).into_any()),
            ("depth", "f8", depths.into_pyarray(py).into_any()),
        ],
    )
}

/// Segments as a structured array.
pub(crate) fn out_segments<'py>(
    py: Python<'py>,
    segments: &[Segment],
) -> PyResult<Bound<'py, PyAny>> {
    let kinds = segments
        .iter()
        .map(|s| s.kind.name())
        .collect::<Vec<_>>()
        .into_pyobject(py)?;
    let stops: Vec<i64> = segments
        .iter()
        .map(|s| s.stop.and_then(|i| i64::try_from(i).ok()).unwrap_or(-1))
        .collect();
    let starts: Vec<f64> = segments.iter().map(|s| s.start).collect();
    let ends: Vec<f64> = segments.iter().map(|s| s.end).collect();
    structured(
        py,
        segments.len(),
        vec![
            ("kind", "U7", kinds.into_any()),
            ("stop", "i8", stops.into_pyarray(py).into_any()),
            ("start", "f8", starts.into_pyarray(py).into_any()),
            ("end", "f8", ends.into_pyarray(py).into_any()),
        ],
    )
}

/// Rows out as (m, n), a single one as (n,).
pub(crate) fn out_states<'py>(
    py: Python<'py>,
    rows: &[DVector<f64>],
    n: usize,
    is_single: bool,
) -> PyResult<Bound<'py, PyAny>> {
    if is_single {
        return Ok(out_vector(py, &rows[0]).into_any());
    }
    Ok(out_rows(py, rows, n)?.into_any())
}

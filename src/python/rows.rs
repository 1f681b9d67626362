//! The arrays of impacts, touches, segments and states that orbits and trajectories share.

use crate::impact::Impact;
use crate::python::array::{RowType, out_rows, out_vector};
use crate::simulate::{ContactRecord, RegimeRow, Segment};
use nalgebra::DVector;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyList;

static IMPACT_ROWS: RowType = RowType::new(&[
    ("time", "f8"),
    ("stop", "i8"),
    ("speed_before", "f8"),
    ("speed_after", "f8"),
    ("impulse", "f8"),
    ("phase", "f8"),
]);
static IMPACTS_OF_RUNS: RowType = RowType::new(&[
    ("run", "i8"),
    ("time", "f8"),
    ("stop", "i8"),
    ("speed_before", "f8"),
    ("speed_after", "f8"),
    ("impulse", "f8"),
    ("phase", "f8"),
]);
static GRAZES: RowType = RowType::new(&[("time", "f8"), ("stop", "i8"), ("depth", "f8")]);
static SEGMENTS: RowType = RowType::new(&[
    ("kind", "U7"),
    ("stop", "i8"),
    ("start", "f8"),
    ("end", "f8"),
    ("impulse", "f8"),
]);
static CONTACTS: RowType = RowType::new(&[
    ("stop", "i8"),
    ("start", "f8"),
    ("end", "f8"),
    ("phase", "f8"),
    ("speed_before", "f8"),
    ("speed_after", "f8"),
    ("impulse", "f8"),
    ("peak_force", "f8"),
    ("peak_approach", "f8"),
    ("loss", "f8"),
]);

static CONTACTS_OF_RUNS: RowType = RowType::new(&[
    ("run", "i8"),
    ("stop", "i8"),
    ("start", "f8"),
    ("end", "f8"),
    ("phase", "f8"),
    ("speed_before", "f8"),
    ("speed_after", "f8"),
    ("impulse", "f8"),
    ("peak_force", "f8"),
    ("peak_approach", "f8"),
    ("loss", "f8"),
]);

/// Impacts as a structured array.
pub(crate) fn out_impacts<'py>(py: Python<'py>, impacts: &[Impact]) -> PyResult<Bound<'py, PyAny>> {
    IMPACT_ROWS.array(py, impacts.len(), impact_columns(py, impacts))
}

/// Impacts of many runs, each with the number of its run, as a structured array.
pub(crate) fn out_impacts_of_runs<'py>(
    py: Python<'py>,
    runs: &[usize],
    impacts: &[Impact],
) -> PyResult<Bound<'py, PyAny>> {
    let runs = run_column(py, runs);
    let [a, b, c, d, e, f] = impact_columns(py, impacts);
    IMPACTS_OF_RUNS.array(py, impacts.len(), [runs, a, b, c, d, e, f])
}

/// The numbers of runs.
fn run_column<'py>(py: Python<'py>, runs: &[usize]) -> Bound<'py, PyAny> {
    let runs = runs
        .iter()
        .map(|&run| i64::try_from(run).unwrap_or(i64::MAX));
    runs.collect::<Vec<i64>>().into_pyarray(py).into_any()
}

fn impact_columns<'py>(py: Python<'py>, impacts: &[Impact]) -> [Bound<'py, PyAny>; 6] {
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
    [
        column(&|i| i.time),
        stops.into_pyarray(py).into_any(),
        column(&|i| i.approach),
        column(&|i| i.departure),
        column(&|i| i.impulse),
        column(&|i| i.phase),
    ]
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
    let len = times.len();
    let columns = [
        times.into_pyarray(py).into_any(),
        stops.into_pyarray(py).into_any(),
        depths.into_pyarray(py).into_any(),
    ];
    GRAZES.array(py, len, columns)
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
    let impulses: Vec<f64> = segments.iter().map(|s| s.impulse).collect();
    let columns = [
        kinds.into_any(),
        stops.into_pyarray(py).into_any(),
        starts.into_pyarray(py).into_any(),
        ends.into_pyarray(py).into_any(),
        impulses.into_pyarray(py).into_any(),
    ];
    SEGMENTS.array(py, segments.len(), columns)
}

/// Contacts as a structured array.
pub(crate) fn out_contacts<'py>(
    py: Python<'py>,
    contacts: &[ContactRecord],
) -> PyResult<Bound<'py, PyAny>> {
    CONTACTS.array(py, contacts.len(), contact_columns(py, contacts))
}

/// Contacts of many runs, each with the number of its run, as a structured array.
pub(crate) fn out_contacts_of_runs<'py>(
    py: Python<'py>,
    runs: &[usize],
    contacts: &[ContactRecord],
) -> PyResult<Bound<'py, PyAny>> {
    let runs = run_column(py, runs);
    let [a, b, c, d, e, f, g, h, i, j] = contact_columns(py, contacts);
    CONTACTS_OF_RUNS.array(py, contacts.len(), [runs, a, b, c, d, e, f, g, h, i, j])
}

fn contact_columns<'py>(py: Python<'py>, contacts: &[ContactRecord]) -> [Bound<'py, PyAny>; 10] {
    let stops = contacts
        .iter()
        .map(|own| i64::try_from(own.stop).unwrap_or(i64::MAX))
        .collect::<Vec<_>>();
    let column = |of: &dyn Fn(&ContactRecord) -> f64| {
        let values: Vec<f64> = contacts.iter().map(of).collect();
        values.into_pyarray(py).into_any()
    };
    [
        stops.into_pyarray(py).into_any(),
        column(&|own| own.start),
        column(&|own| own.end),
        column(&|own| own.phase),
        column(&|own| own.speed_before),
        column(&|own| own.speed_after),
        column(&|own| own.impulse),
        column(&|own| own.peak_force),
        column(&|own| own.peak_approach),
        column(&|own| own.loss),
    ]
}

/// Regimes as a structured array, with an entry of its state for each of some elements.
pub(crate) fn out_regimes<'py>(
    py: Python<'py>,
    rows: &[RegimeRow],
    n_elements: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    let fields = PyList::empty(py);
    for (name, kind) in [("start", "f8"), ("end", "f8"), ("mode", "i8")] {
        fields.append((name, kind))?;
    }
    fields.append(("state", "U9", (n_elements,)))?;
    let array = numpy.call_method1("zeros", (rows.len(), fields))?;
    let column = |of: &dyn Fn(&RegimeRow) -> f64| {
        let values: Vec<f64> = rows.iter().map(of).collect();
        values.into_pyarray(py)
    };
    array.set_item("start", column(&|own| own.start))?;
    array.set_item("end", column(&|own| own.end))?;
    if n_elements > 0 && !rows.is_empty() {
        let states: Vec<&[&str]> = rows.iter().map(|own| own.states.as_slice()).collect();
        array.set_item("state", states)?;
    }
    Ok(array)
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

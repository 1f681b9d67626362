//! Cells of basins in Python.

use crate::basin::{
    BasinOptions, Label, PowerLaw, basin_cells, basin_entropy, boundary_dimension,
    uncertainty_exponent,
};
use crate::python::argument;
use crate::python::array::{matrix, times};
use crate::python::attractor::{GivenAttractor, state_box};
use crate::python::model::PyScene;
use crate::python::options::{Engine, Options};
use crate::python::record::{Field, field, fields};
use nalgebra::DMatrix;
use pyo3::prelude::*;
use pyo3::types::PyDict;

field!(Vec<Label> => |own, py| own.into_iter().map(Label::number).collect::<Vec<_>>().field(py)?);

/// Of each state, each at a phase of its own, its label and the periods until it was decided.
#[pyfunction]
pub(crate) fn _basin_cells<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    attractors: Vec<GivenAttractor<'py>>,
    r#box: &Bound<'py, PyAny>,
    wrap: Vec<(i64, f64)>,
    states: &Bound<'py, PyAny>,
    phases: &Bound<'py, PyAny>,
    options: Options<'py>,
    engine: Engine<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let scene = &scene.0;
    let around = state_box(r#box, wrap, scene)?;
    let each = attractors.into_iter().map(GivenAttractor::read);
    let attractors = each.collect::<PyResult<Vec<_>>>()?;
    let (states, phases) = (matrix("states", states)?, times("phases", phases)?.0);
    let options = BasinOptions {
        phase: options.get("phase")?,
        max_periods: options.count("max_periods", 0)?,
        hits: options.count_or_none("hits", 1)?,
        solver: options.solver()?,
        sweep: engine.sweep(),
    };
    let starts = (&states, phases.as_slice());
    let found = engine.run(|| basin_cells(scene, &attractors, &around, starts, &options))?;
    let periods = found.iterations.into_iter();
    let periods = periods.map(|k| i32::try_from(k).unwrap_or(i32::MAX));
    let iterations: Vec<i32> = periods.collect();
    Ok(fields!(py, found => labels; iterations: iterations))
}

/// The labels of a plane by their numbers.
fn plane(labels: &Bound<'_, PyAny>) -> PyResult<DMatrix<Label>> {
    Ok(matrix("labels", labels)?.map(Label::from_number))
}

/// The entropy of boxes of a plane of labels: of all, and of those on the boundary.
#[pyfunction]
pub(crate) fn _basin_entropy(labels: &Bound<'_, PyAny>, cells: i64) -> PyResult<(f64, f64)> {
    let found = basin_entropy(&plane(labels)?, usize::try_from(cells).unwrap_or(0))?;
    Ok((found.all, found.boundary))
}

field!(PowerLaw => |own, py| fields!(py, own => value error sizes counts));

/// The dimension of the boundary of a plane of labels.
#[pyfunction]
pub(crate) fn _boundary_dimension<'py>(labels: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    boundary_dimension(&plane(labels)?).field(labels.py())
}

/// The exponent of uncertainty of a plane of labels.
#[pyfunction]
pub(crate) fn _uncertainty_exponent<'py>(
    labels: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    uncertainty_exponent(&plane(labels)?).field(labels.py())
}

//! Sections and bifurcation diagrams in Python.

use crate::model::Scene;
use crate::python::argument;
use crate::python::array::{times, vector};
use crate::python::options::{Engine, Options};
use crate::python::orbit::PyOrbit;
use crate::python::pattern::stop_set;
use crate::python::record::fields;
use crate::python::sweep::{axis, scenes};
use crate::python::text::shown;
use crate::python::trajectory::PyTrajectory;
use crate::section::{Section, poincare_points};
use crate::sweep::{self, DiagramOptions, Direction};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Stops of a section: all where none are given.
fn stops(value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<usize>> {
    value.map_or_else(|| Ok(Vec::new()), |value| stop_set("stops", value))
}

/// A row of numbers for each position and velocity, and the value through which it rises.
fn plane(value: &Bound<'_, PyAny>) -> PyResult<Section> {
    let Ok((row, value)) = value.extract::<(Bound<'_, PyAny>, f64)>() else {
        let message = format!(
            "plane is {}, but a pair (row, value) is needed",
            shown(value)
        );
        return Err(PyTypeError::new_err(message));
    };
    let row = vector("plane", &row)?;
    Ok(Section::Plane { row, value })
}

/// The points of a section of a trajectory or an orbit.
#[pyfunction]
pub(crate) fn _poincare_points<'py>(
    py: Python<'py>,
    motion: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::phase)] phase: Option<f64>,
    stops: Option<&Bound<'py, PyAny>>,
    plane: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let section = match (phase, stops, plane) {
        (Some(phase), None, None) => Section::Phase(phase),
        (None, None, Some(plane)) => self::plane(plane)?,
        (None, stops, None) => Section::Impacts(self::stops(stops)?),
        _ => {
            let message =
                "several of phase, stops and plane are given, but a section is at one of them";
            return Err(PyValueError::new_err(message));
        }
    };
    let points = if let Ok(run) = motion.extract::<PyRef<'_, PyTrajectory>>() {
        poincare_points(&run.core, &section)?
    } else if let Ok(orbit) = motion.extract::<PyRef<'_, PyOrbit>>() {
        poincare_points(&orbit.0, &section)?
    } else {
        let message = format!(
            "motion is {}, but a Trajectory or an Orbit is needed",
            shown(motion)
        );
        return Err(PyTypeError::new_err(message));
    };
    Ok(fields!(py, points => t stop speed_before phase q v))
}

/// A diagram of one scene over a number of it, or of scenes one for each value.
#[pyfunction]
pub(crate) fn _bifurcation_diagram<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyAny>,
    name: Option<String>,
    values: &Bound<'py, PyAny>,
    options: Options<'py>,
    engine: Engine<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let (models, _) = scenes(scene)?;
    let n = models.first().map_or(0, Scene::n_dof);
    let axis = match &name {
        Some(name) => Some(axis("axis", &models[0], (name, values))?),
        None => None,
    };
    let values = times("axis", values)?.0;
    let stops = Section::Impacts(self::stops(options.any_or_none("stops")?.as_ref())?);
    models.iter().try_for_each(|scene| stops.check(scene))?;
    let start = (options.any_or_none("q0")?, options.any_or_none("v0")?);
    let part = |name: &str, value: &Option<Bound<'py, PyAny>>| match value {
        Some(value) => vector(name, value),
        None => Ok(nalgebra::DVector::zeros(n)),
    };
    let options = DiagramOptions {
        direction: options.direction([Direction::Up, Direction::Down, Direction::Both])?,
        start: match &start {
            (None, None) => None,
            (q0, v0) => Some((part("q0", q0)?, part("v0", v0)?)),
        },
        transient: options.count("transient", 0)?,
        periods: options.count("periods", 1)?,
        section: match options.get::<String>("section")?.as_str() {
            "phase" => Section::Phase(options.get("phase")?),
            "impact" => stops,
            other => {
                let message =
                    format!("section is \"{other}\", but it must be \"phase\" or \"impact\"");
                return Err(PyValueError::new_err(message));
            }
        },
        carry: options.get("carry")?,
        solver: options.solver()?,
        sweep: engine.sweep(),
    };
    let found = engine.run(|| match &axis {
        Some(axis) => sweep::bifurcation_diagram(&models[0], axis, &options),
        None => sweep::bifurcation_diagram_of(&values, &models, &options),
    })?;
    let direction = found.is_up.iter().map(|&is_up| if is_up { 1 } else { -1 });
    let direction: Vec<i64> = direction.collect();
    let points = found.points;
    Ok(
        fields!(py, found => parameter n_periods n_impacts pattern status index;
            direction: direction;
            stop: points.stop;
            speed_before: points.speed_before;
            phase: points.phase;
            q: points.q;
            v: points.v;
        ),
    )
}

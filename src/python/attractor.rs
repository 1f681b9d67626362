//! Attractors in Python: what starts settle on, and which of them is which.

use crate::attractor::{
    Attractor, AttractorKind, AttractorOptions, SeedOutcome, StateBox, gathered_seeds, settle_seeds,
};
use crate::model::Scene;
use crate::python::array::matrix;
use crate::python::model::PyScene;
use crate::python::options::{Engine, Options};
use crate::python::orbit::PyOrbit;
use crate::python::pattern::pattern;
use crate::python::record::{Field, field, fields, objects};
use crate::python::{argument, interrupt};
use crate::sweep::SweepOptions;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// The box from an array of lows and highs, shape (2n, 2), and the turns of positions that are angles.
pub(crate) fn state_box(
    value: &Bound<'_, PyAny>,
    wrap: Vec<(i64, f64)>,
    scene: &Scene,
) -> PyResult<StateBox> {
    let sides = matrix("box", value)?;
    let (found, wanted) = (sides.shape(), (2 * scene.n_dof(), 2));
    if found != wanted {
        let message = format!("box has shape {found:?}, but {wanted:?} is needed");
        return Err(pyo3::exceptions::PyValueError::new_err(message));
    }
    let column = |k: usize| sides.column(k).into_owned();
    let turned = |around: StateBox, (position, turn): (i64, f64)| {
        let position = usize::try_from(position).unwrap_or(usize::MAX);
        around.with_turn(position, turn)
    };
    Ok(wrap
        .into_iter()
        .try_fold(StateBox::new(column(0), column(1))?, turned)?)
}

impl Options<'_> {
    /// How attractors are looked for.
    fn of_attractors(&self, sweep: SweepOptions) -> PyResult<AttractorOptions> {
        Ok(AttractorOptions {
            phase: self.get("phase")?,
            longest_period: self.count("longest_period", 1)?,
            transient: self.count("transient", 0)?,
            max_periods: self.count("max_periods", 0)?,
            solver: self.solver()?,
            sweep,
        })
    }
}

/// Of each start what it settles on: a name, the states of what is unclear, or the fields of an attractor.
#[pyfunction]
pub(crate) fn _settle_seeds<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    r#box: &Bound<'py, PyAny>,
    wrap: Vec<(i64, f64)>,
    seeds: &Bound<'py, PyAny>,
    options: Options<'py>,
    engine: Engine<'py>,
) -> PyResult<Bound<'py, PyList>> {
    let scene = &scene.0;
    let around = state_box(r#box, wrap, scene)?;
    let seeds = matrix("seeds", seeds)?;
    let options = options.of_attractors(engine.sweep())?;
    let found = engine.run(|| settle_seeds(scene, &around, &seeds, &options))?;
    let each = found.into_iter().map(|own| own.field(py));
    PyList::new(py, each.collect::<PyResult<Vec<_>>>()?)
}

field!(SeedOutcome => |own, py| match own {
    Self::Inside => "inside".field(py)?,
    Self::Lost => "lost".field(py)?,
    Self::Drifting => "drifting".field(py)?,
    Self::Undecided => "undecided".field(py)?,
    Self::Unclear(states) => states.field(py)?,
    Self::Attractor(own) => own.field(py)?,
});

field!(Vec<Attractor> => |own, py| objects(py, own)?);
field!(Attractor => |own, py| fields!(py, own => kind orbit n_periods points exponents pattern reason fraction));

/// An attractor as Python hands it back.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenAttractor<'py> {
    kind: String,
    orbit: Option<PyRef<'py, PyOrbit>>,
    n_periods: usize,
    points: Bound<'py, PyAny>,
    exponents: Vec<f64>,
    pattern: Bound<'py, PyAny>,
    reason: String,
    fraction: f64,
}

impl GivenAttractor<'_> {
    pub fn read(self) -> PyResult<Attractor> {
        Ok(Attractor {
            kind: AttractorKind::from_name(&self.kind)?,
            orbit: self.orbit.map(|orbit| orbit.0.clone()),
            n_periods: self.n_periods,
            points: matrix("points", &self.points)?,
            exponents: self.exponents,
            pattern: pattern(&self.pattern)?,
            reason: self.reason,
            fraction: self.fraction,
        })
    }
}

/// What a start has settled on, as [`_settle_seeds`] gives it.
fn read_outcome(found: &Bound<'_, PyAny>) -> PyResult<SeedOutcome> {
    if found.is_instance_of::<PyDict>() {
        let own = found.extract::<GivenAttractor<'_>>()?.read()?;
        return Ok(SeedOutcome::Attractor(Box::new(own)));
    }
    match found.extract::<String>().as_deref() {
        Ok("inside") => Ok(SeedOutcome::Inside),
        Ok("lost") => Ok(SeedOutcome::Lost),
        Ok("drifting") => Ok(SeedOutcome::Drifting),
        Ok(_) => Ok(SeedOutcome::Undecided),
        Err(_) => Ok(SeedOutcome::Unclear(matrix("points", found)?)),
    }
}

/// Of what starts have settled on, as [`_settle_seeds`] gives it, the attractors, and of each start the place of its own: -1 undecided, -2
/// lost, -3 inside a stop, -4 drifting.
#[pyfunction]
pub(crate) fn _group_attractors<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'py, PyScene>,
    r#box: &Bound<'py, PyAny>,
    wrap: Vec<(i64, f64)>,
    found: Vec<Bound<'py, PyAny>>,
    options: Options<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let scene = &scene.0;
    let around = state_box(r#box, wrap, scene)?;
    let options = options.of_attractors(SweepOptions::default())?;
    let found = found.iter().map(read_outcome);
    let found = found.collect::<PyResult<Vec<_>>>()?;
    let all = interrupt::run(py, false, || {
        gathered_seeds(scene, &around, &found, &options)
    })?;
    let code = |(own, place): (&SeedOutcome, &Option<usize>)| match (place, own) {
        (Some(place), _) => i64::try_from(*place).unwrap_or(i64::MAX),
        (None, SeedOutcome::Lost) => -2,
        (None, SeedOutcome::Inside) => -3,
        (None, SeedOutcome::Drifting) => -4,
        (None, _) => -1,
    };
    let codes: Vec<i64> = found.iter().zip(&all.of_seed).map(code).collect();
    Ok(fields!(py, all => all; of_seed: codes))
}

//! Special points in Python: the branches that meet there, the border that grazes lead to, what becomes of motions beyond.

use crate::branch::{
    self, Beyond, BeyondOptions, Candidate, ContinuationParameter, Special, SpecialKind,
    TouchOutcome,
};
use crate::error::{Error, Result};
use crate::python::made::raised_or;
use crate::python::orbit::PyOrbit;
use crate::python::record::{Field, field, fields, objects};
use crate::python::varied::{Varied, varied};
use crate::python::{argument, interrupt};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;

/// A special point as Python has it.
#[derive(FromPyObject)]
pub(crate) struct GivenSpecial {
    pub kind: String,
    pub parameter: f64,
    pub arclength: f64,
    error: f64,
    pub orbit: Py<PyOrbit>,
    stop: Option<usize>,
    time: Option<f64>,
    direction: Vec<f64>,
    parameter_name: Option<String>,
    between: (f64, f64),
}

impl GivenSpecial {
    /// The point; none of a zero of a monitor.
    pub fn read(&self) -> Option<Special> {
        let kind = SpecialKind::of_name(&self.kind)?;
        Some(Special {
            kind,
            parameter: self.parameter,
            error: self.error,
            arclength: self.arclength,
            orbit: self.orbit.get().0.clone(),
            stop: self.stop,
            time: self.time,
            touch: None,
            rotation: None,
            direction: self.direction.clone().into(),
        })
    }

    /// What varies along its branch.
    pub fn varied<'a>(&self, make: Option<&'a Py<PyAny>>) -> PyResult<Varied<'a>> {
        let scene = self.orbit.get().0.scene();
        varied(
            scene,
            self.parameter_name.as_deref(),
            make,
            Some(self.parameter),
        )
    }
}

/// What a function of the core makes of a special point, which is none of a monitor, and of what varies along its branch.
fn asked<T: Send>(
    py: Python<'_>,
    (point, make): (&GivenSpecial, Option<&Py<PyAny>>),
    progress: bool,
    ask: impl FnOnce(&Special, ContinuationParameter<'_>) -> Result<T> + Send,
) -> PyResult<Option<T>> {
    let Some(special) = point.read() else {
        return Ok(None);
    };
    let varied = point.varied(make)?;
    let raised = Mutex::new(None);
    let found = interrupt::run(py, progress, || {
        varied.with(special.orbit.scene(), &raised, |own| ask(&special, own))
    });
    raised_or(found, raised).map(Some)
}

/// The branches that meet a branch at a special point.
#[pyfunction]
pub(crate) fn _branches(
    py: Python<'_>,
    point: GivenSpecial,
    make: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyAny>> {
    let between = point.between;
    let found = asked(py, (&point, make.as_ref()), false, |special, parameter| {
        branch::branches(special, parameter, between)
    });
    found?.unwrap_or_default().field(py)
}

/// What becomes of a branch at a touch, by the numbers of real multipliers above 1 and below -1 on both sides.
#[pyfunction]
pub(crate) fn _touch_outcome(above_1: [usize; 2], below_minus_1: [usize; 2]) -> &'static str {
    TouchOutcome::of_counts(above_1, below_minus_1).name()
}

/// The border towards which grazes accumulate; none of elastic impacts.
#[pyfunction]
pub(crate) fn _accumulation(
    py: Python<'_>,
    point: GivenSpecial,
    make: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let between = point.between;
    let found = asked(
        py,
        (&point, make.as_ref()),
        progress,
        |special, parameter| branch::accumulation(special, parameter, between),
    );
    found?.flatten().field(py)
}

/// What becomes of a motion beyond a boundary; `kick` gives so many numbers in (-1, 1).
#[pyfunction]
pub(crate) fn _beyond(
    py: Python<'_>,
    point: GivenSpecial,
    make: Option<Py<PyAny>>,
    delta: Option<f64>,
    periods: usize,
    kick: Py<PyAny>,
) -> PyResult<Bound<'_, PyAny>> {
    let between = point.between;
    let options = BeyondOptions { delta, periods };
    let kick = &mut |count: usize| {
        let drawn = |py: Python<'_>| kick.call1(py, (count,))?.extract::<Vec<f64>>(py);
        Python::attach(drawn).map_err(Error::function)
    };
    let found = asked(py, (&point, make.as_ref()), false, |special, parameter| {
        branch::beyond(special, parameter, between, options, kick)
    });
    found?.field(py)
}

field!(Vec<Special>, Vec<Candidate> => |own, py| objects(py, own)?);

field!(Special => |own, py| {
    let data = PyDict::new(py);
    if let Some(rotation) = own.rotation {
        data.set_item("rotation_number", rotation)?;
    }
    if let Some(touch) = &own.touch {
        for (name, [before, after]) in [
            ("n_above_1", touch.n_above_1().map(|count| count as f64)),
            ("n_below_minus_1", touch.n_below_minus_1().map(|count| count as f64)),
            ("trace", touch.traces()),
        ] {
            data.set_item(format!("{name}_before"), before)?;
            data.set_item(format!("{name}_after"), after)?;
        }
    }
    fields!(py, own => kind parameter error arclength orbit stop time direction; data: data)
});

field!(Candidate => |own, py| {
    let side = if own.is_above { 1i64 } else { -1 };
    fields!(py, own => orbit parameter; side: side)
});

field!(Beyond => |own, py| fields!(py, own => outcome candidates attractor reason));

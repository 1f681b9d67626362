//! Forcing in Python.

use crate::model::{Forcing, Harmonic};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{complex_vector, out_complex, out_vector};
use crate::python::model::base_motion::PyBaseMotion;
use crate::python::model::fourier::PyFourier;
use crate::python::model::load::{PyBaseAcceleration, PyLoad};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

/// Harmonic force ``Re(amplitude exp(i (frequency t + phase)))`` on the coordinates.
///
/// Parameters
/// ----------
/// amplitude : array_like, shape (n,), real or complex
///     Force amplitude; a real one is a cosine.
/// frequency : float
///     Circular frequency [rad/s], > 0.
/// phase : float, default 0.0
///     Phase [rad]; a sine has -pi/2.
///
/// Raises
/// ------
/// ValueError
///     Numbers that are not finite, a frequency that is not positive.
#[pyclass(name = "Harmonic", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyHarmonic(pub Harmonic);

#[pymethods]
impl PyHarmonic {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(amplitude, frequency, phase=0.0)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (amplitude, frequency, phase=0.0))]
    fn made(
        amplitude: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::frequency)] frequency: f64,
        #[pyo3(from_py_with = argument::phase)] phase: f64,
    ) -> PyResult<Self> {
        Ok(Self(Harmonic::new(
            complex_vector("amplitude", amplitude)?,
            frequency,
            phase,
        )?))
    }

    /// Force amplitude [N], shape (n,), real where it has no imaginary part.
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let amplitude = self.0.amplitude();
        if amplitude.iter().all(|z| z.im == 0.0) {
            out_vector(py, &amplitude.map(|z| z.re)).into_any()
        } else {
            out_complex(py, amplitude).into_any()
        }
    }

    /// Circular frequency [rad/s].
    #[getter]
    fn frequency(&self) -> f64 {
        self.0.frequency()
    }

    /// Phase [rad].
    #[getter]
    fn phase(&self) -> f64 {
        self.0.phase()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let amplitude = self.amplitude(py).repr()?;
        Ok(format!(
            "Harmonic({amplitude}, frequency={}, phase={})",
            self.0.frequency(),
            self.0.phase()
        ))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, f64, f64) {
        (self.amplitude(py), self.0.frequency(), self.0.phase())
    }
}

/// One forcing of those that a scene may have.
fn one(value: &Bound<'_, PyAny>) -> Option<Forcing> {
    macro_rules! of_class {
        ($($class:ident),*) => {$(
            if let Ok(f) = value.cast::<$class>() {
                return Some(f.get().0.clone().into());
            }
        )*};
    }
    of_class!(
        PyHarmonic,
        PyBaseMotion,
        PyFourier,
        PyLoad,
        PyBaseAcceleration
    );
    None
}

/// What drives a scene: None, one, or a sequence.
pub(crate) fn forcing(value: Option<&Bound<'_, PyAny>>) -> PyResult<Forcing> {
    let Some(value) = value.filter(|v| !v.is_none()) else {
        return Ok(Forcing::Unforced);
    };
    if let Some(forcing) = one(value) {
        return Ok(forcing);
    }
    let wrong = |argument: &str, value: &Bound<'_, PyAny>| {
        let kind = value.get_type().name()?;
        Err(PyTypeError::new_err(format!(
            "{argument} is {kind}, but a Harmonic, a Fourier, a BaseMotion, a Load or a BaseAcceleration is needed, a sequence of such, \
             or None"
        )))
    };
    if value.is_instance_of::<PyString>() || value.try_iter().is_err() {
        return wrong("forcing", value);
    }
    let mut several = Vec::new();
    for (i, value) in value.try_iter()?.enumerate() {
        let value = value?;
        match one(&value) {
            Some(forcing) => several.push(forcing),
            None => return wrong(&format!("forcing[{i}]"), &value),
        }
    }
    Ok(several.into())
}

/// The same as Python has it: None, one object, or a tuple.
pub(crate) fn out_forcing(py: Python<'_>, forcing: &Forcing) -> PyResult<Option<Py<PyAny>>> {
    Ok(Some(match forcing {
        Forcing::Unforced => return Ok(None),
        Forcing::Harmonic(f) => Py::new(py, PyHarmonic(f.clone()))?.into_any(),
        Forcing::BaseMotion(f) => Py::new(py, PyBaseMotion(f.clone()))?.into_any(),
        Forcing::Fourier(f) => Py::new(py, PyFourier(f.clone()))?.into_any(),
        Forcing::Load(f) => Py::new(py, PyLoad(f.clone()))?.into_any(),
        Forcing::BaseAcceleration(f) => Py::new(py, PyBaseAcceleration(f.clone()))?.into_any(),
        Forcing::Several(all) => {
            let all = all.iter().map(|f| out_forcing(py, f));
            let all: Vec<_> = all.collect::<PyResult<_>>()?;
            PyTuple::new(py, all)?.into_any().unbind()
        }
    }))
}

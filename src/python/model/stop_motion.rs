//! Motions of stops in Python: a `Harmonic`, a `Fourier` or a signal.

use crate::model::{Forcing, StopMotion};
use crate::python::model::forcing::PyHarmonic;
use crate::python::model::fourier::PyFourier;
use crate::python::model::signal::{PySignal, signal};
use pyo3::prelude::*;

/// A motion as users give one.
pub(super) fn motion(value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<StopMotion>> {
    let Some(value) = value.filter(|v| !v.is_none()) else {
        return Ok(None);
    };
    if let Ok(motion) = value.cast::<PyHarmonic>() {
        return Ok(Some(StopMotion::harmonic(motion.get().0.clone())?));
    }
    if let Ok(motion) = value.cast::<PyFourier>() {
        return Ok(Some(StopMotion::periodic(motion.get().0.clone())?));
    }
    Ok(Some(StopMotion::signal(signal("motion", value)?)?))
}

/// The same as Python has it.
pub(super) fn out_motion(
    py: Python<'_>,
    motion: Option<&StopMotion>,
) -> PyResult<Option<Py<PyAny>>> {
    let Some(motion) = motion else {
        return Ok(None);
    };
    Ok(match motion.as_forcing() {
        Forcing::Harmonic(f) => Some(Py::new(py, PyHarmonic(f.clone()))?.into_any()),
        Forcing::Fourier(f) => Some(Py::new(py, PyFourier(f.clone()))?.into_any()),
        Forcing::Load(f) => Some(Py::new(py, PySignal(f.signal().clone()))?.into_any()),
        _ => None,
    })
}

/// `, motion=...`, or nothing.
pub(super) fn shown_motion(py: Python<'_>, motion: Option<&StopMotion>) -> PyResult<String> {
    Ok(match out_motion(py, motion)? {
        Some(motion) => format!(", motion={}", motion.bind(py).repr()?),
        None => String::new(),
    })
}

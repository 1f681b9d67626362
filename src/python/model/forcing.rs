//! Forcing in Python.

use crate::model::{BaseMotion, Forcing, Harmonic};
use crate::python::argument;
use crate::python::array::{complex_vector, out_complex, out_vector};
use crate::python::model::fourier::PyFourier;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

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
    #[pyo3(signature = (amplitude, frequency, phase=0.0))]
    fn new(
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

    /// Force amplitude, shape (n,), real where it has no imaginary part.
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

/// Base displacement ``amplitude cos(frequency t + phase)`` of a pendulum, or of a linear system with an influence vector.
///
/// The force it makes grows with ``frequency**2``.
///
/// Parameters
/// ----------
/// amplitude : float
///     Displacement amplitude (in units of ``l1`` for ``DoublePendulum`` and ``paper_system``).
/// frequency : float
///     Circular frequency [rad/s], > 0.
/// phase : float, default 0.0
///     Phase [rad].
///
/// Raises
/// ------
/// ValueError
///     Numbers that are not finite, a frequency that is not positive.
#[pyclass(name = "BaseMotion", module = "vibroimpact", frozen)]
#[derive(Clone, Copy)]
pub(crate) struct PyBaseMotion(pub BaseMotion);

#[pymethods]
impl PyBaseMotion {
    #[new]
    #[pyo3(signature = (amplitude, frequency, phase=0.0))]
    fn new(
        #[pyo3(from_py_with = argument::amplitude)] amplitude: f64,
        #[pyo3(from_py_with = argument::frequency)] frequency: f64,
        #[pyo3(from_py_with = argument::phase)] phase: f64,
    ) -> PyResult<Self> {
        Ok(Self(BaseMotion::new(amplitude, frequency, phase)?))
    }

    /// Displacement amplitude.
    #[getter]
    fn amplitude(&self) -> f64 {
        self.0.amplitude()
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

    fn __repr__(&self) -> String {
        let f = &self.0;
        format!(
            "BaseMotion({}, frequency={}, phase={})",
            f.amplitude(),
            f.frequency(),
            f.phase()
        )
    }

    fn __getnewargs__(&self) -> (f64, f64, f64) {
        (self.0.amplitude(), self.0.frequency(), self.0.phase())
    }
}

pub(crate) fn forcing(value: Option<&Bound<'_, PyAny>>) -> PyResult<Forcing> {
    let Some(value) = value.filter(|v| !v.is_none()) else {
        return Ok(Forcing::Unforced);
    };
    if let Ok(f) = value.cast::<PyHarmonic>() {
        return Ok(f.get().0.clone().into());
    }
    if let Ok(f) = value.cast::<PyBaseMotion>() {
        return Ok(f.get().0.into());
    }
    if let Ok(f) = value.cast::<PyFourier>() {
        return Ok(f.get().0.clone().into());
    }
    Err(PyTypeError::new_err(format!(
        "forcing is {}, but a Harmonic, a Fourier, a BaseMotion or None is needed",
        value.get_type().name()?
    )))
}

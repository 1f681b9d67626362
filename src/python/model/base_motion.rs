//! Periodic motions of the base in Python.

use crate::model::BaseMotion;
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{complex_vector, out_complex};
use nalgebra::{Complex, DVector};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Periodic displacement of the base of a pendulum, or of a linear system with an influence vector.
///
/// It is ``amplitude cos(frequency t + phase)``, with several harmonics ``Re(sum_k amplitude[k-1] exp(i k (frequency t + phase)))``.
/// The force it makes grows with ``frequency**2``; that of the k-th harmonic with ``(k frequency)**2``.
///
/// Parameters
/// ----------
/// amplitude : float or array_like, shape (K,), real or complex
///     Displacement amplitude, or those of K harmonics (in units of ``l1`` for ``DoublePendulum`` and ``paper_system``).
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
#[derive(Clone)]
pub(crate) struct PyBaseMotion(pub BaseMotion);

/// The amplitudes of a base motion: a number, or one for each harmonic.
pub(crate) fn amplitudes(value: &Bound<'_, PyAny>) -> PyResult<DVector<Complex<f64>>> {
    complex_vector("amplitude", value)
}

#[pymethods]
impl PyBaseMotion {
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
        let amplitudes = amplitudes(amplitude)?;
        Ok(Self(BaseMotion::of_harmonics(
            amplitudes, frequency, phase,
        )?))
    }

    /// Displacement amplitude [m]: a float, or of several harmonics or with an imaginary part complex, shape (K,).
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let amplitudes = self.0.amplitudes().iter().map(|a| a[0]);
        let amplitudes = DVector::from_iterator(self.0.n_harmonics(), amplitudes);
        match amplitudes.as_slice() {
            [one] if one.im == 0.0 => Ok(one.re.into_pyobject(py)?.into_any()),
            _ => Ok(out_complex(py, &amplitudes).into_any()),
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
        Ok(format!(
            "BaseMotion({}, frequency={}, phase={})",
            self.amplitude(py)?.repr()?,
            self.0.frequency(),
            self.0.phase()
        ))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, f64, f64)> {
        Ok((self.amplitude(py)?, self.frequency(), self.phase()))
    }
}

//! Periodic forces in Python.

use crate::model::Fourier;
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{Numbers, numbers, out_matrix, out_vector, rows, vector};
use nalgebra::{Complex, DMatrix, DVector};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Periodic force ``mean + Re(sum_k amplitudes[k-1] exp(i k (frequency t + phase)))`` on the coordinates, k = 1 to K.
///
/// Parameters
/// ----------
/// amplitudes : array_like, shape (K, n) or (K,) for one degree of freedom, real or complex
///     Amplitudes of the harmonics, the first that of the frequency itself; real ones are cosines.
/// frequency : float
///     Circular frequency of the first harmonic [rad/s], > 0.
/// phase : float, default 0.0
///     Phase of the first harmonic [rad]; that of the k-th is k times it.
/// mean : array_like, shape (n,), optional
///     A constant force beside them.
///
/// Raises
/// ------
/// ValueError
///     No harmonic, numbers that are not finite, a frequency that is not positive, a mean of another length.
///
/// Notes
/// -----
/// Simulated by every method but ``"taylor"``; linear scenes fly exactly, each harmonic by its own rotation. ``periodic_orbits`` and
/// ``existence_map`` find every orbit of one instant; patterns of two instants, free parameters, and modes that repeat by themselves
/// are solved under one harmonic. ``find_orbit`` takes any.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> force = vi.Fourier([2.0, -1j], 1.5)  # 2 cos(1.5 t) + sin(3 t)
/// >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 4.0), force, vi.Stop(0, 0.5, 0.8))
/// >>> vi.simulate(scene, 0.0, 0.0, (0.0, 20.0)).status
/// 'finished'
#[pyclass(name = "Fourier", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyFourier(pub Fourier);

#[pymethods]
impl PyFourier {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(amplitudes, frequency, phase=0.0, *, mean=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (amplitudes, frequency, phase=0.0, *, mean=None))]
    fn made(
        amplitudes: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::frequency)] frequency: f64,
        #[pyo3(from_py_with = argument::phase)] phase: f64,
        mean: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let Numbers { shape, values } = numbers::<Complex<f64>>("amplitudes", amplitudes)?;
        let n = match *shape {
            [] | [_] => 1,
            [_, n] => n,
            _ => {
                let message = "amplitudes has more than two axes, but shape (K, n) is needed";
                return Err(PyValueError::new_err(message));
            }
        };
        let harmonics = values.chunks(n.max(1)).map(DVector::from_column_slice);
        let force = Fourier::new(harmonics.collect(), frequency, phase)?;
        Ok(Self(match mean {
            Some(mean) => force.with_mean(vector("mean", mean)?)?,
            None => force,
        }))
    }

    /// The force whose first harmonics, and whose mean, are those of samples over one period.
    ///
    /// It goes through the samples where they have no other harmonics.
    ///
    /// Parameters
    /// ----------
    /// samples : array_like, shape (m, n) or (m,) for one degree of freedom
    ///     The force at m times of one period, equally spaced, the first at t = 0.
    /// frequency : float
    ///     Circular frequency [rad/s], > 0.
    /// n_harmonics : int
    ///     How many harmonics; fewer than m/2.
    ///
    /// Returns
    /// -------
    /// Fourier
    ///     The force.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     No harmonic, too few samples, numbers that are not finite, a frequency that is not positive.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import vibroimpact as vi
    /// >>> t = np.arange(64) / 64
    /// >>> saw = vi.Fourier.fit(t - 0.5, 2 * np.pi, 3)
    /// >>> saw.amplitudes.shape
    /// (3, 1)
    #[staticmethod]
    fn fit(
        samples: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::frequency)] frequency: f64,
        #[pyo3(from_py_with = argument::n_harmonics)] n_harmonics: i64,
    ) -> PyResult<Self> {
        let samples = rows("samples", samples, 1)?;
        let n_harmonics = usize::try_from(n_harmonics).unwrap_or(0);
        Ok(Self(Fourier::fit(&samples, frequency, n_harmonics)?))
    }

    /// Amplitudes of the harmonics, shape (K, n), real where none has an imaginary part.
    #[getter]
    fn amplitudes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let amplitudes = DMatrix::from_columns(self.0.amplitudes()).transpose();
        Ok(if amplitudes.iter().all(|z| z.im == 0.0) {
            out_matrix(py, &amplitudes.map(|z| z.re))?.into_any()
        } else {
            out_matrix(py, &amplitudes)?.into_any()
        })
    }

    /// Circular frequency of the first harmonic [rad/s].
    #[getter]
    fn frequency(&self) -> f64 {
        self.0.frequency()
    }

    /// Phase of the first harmonic [rad].
    #[getter]
    fn phase(&self) -> f64 {
        self.0.phase()
    }

    /// The constant force, shape (n,), or None.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        self.0.mean().map(|mean| out_vector(py, mean).into_any())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let mean = match self.mean(py) {
            Some(mean) => format!(", mean={}", mean.repr()?),
            None => String::new(),
        };
        Ok(format!(
            "Fourier({}, frequency={}, phase={}{mean})",
            self.amplitudes(py)?.repr()?,
            self.0.frequency(),
            self.0.phase()
        ))
    }

    #[allow(clippy::type_complexity, reason = "what pickle asks for")]
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Bound<'py, PyAny>, f64, f64), Bound<'py, PyDict>)> {
        let keywords = PyDict::new(py);
        keywords.set_item("mean", self.mean(py))?;
        Ok((
            (self.amplitudes(py)?, self.frequency(), self.phase()),
            keywords,
        ))
    }
}

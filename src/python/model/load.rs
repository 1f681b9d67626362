//! Forcing after signals in Python: a force along a direction, an acceleration of the base.

use crate::model::{BaseAcceleration, Load, Normal};
use crate::python::answered::answered;
use crate::python::array::out_vector;
use crate::python::model::normal::normal;
use crate::python::model::signal::{PySignal, signal};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Force ``direction * signal(t)`` on the coordinates.
///
/// Exact in the flights of linear scenes, polynomial by polynomial; in steps and series as well.
///
/// Parameters
/// ----------
/// direction : int or array_like, shape (n,)
///     Index of a coordinate, counted from 0, or a vector.
/// signal : (t, values), PPoly, or Signal
///     Samples with straight lines between them, piecewise polynomials (SciPy's splines are such), or a ``Signal``; zero outside.
///
/// Raises
/// ------
/// ValueError
///     Times that do not increase, as many values as times are not given, numbers that are not finite.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> blow = vi.Load(0, ([0.0, 0.5, 1.0], [0.0, 3.0, 0.0]))
/// >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 4.0), blow, vi.Stop(0, 0.2, 0.8))
/// >>> vi.simulate(scene, 0.0, 0.0, (0.0, 10.0)).status
/// 'finished'
#[pyclass(name = "Load", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyLoad(pub Load);

#[pymethods]
impl PyLoad {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(direction, signal)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (direction, signal))]
    fn made(direction: &Bound<'_, PyAny>, signal: &Bound<'_, PyAny>) -> PyResult<Self> {
        let direction = normal("direction", direction)?;
        Ok(Self(Load::new(direction, self::signal("signal", signal)?)?))
    }

    /// Index of a coordinate, or the direction, shape (n,).
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.0.direction() {
            Normal::Coordinate(i) => i.into_pyobject(py)?.into_any(),
            Normal::Vector(d) => out_vector(py, d).into_any(),
        })
    }

    /// The signal.
    #[getter]
    fn signal(&self) -> PySignal {
        PySignal(self.0.signal().clone())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let direction = self.direction(py)?;
        Ok(format!(
            "Load({}, {})",
            direction.repr()?,
            self.signal().__repr__()
        ))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, PySignal)> {
        Ok((self.direction(py)?, self.signal()))
    }
}

/// Base whose acceleration follows a signal, such as ground motion, under a pendulum or a linear system with an influence vector.
///
/// Coordinates are relative to the base. A pendulum's is horizontal, of a ``DoublePendulum`` in ``l1`` per unit of time squared.
///
/// Parameters
/// ----------
/// signal : (t, values), PPoly, or Signal
///     As in ``Load``.
///
/// Raises
/// ------
/// ValueError
///     As in ``Load``.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> import vibroimpact as vi
/// >>> t = np.linspace(0.0, 2.0, 201)
/// >>> record = vi.BaseAcceleration((t, np.sin(8 * t) * np.exp(-t)))
/// >>> frame = vi.LinearSystem(1.0, 0.4, 64.0, influence=1.0)
/// >>> scene = vi.Scene(frame, record, vi.Stop(0, 0.005, 0.6))
/// >>> vi.simulate(scene, 0.0, 0.0, (0.0, 4.0)).status
/// 'finished'
#[pyclass(name = "BaseAcceleration", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyBaseAcceleration(pub BaseAcceleration);

#[pymethods]
impl PyBaseAcceleration {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(signal)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (signal))]
    fn made(signal: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(BaseAcceleration::new(self::signal("signal", signal)?)))
    }

    /// The acceleration.
    #[getter]
    fn signal(&self) -> PySignal {
        PySignal(self.0.signal().clone())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!("BaseAcceleration({})", self.signal().__repr__())
    }

    fn __getnewargs__(&self) -> (PySignal,) {
        (self.signal(),)
    }
}

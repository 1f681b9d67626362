//! Pendulums in Python.

use crate::model::{self, DoublePendulum, PendulumChain, System};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{coefficient, out_matrix, out_vector, vector};
use crate::python::model::bad;
use crate::python::model::linear::PyLinearSystem;
use nalgebra::DVector;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Double pendulum of the source paper's eq. (3), nonlinear and dimensionless.
///
/// Time is in units of ``1/(w1 sqrt(1 + m))`` with ``w1**2 = g/l1``, base amplitudes in units of ``l1``; angles are absolute,
/// from the downward vertical, in radians.
///
/// Parameters
/// ----------
/// mass_ratio : float
///     ``m2/m1`` > 0.
/// length_ratio : float
///     ``l1/l2`` > 0.
/// damping : pair of float or array_like, shape (2, 2), default (0, 0)
///     Joint dampers ``(p1, p2)``, or any damping matrix of the symmetric form.
///
/// Raises
/// ------
/// ValueError
///     A ratio that is not positive, a damper that is not finite.
#[pyclass(name = "DoublePendulum", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyDoublePendulum(pub DoublePendulum);

#[pymethods]
impl PyDoublePendulum {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(mass_ratio, length_ratio, damping=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (mass_ratio, length_ratio, damping=None))]
    fn made(
        #[pyo3(from_py_with = argument::mass_ratio)] mass_ratio: f64,
        #[pyo3(from_py_with = argument::length_ratio)] length_ratio: f64,
        damping: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let Some(damping) = damping else {
            return Ok(Self(DoublePendulum::new(
                mass_ratio,
                length_ratio,
                (0.0, 0.0),
            )?));
        };
        match coefficient("damping", damping)? {
            model::Coefficient::Dense(c) => Ok(Self(DoublePendulum::with_damping_matrix(
                mass_ratio,
                length_ratio,
                c,
            )?)),
            model::Coefficient::Diagonal(p) if p.len() == 2 => Ok(Self(DoublePendulum::new(
                mass_ratio,
                length_ratio,
                (p[0], p[1]),
            )?)),
            model::Coefficient::Diagonal(p) => Err(bad(format!(
                "damping has shape ({},), but (2,) or (2, 2) is needed",
                p.len()
            ))),
        }
    }

    /// Number of degrees of freedom: 2.
    #[getter]
    fn n_dof(&self) -> usize {
        System::from(self.0.clone()).n_dof()
    }

    /// ``m2/m1`` [-].
    #[getter]
    fn mass_ratio(&self) -> f64 {
        self.0.mass_ratio()
    }

    /// ``l1/l2`` [-].
    #[getter]
    fn length_ratio(&self) -> f64 {
        self.0.length_ratio()
    }

    /// Damping matrix [N m s], shape (2, 2).
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, self.0.damping())
    }

    /// The linear system about the hanging equilibrium, influence vector filled in.
    fn linearise(&self) -> PyResult<PyLinearSystem> {
        Ok(PyLinearSystem(self.0.linearise()?))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!(
            "DoublePendulum(mass_ratio={}, length_ratio={})",
            self.0.mass_ratio(),
            self.0.length_ratio()
        )
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(f64, f64, Bound<'py, PyArray2<f64>>)> {
        Ok((
            self.0.mass_ratio(),
            self.0.length_ratio(),
            self.damping(py)?,
        ))
    }
}

/// Chain of N pendulum links in physical units, nonlinear.
///
/// Parameters
/// ----------
/// masses : array_like, shape (N,)
///     Point masses, > 0.
/// lengths : array_like, shape (N,)
///     Link lengths, > 0.
/// damping : float or array_like, shape (N,) or (N, N), default 0.0
///     Joint dampers, one for all or one each, or any damping matrix.
/// gravity : float, default 9.81
///     Gravity [m/s^2].
///
/// Raises
/// ------
/// ValueError
///     Arrays of different lengths, masses or lengths that are not positive, numbers that are not finite.
#[pyclass(name = "PendulumChain", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyPendulumChain(pub PendulumChain);

#[pymethods]
impl PyPendulumChain {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(masses, lengths, damping=None, gravity=9.81)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (masses, lengths, damping=None, gravity=9.81))]
    fn made(
        masses: &Bound<'_, PyAny>,
        lengths: &Bound<'_, PyAny>,
        damping: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::gravity)] gravity: f64,
    ) -> PyResult<Self> {
        let (masses, lengths) = (vector("masses", masses)?, vector("lengths", lengths)?);
        let n = masses.len();
        let damping = match damping {
            None => model::Coefficient::Diagonal(DVector::zeros(n)),
            Some(damping) => coefficient("damping", damping)?,
        };
        Ok(Self(match damping {
            model::Coefficient::Dense(c) => {
                PendulumChain::with_damping_matrix(masses, lengths, c, gravity)?
            }
            model::Coefficient::Diagonal(c) if c.len() == 1 => {
                PendulumChain::new(masses, lengths, &DVector::from_element(n, c[0]), gravity)?
            }
            model::Coefficient::Diagonal(c) => PendulumChain::new(masses, lengths, &c, gravity)?,
        }))
    }

    /// Number of links.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Point masses [kg], shape (N,).
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.masses())
    }

    /// Link lengths [m], shape (N,).
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.lengths())
    }

    /// Damping matrix [N m s], shape (N, N).
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, self.0.damping())
    }

    /// Gravity [m/s^2].
    #[getter]
    fn gravity(&self) -> f64 {
        self.0.gravity()
    }

    /// The linear system about the hanging equilibrium, influence vector filled in.
    fn linearise(&self) -> PyResult<PyLinearSystem> {
        Ok(PyLinearSystem(self.0.linearise()?))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!(
            "PendulumChain(n_dof={}, gravity={})",
            self.0.n_dof(),
            self.0.gravity()
        )
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let gravity = self.0.gravity().into_pyobject(py)?.into_any();
        PyTuple::new(
            py,
            [
                self.masses(py).into_any(),
                self.lengths(py).into_any(),
                self.damping(py)?.into_any(),
                gravity,
            ],
        )
    }
}

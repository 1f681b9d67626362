//! Linear systems in Python.

use crate::model::{self, LinearSystem};
use crate::python::argument;
use crate::python::array::{coefficient, out_matrix, out_vector, vector};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

fn shape_of(c: &model::Coefficient) -> String {
    match c {
        model::Coefficient::Diagonal(d) => format!("diagonal ({},)", d.len()),
        model::Coefficient::Dense(m) => format!("({}, {})", m.nrows(), m.ncols()),
    }
}

fn out_coefficient<'py>(py: Python<'py>, c: &model::Coefficient) -> PyResult<Bound<'py, PyAny>> {
    Ok(match c {
        model::Coefficient::Diagonal(d) => out_vector(py, d).into_any(),
        model::Coefficient::Dense(m) => out_matrix(py, m)?.into_any(),
    })
}

/// Linear system ``M q'' + C q' + K q = f0 + forcing`` with n degrees of freedom.
///
/// Parameters
/// ----------
/// mass : array_like, shape (n, n) or (n,)
///     Mass matrix M, symmetric positive definite; ``(n,)`` is a diagonal. For n = 1 plain numbers will do.
/// damping : array_like, shape (n, n) or (n,)
///     Damping matrix C, any real matrix.
/// stiffness : array_like, shape (n, n) or (n,)
///     Stiffness matrix K, any real matrix, singular or zero too.
/// load : array_like, shape (n,), optional
///     Constant force f0.
/// influence : array_like, shape (n,), optional
///     Influence vector r: a base displacement u adds the force ``-M r u''``.
///
/// Raises
/// ------
/// ValueError
///     Shapes that do not fit together, numbers that are not finite, a mass that is not symmetric positive definite.
///
/// Examples
/// --------
/// Modes of a finite-element model: unit masses, 2 zeta w, w**2.
///
/// >>> import numpy as np
/// >>> import vibroimpact as vi
/// >>> w = np.array([1.0, 3.0])
/// >>> vi.LinearSystem(np.ones(2), 2 * 0.01 * w, w**2).n_dof
/// 2
#[pyclass(name = "LinearSystem", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyLinearSystem(pub LinearSystem);

impl argument::ArgumentKind for PyRef<'_, PyLinearSystem> {
    const KIND: &'static str = "a LinearSystem";
}

#[pymethods]
impl PyLinearSystem {
    #[new]
    #[pyo3(signature = (mass, damping, stiffness, load=None, influence=None))]
    fn new(
        mass: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        load: Option<&Bound<'_, PyAny>>,
        influence: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut system = LinearSystem::new(
            coefficient("mass", mass)?,
            coefficient("damping", damping)?,
            coefficient("stiffness", stiffness)?,
        )?;
        if let Some(load) = load {
            system = system.with_load(vector("load", load)?)?;
        }
        if let Some(influence) = influence {
            system = system.with_influence(vector("influence", influence)?)?;
        }
        Ok(Self(system))
    }

    /// Number of degrees of freedom.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Mass matrix, shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.mass())
    }

    /// Damping matrix, shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.damping())
    }

    /// Stiffness matrix, shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn stiffness<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.stiffness())
    }

    /// Constant force, shape (n,).
    #[getter]
    fn load<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.load())
    }

    /// Influence vector, shape (n,), or None.
    #[getter]
    fn influence<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.influence().map(|r| out_vector(py, r))
    }

    /// The system itself: it is linear already.
    fn linearise(&self) -> Self {
        self.clone()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let s = &self.0;
        let load = if s.load().amax() > 0.0 { ", load" } else { "" };
        let influence = if s.influence().is_some() {
            ", influence"
        } else {
            ""
        };
        format!(
            "LinearSystem(n_dof={}, mass {}, damping {}, stiffness {}{load}{influence})",
            s.n_dof(),
            shape_of(s.mass()),
            shape_of(s.damping()),
            shape_of(s.stiffness())
        )
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(
            py,
            [
                self.mass(py)?,
                self.damping(py)?,
                self.stiffness(py)?,
                self.load(py).into_any(),
                self.influence(py).into_pyobject(py)?.into_any(),
            ],
        )
    }
}

//! Linear systems in Python.

use crate::model::{self, LinearSystem, rayleigh_coefficients};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{Numbers, coefficient, numbers, out_matrix, out_vector, vector};
use nalgebra::DVector;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

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

/// The largest order of a sparse matrix that is taken: written out, one of this order has 32 MB. [work]
const MOST_SPARSE: usize = 2000;

/// A coefficient matrix; a sparse array of SciPy, which its methods tell, is written out.
fn coefficient_or_sparse(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<model::Coefficient> {
    if !(value.hasattr("toarray")? && value.hasattr("nnz")?) {
        return coefficient(argument, value);
    }
    let shape: Vec<usize> = value.getattr("shape")?.extract()?;
    if let Some(n) = shape.iter().find(|&&n| n > MOST_SPARSE) {
        return Err(PyValueError::new_err(format!(
            "{argument} is sparse with {n} rows or columns, but LinearSystem takes sparse matrices of up to {MOST_SPARSE}: \
             vibroimpact.reduce makes a LinearSystem of the lowest modes of larger ones"
        )));
    }
    coefficient(argument, &value.call_method0("toarray")?)
}

/// Whether there is no damping: None, or the number zero.
fn is_none_or_zero(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    let is_zero = || value.extract::<f64>().is_ok_and(|x| x == 0.0);
    Ok(value.is_none() || (!value.hasattr("__len__")? && is_zero()))
}

/// The coefficients of Rayleigh damping from damping ratios at two frequencies.
#[pyfunction]
pub(crate) fn _rayleigh_coefficients(
    first: (f64, f64),
    second: (f64, f64),
) -> PyResult<(f64, f64)> {
    Ok(rayleigh_coefficients([first, second])?)
}

/// Linear system ``M q'' + C q' + K q = f0 + forcing`` with n degrees of freedom.
///
/// Parameters
/// ----------
/// mass : array_like or sparse array, shape (n, n) or (n,)
///     Mass matrix M, symmetric positive definite; ``(n,)`` is a diagonal. For n = 1 plain numbers will do. Sparse arrays of SciPy are
///     taken, and written out, for n up to 2000: ``vi.reduce`` takes larger ones.
/// damping : array_like or sparse array, shape (n, n) or (n,), or None
///     Damping matrix C, any real matrix; None, or the number 0: no damping.
/// stiffness : array_like or sparse array, shape (n, n) or (n,)
///     Stiffness matrix K, any real matrix, singular or zero too.
/// load : array_like, shape (n,), optional
///     Constant force f0.
/// influence : array_like, shape (n,), optional
///     Influence vector r: a base displacement u adds the force ``-M r u''``.
///
/// Raises
/// ------
/// ValueError
///     Shapes that do not fit together, numbers that are not finite, a mass that is not symmetric positive definite, a sparse array
///     of more than 2000 rows.
///
/// See Also
/// --------
/// LinearSystem.from_modes, reduce, rayleigh_damping
///
/// Examples
/// --------
/// Two masses on a chain of springs.
///
/// >>> import vibroimpact as vi
/// >>> vi.LinearSystem([1.0, 2.0], None, [[3.0, -1.0], [-1.0, 1.0]]).n_dof
/// 2
#[pyclass(name = "LinearSystem", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyLinearSystem(pub LinearSystem);

impl argument::ArgumentKind for PyRef<'_, PyLinearSystem> {
    const KIND: &'static str = "a LinearSystem";
}

fn with_forces(
    mut system: LinearSystem,
    load: Option<&Bound<'_, PyAny>>,
    influence: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyLinearSystem> {
    if let Some(load) = load {
        system = system.with_load(vector("load", load)?)?;
    }
    if let Some(influence) = influence {
        system = system.with_influence(vector("influence", influence)?)?;
    }
    Ok(PyLinearSystem(system))
}

#[pymethods]
impl PyLinearSystem {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(mass, damping, stiffness, load=None, influence=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (mass, damping, stiffness, load=None, influence=None))]
    fn made(
        mass: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        load: Option<&Bound<'_, PyAny>>,
        influence: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let m = coefficient_or_sparse("mass", mass)?;
        let system = if is_none_or_zero(damping)? {
            LinearSystem::undamped(m, coefficient_or_sparse("stiffness", stiffness)?)?
        } else {
            let c = coefficient_or_sparse("damping", damping)?;
            LinearSystem::new(m, c, coefficient_or_sparse("stiffness", stiffness)?)?
        };
        with_forces(system, load, influence)
    }

    /// A linear system in the coordinates of its modes.
    ///
    /// It has unit modal masses, damping ``2 zeta w`` and stiffness ``w**2``.
    ///
    /// Parameters
    /// ----------
    /// frequencies : array_like, shape (m,)
    ///     Natural frequencies w [rad/s], not negative; zero is a rigid-body mode.
    /// damping_ratios : float or array_like, shape (m,)
    ///     Damping ratios zeta [-], not negative; a number is that of every mode.
    /// load : array_like, shape (m,), optional
    ///     Constant modal force.
    /// influence : array_like, shape (m,), optional
    ///     Influence vector in the modes, ``shapes.T @ M @ r``.
    ///
    /// Returns
    /// -------
    /// LinearSystem
    ///     Its coordinates are the amplitudes of the modes.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Arrays of different length, numbers that are negative or not finite.
    ///
    /// Notes
    /// -----
    /// Of mode shapes of shape (n, m) that are normalised to unit modal mass, row i is the direction of coordinate i of the structure: the
    /// normal of a stop there, the amplitude of a unit force there, and ``shapes[i] @ q`` is its displacement.
    ///
    /// Examples
    /// --------
    /// Two modes of a measured structure, 1 % damping, and a stop at the coordinate of the second row of the mode shapes.
    ///
    /// >>> import numpy as np
    /// >>> import vibroimpact as vi
    /// >>> shapes = np.array([[0.5, 1.1], [1.0, -0.6]])
    /// >>> system = vi.LinearSystem.from_modes([2.0, 7.0], 0.01)
    /// >>> scene = vi.Scene(system, vi.Harmonic(shapes[0], 2.1), vi.Stop(shapes[1], 0.1, 0.8))
    /// >>> system.stiffness
    /// array([ 4., 49.])
    #[staticmethod]
    #[pyo3(signature = (frequencies, damping_ratios, *, load=None, influence=None))]
    fn from_modes(
        frequencies: &Bound<'_, PyAny>,
        damping_ratios: &Bound<'_, PyAny>,
        load: Option<&Bound<'_, PyAny>>,
        influence: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let w = vector("frequencies", frequencies)?;
        let zeta: Numbers<f64> = numbers("damping_ratios", damping_ratios)?;
        let zeta = match zeta.shape.len() {
            0 => DVector::from_element(w.len(), zeta.values[0]),
            _ => vector("damping_ratios", damping_ratios)?,
        };
        with_forces(LinearSystem::from_modes(&w, &zeta)?, load, influence)
    }

    /// Number of degrees of freedom.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Mass matrix [kg], shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.mass())
    }

    /// Damping matrix [N s/m], shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.damping())
    }

    /// Stiffness matrix [N/m], shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn stiffness<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.stiffness())
    }

    /// Constant force [N], shape (n,).
    #[getter]
    fn load<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.load())
    }

    /// Influence vector [-], shape (n,), or None.
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

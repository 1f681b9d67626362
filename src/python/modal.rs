//! Modes, recovery matrices and their audit in Python.

use crate::error::Error;
use crate::impact::{self, RecoveryAudit};
use crate::modal::{self, Spectrum};
use crate::model::Scene;
use crate::python::array::{matrix, out_complex, out_matrix, out_vector};
use crate::python::model::{PyLinearSystem, PyScene, normals};
use crate::python::pattern::stop_set;
use crate::python::record::plain_class;
use crate::python::text::list;
use crate::python::{argument, interrupt};
use nalgebra::Complex;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// Modes of a linear system, ascending in frequency, shapes mass-normalised with their largest entry positive.
#[pyclass(name = "Modes", module = "vibroimpact", frozen)]
pub(crate) struct PyModes {
    modes: Spectrum,
    of: Py<PyAny>,
    pressed: Vec<usize>,
    held: Vec<usize>,
}

#[pymethods]
impl PyModes {
    #[new]
    #[pyo3(signature = (system_or_scene, pressed=None, held=None))]
    fn new(
        system_or_scene: &Bound<'_, PyAny>,
        pressed: Option<Vec<usize>>,
        held: Option<Vec<usize>>,
    ) -> PyResult<Self> {
        let (pressed, held) = (pressed.unwrap_or_default(), held.unwrap_or_default());
        let py = system_or_scene.py();
        let is_whole = pressed.is_empty() && held.is_empty();
        let scene = system_or_scene.cast::<PyScene>().ok();
        let scene = scene.map(|own| &own.get().0);
        let is_linear = |scene: &&Scene| !is_whole || scene.linear_system("modes").is_ok();
        let modes = if let Some(scene) = scene.filter(is_linear) {
            let of = || modal::spectrum_in(scene, &pressed, &held);
            interrupt::run(py, false, of)?
        } else {
            let system = &linear(system_or_scene)?.0;
            if !is_whole {
                let message = "pressed and held are stops of a scene, but a LinearSystem is given";
                return Err(PyTypeError::new_err(message));
            }
            interrupt::run(py, false, || modal::spectrum(system))?
        };
        Ok(Self {
            modes,
            of: system_or_scene.clone().unbind(),
            pressed,
            held,
        })
    }

    /// Natural frequencies of the undamped system [rad/s], shape (m,); nan where the equilibrium is unstable.
    #[getter]
    fn natural_frequencies<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.modes.natural_frequencies)
    }

    /// Mode shapes in the columns, M-orthonormal [1/kg^0.5], shape (n, m); complex where the stiffness is not symmetric. Made when asked for.
    ///
    /// Raises
    /// ------
    /// MemoryError
    ///     More modes than their shapes have room for.
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.modes.real_shapes()? {
            Some(shapes) => Ok(out_matrix(py, &shapes)?.into_any()),
            None => Ok(out_matrix::<Complex<f64>>(py, &self.modes.shapes()?)?.into_any()),
        }
    }

    /// Damping ratios [-], shape (m,).
    #[getter]
    fn damping_ratios<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.modes.damping_ratios)
    }

    /// Eigenvalues of the damped system [1/s], shape (2m,).
    #[getter]
    fn eigenvalues<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex<f64>>> {
        out_complex(py, &self.modes.eigenvalues)
    }

    /// Whether the damping is proportional: the real shapes uncouple the damped motion too.
    #[getter]
    fn is_proportional(&self) -> bool {
        self.modes.is_proportional
    }

    fn __repr__(&self) -> String {
        format!(
            "Modes(natural_frequencies={}, damping_ratios={}, is_proportional={})",
            list(&self.modes.natural_frequencies),
            list(&self.modes.damping_ratios),
            if self.modes.is_proportional {
                "True"
            } else {
                "False"
            }
        )
    }

    fn __getnewargs__(&self, py: Python<'_>) -> (Py<PyAny>, Vec<usize>, Vec<usize>) {
        (
            self.of.clone_ref(py),
            self.pressed.clone(),
            self.held.clone(),
        )
    }
}

/// The modes of a linear system.
///
/// Of a linear scene with stops pressed and held: those of that regime.
///
/// Parameters
/// ----------
/// system_or_scene : LinearSystem or Scene
///     The system, or a linear scene.
/// pressed : int or sequence of int, optional
///     Stops of the scene that give way and are pressed: their stiffness and damping act.
/// held : int or sequence of int, optional
///     Stops that are held, their gaps at zero: k of them with independent normals leave m = n - k modes.
///
/// Returns
/// -------
/// Modes
///     ``natural_frequencies`` (m,), ``shapes`` (n, m), ``damping_ratios`` (m,), ``eigenvalues`` (2m,), ``is_proportional``;
///     m = n where nothing is held.
///
/// Raises
/// ------
/// ConvergenceError
///     If an eigenvalue iteration fails.
/// TypeError
///     Anything but a linear system or a scene; a nonlinear system has its ``linearise()``.
/// ValueError
///     A scene that is not linear, a stop that does not exist, is named twice or is never in that state.
///
/// Notes
/// -----
/// For the source paper's system these are its (10) and (11), in ascending order.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> vi.modes(vi.paper_system(3.0, 3.24, 0.05)).natural_frequencies.round(6)
/// array([0.447796, 2.009846])
/// >>> soft = vi.Stop(0, 0.5, contact=vi.Spring(3.0))
/// >>> vi.modes(vi.Scene(vi.LinearSystem(1.0, None, 1.0), stops=[soft]), pressed=0).natural_frequencies
/// array([2.])
#[pyfunction]
#[pyo3(signature = (system_or_scene, *, pressed=None, held=None))]
pub(crate) fn modes(
    system_or_scene: &Bound<'_, PyAny>,
    pressed: Option<&Bound<'_, PyAny>>,
    held: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyModes> {
    let stops =
        |name, given: Option<&Bound<'_, PyAny>>| given.map(|own| stop_set(name, own)).transpose();
    PyModes::new(
        system_or_scene,
        stops("pressed", pressed)?,
        stops("held", held)?,
    )
}

/// The linear system that is given.
fn linear<'py>(system: &Bound<'py, PyAny>) -> PyResult<PyRef<'py, PyLinearSystem>> {
    system.extract().map_err(|_| {
        let remedy = match system.cast::<PyScene>() {
            Ok(_) => "; take scene.linearise().system",
            Err(_) if system.hasattr("linearise").unwrap_or(false) => "; take system.linearise()",
            Err(_) => "",
        };
        let given = system.get_type();
        PyTypeError::new_err(format!(
            "system is {given}, but a LinearSystem is needed{remedy}"
        ))
    })
}

/// The recovery matrix R of the stops hit together: ``x+ = R x-``, ``x = (q, v)``.
///
/// Parameters
/// ----------
/// scene : Scene
///     A linear scene.
/// stops : int or sequence of int
///     The stops hit at one instant.
///
/// Returns
/// -------
/// ndarray, shape (2n, 2n)
///
/// Raises
/// ------
/// ValueError
///     A nonlinear scene, a stop that does not exist or stands twice, stops with dependent normals and unequal restitution.
///
/// References
/// ----------
/// The source paper, eq. (23) and Note 2, where the reaction is the coordinate's own.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> vi.recovery_matrix(vi.paper_scene(kind=3), 1).diagonal()
/// array([ 1. ,  1. ,  1. , -0.9])
#[pyfunction]
pub(crate) fn recovery_matrix<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    stops: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (scene, stops) = (&scene.0, stop_set("stops", stops)?);
    out_matrix(py, &py.detach(|| impact::recovery_matrix(scene, &stops))?)
}

/// What ``audit_recovery`` found.
#[pyclass(name = "RecoveryAudit", module = "vibroimpact", frozen)]
pub(crate) struct PyRecoveryAudit(RecoveryAudit);

plain_class! { PyRecoveryAudit |own| {
    /// Whether rigid, frictionless stops can act so.
    is_realisable: own.is_realisable,
    /// Restitution coefficient along each normal [-], shape (k,); nan where there is none.
    restitution: &own.restitution,
    /// The largest factor by which the matrix can multiply the kinetic energy [-].
    energy_gain: own.energy_gain,
    /// Every rule that is broken, in words.
    reasons: own.reasons.clone(),
}

    #[new]
    fn new(
        is_realisable: bool,
        restitution: &Bound<'_, PyAny>,
        energy_gain: f64,
        reasons: Vec<String>,
    ) -> PyResult<Self> {
        let restitution = crate::python::array::vector("restitution", restitution)?;
        Ok(Self(RecoveryAudit {
            is_realisable,
            restitution,
            energy_gain,
            reasons,
        }))
    }

    fn __repr__(&self) -> String {
        let verdict = if self.0.is_realisable {
            "realisable"
        } else {
            "not realisable"
        };
        let mut text = format!(
            "RecoveryAudit({verdict}, energy_gain={:.6})",
            self.0.energy_gain
        );
        for reason in &self.0.reasons {
            text.push_str("\n  ");
            text.push_str(reason);
        }
        text
    }
}

/// Audits a recovery matrix: can rigid, frictionless stops with these normals do it?
///
/// Parameters
/// ----------
/// matrix : array_like, shape (2n, 2n)
///     The matrix R of ``x+ = R x-``, ``x = (q, v)``.
/// mass : array_like, shape (n, n) or (n,)
///     Mass matrix, symmetric positive definite.
/// normals : sequence of int or array_like, shape (k, n)
///     The normals of the stops hit: indices of coordinates, or vectors.
///
/// Returns
/// -------
/// RecoveryAudit
///     ``is_realisable``, ``restitution`` (k,), ``energy_gain``, ``reasons``.
///
/// Raises
/// ------
/// ValueError
///     Wrong shapes, numbers that are not finite, a mass that is not symmetric positive definite.
///
/// Examples
/// --------
/// The source paper's R2 can multiply the pendulum's kinetic energy by 5.27 for equal masses.
///
/// >>> import vibroimpact as vi
/// >>> scene = vi.paper_scene(kind=2)
/// >>> audit = vi.audit_recovery(vi.recovery_matrix(scene, 0), scene.system.mass, [0])
/// >>> audit.is_realisable, round(audit.energy_gain, 2)
/// (False, 5.27)
#[pyfunction]
pub(crate) fn audit_recovery(
    py: Python<'_>,
    matrix: &Bound<'_, PyAny>,
    mass: &Bound<'_, PyAny>,
    normals: &Bound<'_, PyAny>,
) -> PyResult<PyRecoveryAudit> {
    let mass = crate::python::array::coefficient("mass", mass)?;
    let matrix = self::matrix("matrix", matrix)?;
    let n = mass.order();
    if matrix.shape() != (2 * n, 2 * n) {
        let found = format!("({}, {})", matrix.nrows(), matrix.ncols());
        let expected = format!("({}, {})", 2 * n, 2 * n);
        return Err(Error::bad_shape("matrix", found, expected).into());
    }
    let normals = self::normals(normals, n)?;
    let audit = py.detach(|| impact::audit_recovery(&matrix, &mass.to_dense(), &normals))?;
    Ok(PyRecoveryAudit(audit))
}

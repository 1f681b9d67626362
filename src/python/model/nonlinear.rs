//! Nonlinear systems in Python: their functions are Python's, or a C function.

use crate::model::NonlinearSystem;
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{matrix_or_number, vector};
use crate::python::c_function::CFunction;
use crate::python::callable::{Callable, name_of};
use crate::python::model::bad;
use crate::python::model::equations::{Acceleration, Mass, PyEquations};
use crate::python::model::linear::PyLinearSystem;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Nonlinear system given by its equations of motion ``q'' = a(t, q, v)``.
///
/// Parameters
/// ----------
/// n_dof : int
///     Number of degrees of freedom n, at least 1.
/// acceleration : callable or C function
///     ``f(t, q, v)``, or ``f(t, q, v, parameters)`` where parameters are given: the acceleration, shape (n,). Or a C function
///     ``void f(double t, const double *q, const double *v, double *a, const double *parameters)`` that writes it to a: a
///     numba ``cfunc``, a ctypes function or a ``scipy.LowLevelCallable``. A bare address is refused, since nothing would
///     show that it is one: wrap it as ``ctypes.CFUNCTYPE(...)(address)``.
/// mass : array_like, shape (n, n), or callable, optional
///     Mass matrix, symmetric positive definite, or a function of q that gives it: needed for stops with the inertial reaction,
///     for harmonic forces and for ``linearise``.
/// parameters : object, optional
///     Handed over to the acceleration and the Jacobian as it is; numbers, shape (p,), for a C function, which has a null
///     pointer without them.
/// jacobian : callable, optional
///     ``f(t, q, v[, parameters])``: the derivative of the acceleration by (q, v), shape (n, 2n); else by differences. It is
///     compared with a difference before it is used: an entry off by more than 1e-3 of its size is a ``ValueError``.
/// potential : callable, optional
///     ``f(q)``: the potential energy.
/// time_offset : float, default 0.0
///     Added to the time that acceleration and jacobian are given. ``orbit.scene``, whose time begins at the first impact, has it
///     where they depend on time.
///
/// Raises
/// ------
/// ValueError
///     Less than one degree of freedom, a mass of another shape or not symmetric, a C function whose signature is known and
///     another one, parameters for it that are no numbers.
/// TypeError
///     A function that is none.
///
/// Notes
/// -----
/// The functions must be pure: the same arguments, the same values. The arrays they are given are fresh and read-only. An
/// exception raised in one of them ends the computation and comes out as it is; a result of the wrong shape or that is not
/// finite is a ``ValueError`` that names the function, the place and the rule. A Python function costs some microseconds a
/// call; a C function runs with the interpreter released. A system pickles if its functions do: those defined in a module do, C
/// functions do not, since an address means nothing in another process.
///
/// References
/// ----------
/// .. [1] C. J. F. Ridders, "Accurate computation of F'(x) and F'(x) F''(x)", Adv. Eng. Software 4 (1982) 75: the differences.
///
/// Examples
/// --------
/// A Duffing oscillator between two stops, without damping: every impact has the same speed, ``v**2 = 1 - q**2 - q**4/2``.
///
/// >>> import numpy as np
/// >>> import vibroimpact as vi
/// >>> duffing = vi.NonlinearSystem(1, lambda t, q, v: -q - q**3, mass=1.0)
/// >>> scene = vi.Scene(duffing, stops=[vi.Stop(0, 0.5, 1.0), vi.Stop(0, 0.5, 1.0, side="lower")])
/// >>> run = vi.simulate(scene, 0.0, 1.0, (0, 20))
/// >>> speeds = [impact[2] for impact in run.impacts]
/// >>> bool(np.allclose(speeds, np.sqrt(1 - 0.25 - 0.03125), rtol=1e-7))
/// True
#[pyclass(name = "NonlinearSystem", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyNonlinearSystem(pub NonlinearSystem);

impl PyNonlinearSystem {
    fn parts(&self) -> PyResult<&PyEquations> {
        (self.0.equations() as &dyn std::any::Any)
            .downcast_ref::<PyEquations>()
            .ok_or_else(|| PyTypeError::new_err("the system was not made in Python"))
    }
}

fn optional<'a, 'py>(value: Option<&'a Bound<'py, PyAny>>) -> Option<&'a Bound<'py, PyAny>> {
    value.filter(|v| !v.is_none())
}

fn mass(value: &Bound<'_, PyAny>, n: usize) -> PyResult<Mass> {
    if value.is_callable() {
        return Ok(Mass::Function(Callable::new("mass", value)?));
    }
    Ok(Mass::Constant(matrix_or_number("mass", value, (n, n))?))
}

fn acceleration(
    given: &Bound<'_, PyAny>,
    parameters: Option<&Bound<'_, PyAny>>,
) -> PyResult<Acceleration> {
    let is_number = !given.is_callable() && given.extract::<i64>().is_ok();
    if is_number {
        return Err(PyTypeError::new_err(
            "acceleration is a number, but a function is needed; wrap the address of a C function as \
             ctypes.CFUNCTYPE(...)(address)",
        ));
    }
    // The numbers are asked for only where the object stands for a C function.
    if let Some(function) = CFunction::find(given, || match parameters {
        Some(numbers) => Ok(vector("parameters", numbers)?.as_slice().to_vec()),
        None => Ok(Vec::new()),
    })? {
        let given = given.clone().unbind();
        return Ok(Acceleration::C { function, given });
    }
    Ok(Acceleration::Python(Callable::new("acceleration", given)?))
}

#[pymethods]
impl PyNonlinearSystem {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(n_dof, acceleration, *, mass=None, parameters=None, jacobian=None, potential=None, time_offset=0.0)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (n_dof, acceleration, *, mass=None, parameters=None, jacobian=None, potential=None, time_offset=0.0))]
    fn made(
        #[pyo3(from_py_with = argument::n_dof)] n_dof: i64,
        acceleration: &Bound<'_, PyAny>,
        mass: Option<&Bound<'_, PyAny>>,
        parameters: Option<&Bound<'_, PyAny>>,
        jacobian: Option<&Bound<'_, PyAny>>,
        potential: Option<&Bound<'_, PyAny>>,
        time_offset: f64,
    ) -> PyResult<Self> {
        let n = usize::try_from(n_dof)
            .ok()
            .filter(|&n| n > 0)
            .ok_or_else(|| bad(format!("n_dof is {n_dof}, but it must be at least 1")))?;
        let parameters = optional(parameters);
        let function = |name, value: Option<&Bound<'_, PyAny>>| {
            optional(value).map(|f| Callable::new(name, f)).transpose()
        };
        let system = NonlinearSystem::new(PyEquations {
            n,
            acceleration: self::acceleration(acceleration, parameters)?,
            parameters: parameters.map(|p| p.clone().unbind()),
            mass: optional(mass).map(|m| self::mass(m, n)).transpose()?,
            jacobian: function("jacobian", jacobian)?,
            potential: function("potential", potential)?,
        })?;
        let system = Self(system.with_time_offset(time_offset)?);
        if let Some(Mass::Constant(_)) = system.parts()?.mass {
            system.0.check_mass(&vec![0.0; n])?;
        }
        Ok(system)
    }

    /// Number of degrees of freedom.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// The acceleration as given.
    #[getter]
    fn acceleration(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self.parts()?.given().clone_ref(py))
    }

    /// Mass matrix [kg], shape (n, n), a function of q, or None.
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.parts()?.mass_given(py)
    }

    /// The parameters as given, or None.
    #[getter]
    fn parameters(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        Ok(self.parts()?.parameters.as_ref().map(|p| p.clone_ref(py)))
    }

    /// The function that gives the Jacobian, or None.
    #[getter]
    fn jacobian(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let function = self.parts()?.jacobian.as_ref();
        Ok(function.map(|f| f.function.clone_ref(py)))
    }

    /// The function that gives the potential energy, or None.
    #[getter]
    fn potential(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let function = self.parts()?.potential.as_ref();
        Ok(function.map(|f| f.function.clone_ref(py)))
    }

    /// What is added to the time that acceleration and jacobian are given [s].
    #[getter]
    fn time_offset(&self) -> f64 {
        self.0.time_offset()
    }

    /// The linear system about the equilibrium q = 0.
    ///
    /// Returns
    /// -------
    /// LinearSystem
    ///     ``K = -M da/dq``, ``C = -M da/dv``; no influence vector.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     No mass matrix, or q = 0 is not at rest at all times.
    /// ConvergenceError
    ///     Differences that settle on no value.
    fn linearise(&self, py: Python<'_>) -> PyResult<PyLinearSystem> {
        Ok(PyLinearSystem(py.detach(|| self.0.linearise())?))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let parts = self.parts()?;
        let kind = match parts.acceleration {
            Acceleration::Python(_) => "",
            Acceleration::C { .. } => ", in C",
        };
        let mut text = format!(
            "NonlinearSystem(n_dof={}, acceleration={}{kind}",
            parts.n,
            name_of(py, parts.given())?
        );
        match &parts.mass {
            None => {}
            Some(Mass::Constant(m)) => {
                text.push_str(&format!(", mass ({}, {})", m.nrows(), m.ncols()));
            }
            Some(Mass::Function(f)) => {
                text.push_str(&format!(", mass={}", name_of(py, &f.function)?));
            }
        }
        for (name, is_there) in [
            ("parameters", parts.parameters.is_some()),
            ("jacobian", parts.jacobian.is_some()),
            ("potential", parts.potential.is_some()),
        ] {
            if is_there {
                text.push_str(&format!(", {name}"));
            }
        }
        if self.0.time_offset() != 0.0 {
            text.push_str(&format!(", time_offset={:.6}", self.0.time_offset()));
        }
        text.push(')');
        Ok(text)
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((usize, Py<PyAny>), Bound<'py, PyDict>)> {
        if let Acceleration::C { .. } = self.parts()?.acceleration {
            return Err(PyTypeError::new_err(
                "a NonlinearSystem whose acceleration is a C function cannot be pickled: its address means nothing in another \
                 process; make the system there",
            ));
        }
        let options = PyDict::new(py);
        options.set_item("mass", self.mass(py)?)?;
        options.set_item("parameters", self.parameters(py)?)?;
        options.set_item("jacobian", self.jacobian(py)?)?;
        options.set_item("potential", self.potential(py)?)?;
        options.set_item("time_offset", self.time_offset())?;
        Ok(((self.n_dof(), self.acceleration(py)?), options))
    }
}

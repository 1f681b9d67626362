//! Nonlinear systems and stops in Python: their functions are Python's, or a C function.

use crate::error::Result;
use crate::model::{EquationsOfMotion, GapFunction, NonlinearStop, NonlinearSystem};
use crate::python::array::{matrix, out_matrix, vector};
use crate::python::c_function::CFunction;
use crate::python::callable::{Callable, Place, read_only};
use crate::python::model::stop::{out_reaction, reaction};
use crate::python::model::{PyLinearSystem, bad};
use nalgebra::DMatrix;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Equations of motion that were given in Python.
struct PyEquations {
    n: usize,
    acceleration: Acceleration,
    parameters: Option<Py<PyAny>>,
    mass: Option<Mass>,
    jacobian: Option<Callable>,
    potential: Option<Callable>,
}

enum Acceleration {
    Python(Callable),
    C {
        function: CFunction,
        given: Py<PyAny>,
    },
}

enum Mass {
    Constant(DMatrix<f64>),
    Function(Callable),
}

impl PyEquations {
    /// (t, q, v), and the parameters where there are some.
    fn arguments<'py>(
        &self,
        py: Python<'py>,
        (t, q, v): (f64, &[f64], &[f64]),
    ) -> PyResult<Bound<'py, PyTuple>> {
        let (q, v) = (read_only(py, q), read_only(py, v));
        match &self.parameters {
            Some(parameters) => (t, q, v, parameters).into_pyobject(py),
            None => (t, q, v).into_pyobject(py),
        }
    }

    fn given(&self) -> &Py<PyAny> {
        match &self.acceleration {
            Acceleration::Python(function) => &function.function,
            Acceleration::C { given, .. } => given,
        }
    }

    fn mass_given<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(match &self.mass {
            None => None,
            Some(Mass::Constant(m)) => Some(out_matrix(py, m)?.into_any()),
            Some(Mass::Function(f)) => Some(f.function.bind(py).clone()),
        })
    }
}

fn position<'py>(py: Python<'py>, q: &[f64]) -> PyResult<Bound<'py, PyTuple>> {
    PyTuple::new(py, [read_only(py, q)])
}

/// Whether two Python objects are one, or equal; arrays entry by entry.
fn is_equal(py: Python<'_>, a: &Py<PyAny>, b: &Py<PyAny>) -> bool {
    if a.is(b) {
        return true;
    }
    let equal = || -> PyResult<bool> {
        let equal = a.bind(py).eq(b);
        match equal {
            Ok(equal) => Ok(equal),
            // Arrays of several entries have no single truth.
            Err(_) => py
                .import("numpy")?
                .call_method1("array_equal", (a, b))?
                .extract(),
        }
    };
    equal().unwrap_or(false)
}

fn are_equal(py: Python<'_>, a: Option<&Py<PyAny>>, b: Option<&Py<PyAny>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => is_equal(py, a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

fn function_of(callable: Option<&Callable>) -> Option<&Py<PyAny>> {
    callable.map(|c| &c.function)
}

impl EquationsOfMotion for PyEquations {
    fn n_dof(&self) -> usize {
        self.n
    }

    fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        match &self.acceleration {
            Acceleration::C { function, .. } => {
                function.call(t, q, v, a);
                Ok(())
            }
            Acceleration::Python(function) => {
                let place = Place { time: Some(t), q };
                function.write_vector(|py| self.arguments(py, (t, q, v)), &place, a)
            }
        }
    }

    fn has_mass(&self) -> bool {
        self.mass.is_some()
    }

    fn mass(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        match &self.mass {
            Some(Mass::Constant(mass)) => Ok(mass.clone()),
            Some(Mass::Function(function)) => {
                let place = Place { time: None, q };
                function.matrix(|py| position(py, q), &place, (self.n, self.n))
            }
            None => Err(crate::model::no_mass("this")),
        }
    }

    fn jacobian(&self, t: f64, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let place = Place { time: Some(t), q };
        self.jacobian
            .as_ref()
            .map(|function| {
                let shape = (self.n, 2 * self.n);
                function.matrix(|py| self.arguments(py, (t, q, v)), &place, shape)
            })
            .transpose()
    }

    fn potential(&self, q: &[f64]) -> Result<Option<f64>> {
        let place = Place { time: None, q };
        self.potential
            .as_ref()
            .map(|function| function.number(|py| position(py, q), &place))
            .transpose()
    }

    fn equals(&self, other: &dyn EquationsOfMotion) -> bool {
        let Some(other) = (other as &dyn std::any::Any).downcast_ref::<Self>() else {
            return false;
        };
        let masses = |py: Python<'_>| match (&self.mass, &other.mass) {
            (None, None) => true,
            (Some(Mass::Constant(a)), Some(Mass::Constant(b))) => a == b,
            (Some(Mass::Function(a)), Some(Mass::Function(b))) => {
                is_equal(py, &a.function, &b.function)
            }
            _ => false,
        };
        self.n == other.n
            && Python::attach(|py| {
                let functions = |a: &Option<Callable>, b: &Option<Callable>| {
                    are_equal(py, function_of(a.as_ref()), function_of(b.as_ref()))
                };
                is_equal(py, self.given(), other.given())
                    && are_equal(py, self.parameters.as_ref(), other.parameters.as_ref())
                    && masses(py)
                    && functions(&self.jacobian, &other.jacobian)
                    && functions(&self.potential, &other.potential)
            })
    }
}

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
///     ``f(t, q, v[, parameters])``: the derivative of the acceleration by (q, v), shape (n, 2n); else by differences.
/// potential : callable, optional
///     ``f(q)``: the potential energy.
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
    let is_number = n == 1 && matrix("mass", value).is_err();
    Ok(Mass::Constant(if is_number {
        DMatrix::from_vec(1, 1, vector("mass", value)?.as_slice().to_vec())
    } else {
        matrix("mass", value)?
    }))
}

fn acceleration(
    given: &Bound<'_, PyAny>,
    parameters: Option<&Bound<'_, PyAny>>,
) -> PyResult<Acceleration> {
    let is_number = given.extract::<i64>().is_ok();
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
    #[pyo3(signature = (n_dof, acceleration, *, mass=None, parameters=None, jacobian=None, potential=None))]
    fn new(
        n_dof: i64,
        acceleration: &Bound<'_, PyAny>,
        mass: Option<&Bound<'_, PyAny>>,
        parameters: Option<&Bound<'_, PyAny>>,
        jacobian: Option<&Bound<'_, PyAny>>,
        potential: Option<&Bound<'_, PyAny>>,
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
        let system = Self(system);
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

    /// Mass matrix, shape (n, n), a function of q, or None.
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
        Ok(((self.n_dof(), self.acceleration(py)?), options))
    }
}

/// The name of a function, or what it shows of itself.
fn name_of(py: Python<'_>, function: &Py<PyAny>) -> PyResult<String> {
    let function = function.bind(py);
    match function.getattr("__qualname__") {
        Ok(name) => Ok(name.to_string()),
        Err(_) => Ok(function.repr()?.to_string()),
    }
}

/// A gap that was given in Python.
struct PyGap {
    gap: Callable,
    gradient: Callable,
}

impl GapFunction for PyGap {
    fn gap(&self, q: &[f64]) -> Result<f64> {
        let place = Place { time: None, q };
        self.gap.number(|py| position(py, q), &place)
    }

    fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
        let place = Place { time: None, q };
        self.gradient
            .write_vector(|py| position(py, q), &place, gradient)
    }

    fn equals(&self, other: &dyn GapFunction) -> bool {
        (other as &dyn std::any::Any)
            .downcast_ref::<Self>()
            .is_some_and(|other| {
                Python::attach(|py| {
                    is_equal(py, &self.gap.function, &other.gap.function)
                        && is_equal(py, &self.gradient.function, &other.gradient.function)
                })
            })
    }
}

/// Stop with any gap ``h(q) >= 0``, given with its gradient; the normal towards it is ``-grad h``.
///
/// Parameters
/// ----------
/// gap : callable
///     ``h(q)``: the gap, twice continuously differentiable; negative inside the stop.
/// gradient : callable
///     ``f(q)``: its gradient, shape (n,).
/// restitution : float
///     Restitution coefficient [-], in [0, 1].
/// curvature : float, optional
///     Bound >= 0 on the spectral norm of the gap's second derivative, over all positions met: makes the search certain.
/// reaction : {"inertia", "coordinate"} or array_like, shape (n,), default "inertia"
///     Direction b in which an impact changes the velocity, ``n.b > 0`` at every impact; as for Stop.
///
/// Raises
/// ------
/// ValueError
///     A restitution outside [0, 1], a curvature that is negative or not finite, an unknown reaction.
/// TypeError
///     A function that is none.
///
/// Notes
/// -----
/// The functions are called as those of NonlinearSystem. Contacts are searched on an interpolant of the gap: the quintic of
/// its value and first two time derivatives at both ends of a step; the second has ``v.(hess h)v`` by differences of the
/// gradient along the motion, exact to rounding for a gap of second degree. Without ``curvature`` this search is
/// not certain, as the ``message`` of a trajectory says; with it every step is walked along in steps that provably hold no
/// contact deeper than the margin, whatever the interpolant says. A touch within ``10 (atol |grad h|_1 + rtol size)`` is a graze, size being ``|h| + sum |q_i dh/dq_i|``, and all of
/// it the larger of both ends of the step.
///
/// Examples
/// --------
/// A point in the plane inside a circle: its speed is kept, whatever the angle of its impacts.
///
/// >>> import numpy as np
/// >>> import vibroimpact as vi
/// >>> point = vi.LinearSystem(np.ones(2), np.zeros(2), np.zeros(2))
/// >>> circle = vi.NonlinearStop(lambda q: 1 - q @ q, lambda q: -2 * q, 1.0)
/// >>> run = vi.simulate(vi.Scene(point, stops=circle), [0.0, 0.5], [1.0, 0.2], (0, 20))
/// >>> bool(np.isclose(np.linalg.norm(run.final[1]), np.hypot(1.0, 0.2)))
/// True
#[pyclass(name = "NonlinearStop", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyNonlinearStop(pub NonlinearStop);

impl PyNonlinearStop {
    fn parts(&self) -> PyResult<&PyGap> {
        (self.0.function() as &dyn std::any::Any)
            .downcast_ref::<PyGap>()
            .ok_or_else(|| PyTypeError::new_err("the stop was not made in Python"))
    }
}

#[pymethods]
impl PyNonlinearStop {
    #[new]
    #[pyo3(signature = (gap, gradient, restitution, *, curvature=None, reaction=None))]
    fn new(
        gap: &Bound<'_, PyAny>,
        gradient: &Bound<'_, PyAny>,
        restitution: f64,
        curvature: Option<f64>,
        reaction: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let function = PyGap {
            gap: Callable::new("gap", gap)?,
            gradient: Callable::new("gradient", gradient)?,
        };
        let stop =
            NonlinearStop::new(function, restitution)?.with_reaction(self::reaction(reaction)?)?;
        Ok(Self(match curvature {
            Some(curvature) => stop.with_curvature(curvature)?,
            None => stop,
        }))
    }

    /// The function that gives the gap.
    #[getter]
    fn gap(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self.parts()?.gap.function.clone_ref(py))
    }

    /// The function that gives its gradient.
    #[getter]
    fn gradient(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self.parts()?.gradient.function.clone_ref(py))
    }

    /// Restitution coefficient [-].
    #[getter]
    fn restitution(&self) -> f64 {
        self.0.restitution().value()
    }

    /// Bound on the gap's second derivative, or None.
    #[getter]
    fn curvature(&self) -> Option<f64> {
        self.0.curvature()
    }

    /// "inertia", "coordinate", or a direction of shape (n,).
    #[getter]
    fn reaction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_reaction(py, self.0.reaction())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let parts = self.parts()?;
        let curvature = self
            .curvature()
            .map_or_else(String::new, |c| format!(", curvature={c}"));
        Ok(format!(
            "NonlinearStop({}, {}, restitution={}{curvature}, reaction={})",
            name_of(py, &parts.gap.function)?,
            name_of(py, &parts.gradient.function)?,
            self.restitution(),
            self.reaction(py)?.repr()?
        ))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Py<PyAny>, Py<PyAny>, f64), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("curvature", self.curvature())?;
        options.set_item("reaction", self.reaction(py)?)?;
        Ok((
            (self.gap(py)?, self.gradient(py)?, self.restitution()),
            options,
        ))
    }
}

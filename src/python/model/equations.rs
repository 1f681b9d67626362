//! Equations of motion given in Python: what the core asks of them, answered by calls of their functions.

use crate::error::Result;
use crate::model::EquationsOfMotion;
use crate::python::array::out_matrix;
use crate::python::c_function::CFunction;
use crate::python::callable::{CallSite, Callable, Entered, is_equal, position, read_only};
use nalgebra::DMatrix;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Equations of motion that were given in Python.
pub(super) struct PyEquations {
    pub n: usize,
    pub acceleration: Acceleration,
    pub parameters: Option<Py<PyAny>>,
    pub mass: Option<Mass>,
    pub jacobian: Option<Callable>,
    pub potential: Option<Callable>,
}

/// How the acceleration was given.
pub(super) enum Acceleration {
    Python(Callable),
    C {
        function: CFunction,
        given: Py<PyAny>,
    },
}

/// How the mass matrix was given.
pub(super) enum Mass {
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

    pub fn given(&self) -> &Py<PyAny> {
        match &self.acceleration {
            Acceleration::Python(function) => &function.function,
            Acceleration::C { given, .. } => given,
        }
    }

    pub fn mass_given<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(match &self.mass {
            None => None,
            Some(Mass::Constant(m)) => Some(out_matrix(py, m)?.into_any()),
            Some(Mass::Function(f)) => Some(f.function.bind(py).clone()),
        })
    }
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
                // It may be a callback into Python, as those of ctypes are.
                let _entered = Entered::new()?;
                function.call(t, q, v, a);
                Ok(())
            }
            Acceleration::Python(function) => {
                let place = CallSite { time: Some(t), q };
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
                let place = CallSite { time: None, q };
                function.matrix(|py| position(py, q), &place, (self.n, self.n))
            }
            None => Err(crate::model::no_mass("this")),
        }
    }

    fn constant_mass(&self) -> Option<DMatrix<f64>> {
        match &self.mass {
            Some(Mass::Constant(mass)) => Some(mass.clone()),
            _ => None,
        }
    }

    fn jacobian(&self, t: f64, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let place = CallSite { time: Some(t), q };
        self.jacobian
            .as_ref()
            .map(|function| {
                let shape = (self.n, 2 * self.n);
                function.matrix(|py| self.arguments(py, (t, q, v)), &place, shape)
            })
            .transpose()
    }

    fn potential(&self, q: &[f64]) -> Result<Option<f64>> {
        let place = CallSite { time: None, q };
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

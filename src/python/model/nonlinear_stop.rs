//! Stops given by functions of Python: a gap and its gradient.

use crate::error::Result;
use crate::model::{GapFunction, NonlinearStop};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::callable::{CallSite, Callable, is_equal, name_of, position};
use crate::python::model::law::{law, named_law, out_law, restitution_of, shown_law};
use crate::python::model::reaction::{out_reaction, reaction};
use crate::python::model::stop_motion::{motion, out_motion, shown_motion};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// A gap that was given in Python.
struct PyGap {
    gap: Callable,
    gradient: Callable,
}

impl GapFunction for PyGap {
    fn gap(&self, q: &[f64]) -> Result<f64> {
        let place = CallSite { time: None, q };
        self.gap.number(|py| position(py, q), &place)
    }

    fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
        let place = CallSite { time: None, q };
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
/// restitution : float, optional
///     Restitution coefficient [-], in [0, 1], of a rigid stop.
/// contact : Newton, Spring or Hertz, optional
///     The law of contact, as in ``Stop``; one of ``restitution`` and ``contact`` is needed.
/// curvature : float, optional
///     Bound >= 0 on the spectral norm of the gap's second derivative, over all positions met and a little inside the stop: makes the
///     search certain.
/// reaction : {"inertia", "coordinate"} or array_like, shape (n,), default "inertia"
///     Direction b in which an impact changes the velocity, ``n.b > 0`` at every impact; as for Stop.
/// motion : Harmonic, Fourier or signal, optional
///     How the stop moves by itself, added to its gap; as in ``Stop``.
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
/// The functions are called as those of NonlinearSystem.
///
/// With ``curvature`` the motion on every step, however long, is walked along in pieces that provably hold no contact deeper than
/// ``atol |grad h|_1 + rtol size``, with size ``|h| + sum |q_i dh/dq_i|``; the first contact is where a stop is first crossed. Every
/// value of the gap is held against its gradient and the bound: where they disagree, or the search comes to no end, the step is
/// taken shorter, and where no shorter one helps the run ends with the status "uncertain", which keeps what came before. A bound that
/// is none is not always found out. In the norm lengths and angles count alike: where the gap depends on both, a unit of length in which
/// lengths are about one keeps the bound close, and the search short. The ``message`` of a run says where it was long.
///
/// Without ``curvature`` the search is not certain, as the ``message`` of a trajectory says: contacts are searched on the quintic of the
/// gap's value and first two time derivatives at both ends of a step, whose second has ``v.(hess h)v`` by differences of the gradient
/// along the motion. The gap is asked for at three places of each step besides: where it differs from the quintic the step is taken
/// shorter, and a stop that is passed at one of them, or at an end, is met before. What passes between them may be missed. The gradient
/// is believed: with one that is not that of the gap a run may creep.
///
/// Either way an impact is where the gap is zero, to the tolerance; a gap that changes its sign and is zero nowhere ends the run with
/// "uncertain".
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
    #[pyo3(signature = (*arguments, **named), text_signature = "(gap, gradient, restitution=None, *, contact=None, curvature=None, reaction=None, motion=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (gap, gradient, restitution=None, *, contact=None, curvature=None, reaction=None, motion=None))]
    fn made(
        gap: &Bound<'_, PyAny>,
        gradient: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::restitution)] restitution: Option<f64>,
        contact: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::curvature)] curvature: Option<f64>,
        reaction: Option<&Bound<'_, PyAny>>,
        motion: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let function = PyGap {
            gap: Callable::new("gap", gap)?,
            gradient: Callable::new("gradient", gradient)?,
        };
        let law = law(restitution, contact)?;
        let stop = NonlinearStop::new(function, law)?.with_reaction(self::reaction(reaction)?)?;
        let stop = stop.with_motion(self::motion(motion)?);
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

    /// Restitution coefficient [-], None of a stop that gives way.
    #[getter]
    fn restitution(&self) -> Option<f64> {
        restitution_of(self.0.contact())
    }

    /// The law of contact.
    #[getter]
    fn contact(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        out_law(py, self.0.contact())
    }

    /// Bound on the gap's second derivative, or None.
    #[getter]
    fn curvature(&self) -> Option<f64> {
        self.0.curvature()
    }

    /// "inertia", "coordinate", or a direction [-] of shape (n,).
    #[getter]
    fn reaction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_reaction(py, self.0.reaction())
    }

    /// Motion of its own, or None.
    #[getter]
    fn motion(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        out_motion(py, self.0.motion())
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
            "NonlinearStop({}, {}, {}{curvature}, reaction={}{})",
            name_of(py, &parts.gap.function)?,
            name_of(py, &parts.gradient.function)?,
            shown_law(py, self.0.contact())?,
            self.reaction(py)?.repr()?,
            shown_motion(py, self.0.motion())?
        ))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Py<PyAny>, Py<PyAny>, Option<f64>), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("curvature", self.curvature())?;
        options.set_item("reaction", self.reaction(py)?)?;
        options.set_item("motion", self.motion(py)?)?;
        let restitution = named_law(self.0.contact(), &options)?;
        Ok(((self.gap(py)?, self.gradient(py)?, restitution), options))
    }
}

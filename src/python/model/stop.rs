//! Stops and walls in Python.

use crate::model::{Constraint, Normal, Side, Stop, Wall, WallSide};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::array::{matrix, out_vector};
use crate::python::model::bad;
use crate::python::model::law::{law, named_law, out_law, restitution_of, shown_law};
use crate::python::model::nonlinear_stop::PyNonlinearStop;
use crate::python::model::normal::normal;
use crate::python::model::reaction::{out_reaction, reaction};
use crate::python::model::stop_motion::{motion, out_motion, shown_motion};
use crate::python::pattern::stop_index;
use nalgebra::{DMatrix, DVector};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

fn side(value: &str) -> PyResult<Side> {
    match value {
        "upper" => Ok(Side::Upper),
        "lower" => Ok(Side::Lower),
        _ => Err(bad(format!(
            "side is {value:?}, but it must be \"upper\" or \"lower\": on both sides stand two stops, one of each"
        ))),
    }
}

/// Plane stop with gap ``clearance - n.q >= 0`` (upper side) or ``clearance + n.q >= 0`` (lower side).
///
/// Parameters
/// ----------
/// normal : int or array_like, shape (n,)
///     Index of a coordinate, counted from 0, or the normal n itself, of any length but zero.
/// clearance : float
///     Gap at q = 0; negative: preloaded.
/// restitution : float, optional
///     Minus the ratio of the normal velocity after an impact to the one before [-], in [0, 1]: of a rigid stop.
/// contact : Newton, Spring or Hertz, optional
///     The law of contact: what happens where the gap closes. One of ``restitution`` and ``contact`` is needed.
/// side : {"upper", "lower"}, default "upper"
///     On which side of the motion the stop stands.
/// reaction : {"inertia", "coordinate"} or array_like, shape (n,), default "inertia"
///     Direction in which an impact changes the velocity: ``M^-1 n`` (Newton's law), ``n`` (each coordinate reset alone, the
///     source paper's law, which can gain energy: see ``audit_recovery``), or b itself with ``n.b > 0``.
/// motion : Harmonic, Fourier or signal, optional
///     How the stop moves by itself, added to its clearance: with one number for each amplitude, or a signal as in ``Load`` whose
///     slope is continuous; a run must stay within one that is not at rest at zero at its ends.
///
/// Raises
/// ------
/// ValueError
///     A zero normal, a negative index, a restitution outside [0, 1], an unknown side or reaction.
///
/// Notes
/// -----
/// Reactions other than ``"inertia"`` have two limits. They may feed a motion, which between stops can grow beyond all bounds within a
/// finite time; what is said of it from then on means nothing. And where stops whose normals depend on each other (two at one
/// place, three on two coordinates) react in different directions, more than one motion obeys the laws: what is found is one of
/// them, and may pass a stop by 1e-8 of the motion while forces change hands.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> vi.Stop(1, 0.15, 0.9, reaction="coordinate")
/// Stop(1, clearance=0.15, restitution=0.9, side='upper', reaction='coordinate')
#[pyclass(name = "Stop", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyStop(pub Stop);

#[pymethods]
impl PyStop {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(normal, clearance, restitution=None, *, contact=None, side=\"upper\", reaction=None, motion=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (normal, clearance, restitution=None, *, contact=None, side="upper", reaction=None, motion=None))]
    fn made(
        normal: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::clearance)] clearance: f64,
        #[pyo3(from_py_with = argument::restitution)] restitution: Option<f64>,
        contact: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::side)] side: &str,
        reaction: Option<&Bound<'_, PyAny>>,
        motion: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let law = law(restitution, contact)?;
        let stop = Stop::new(self::normal("normal", normal)?, clearance, law)?;
        let stop = stop
            .on_side(self::side(side)?)
            .with_reaction(self::reaction(reaction)?)?;
        Ok(Self(stop.with_motion(self::motion(motion)?)))
    }

    /// The normal [-] as given: index of a coordinate, or shape (n,).
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.0.normal() {
            Normal::Coordinate(i) => i.into_pyobject(py)?.into_any(),
            Normal::Vector(n) => out_vector(py, n).into_any(),
        })
    }

    /// Gap at q = 0 [m].
    #[getter]
    fn clearance(&self) -> f64 {
        self.0.clearance()
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

    /// "upper" or "lower".
    #[getter]
    fn side(&self) -> &'static str {
        match self.0.side() {
            Side::Upper => "upper",
            Side::Lower => "lower",
        }
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
        Ok(format!(
            "Stop({}, clearance={}, {}, side='{}', reaction={}{})",
            self.normal(py)?.repr()?,
            self.clearance(),
            shown_law(py, self.0.contact())?,
            self.side(),
            self.reaction(py)?.repr()?,
            shown_motion(py, self.0.motion())?
        ))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Bound<'py, PyAny>, f64, Option<f64>), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("side", self.side())?;
        options.set_item("reaction", self.reaction(py)?)?;
        options.set_item("motion", self.motion(py)?)?;
        let restitution = named_law(self.0.contact(), &options)?;
        Ok(((self.normal(py)?, self.clearance(), restitution), options))
    }
}

/// Vertical plane wall that one bob of a pendulum may not cross; it moves with the base.
///
/// Parameters
/// ----------
/// bob : int
///     The bob, counted from 0.
/// position : float
///     Horizontal position of the wall (in units of ``l1`` for ``DoublePendulum``).
/// restitution : float, optional
///     Restitution coefficient [-], in [0, 1], of a rigid wall.
/// contact : Newton, Spring or Hertz, optional
///     The law of contact, as in ``Stop``; one of ``restitution`` and ``contact`` is needed.
/// side : {"right", "left"}, default "right"
///     On which side of the bob the wall stands.
/// motion : Harmonic, Fourier or signal, optional
///     How the wall moves relative to the base, added to its position; as in ``Stop``.
///
/// Raises
/// ------
/// ValueError
///     A negative bob, a restitution outside [0, 1], an unknown side.
#[pyclass(name = "Wall", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyWall(pub Wall);

#[pymethods]
impl PyWall {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(bob, position, restitution=None, *, contact=None, side=\"right\", motion=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (bob, position, restitution=None, *, contact=None, side="right", motion=None))]
    fn made(
        bob: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::position)] position: f64,
        #[pyo3(from_py_with = argument::restitution)] restitution: Option<f64>,
        contact: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::side)] side: &str,
        motion: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let side = match side {
            "right" => WallSide::Right,
            "left" => WallSide::Left,
            _ => {
                return Err(bad(format!(
                    "side is {side:?}, but it must be \"right\" or \"left\""
                )));
            }
        };
        let law = law(restitution, contact)?;
        let wall = Wall::new(stop_index("bob", bob)?, position, law, side)?;
        Ok(Self(wall.with_motion(self::motion(motion)?)))
    }

    /// The bob, counted from 0.
    #[getter]
    fn bob(&self) -> usize {
        self.0.bob()
    }

    /// Horizontal position [m].
    #[getter]
    fn position(&self) -> f64 {
        self.0.position()
    }

    /// Restitution coefficient [-], None of a wall that gives way.
    #[getter]
    fn restitution(&self) -> Option<f64> {
        restitution_of(self.0.contact())
    }

    /// The law of contact.
    #[getter]
    fn contact(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        out_law(py, self.0.contact())
    }

    /// "right" or "left".
    #[getter]
    fn side(&self) -> &'static str {
        match self.0.side() {
            WallSide::Right => "right",
            WallSide::Left => "left",
        }
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
        Ok(format!(
            "Wall(bob={}, position={}, {}, side='{}'{})",
            self.bob(),
            self.position(),
            shown_law(py, self.0.contact())?,
            self.side(),
            shown_motion(py, self.0.motion())?
        ))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((usize, f64, Option<f64>), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("side", self.side())?;
        options.set_item("motion", self.motion(py)?)?;
        let restitution = named_law(self.0.contact(), &options)?;
        Ok(((self.bob(), self.position(), restitution), options))
    }
}

fn constraint(value: &Bound<'_, PyAny>) -> PyResult<Constraint> {
    if let Ok(s) = value.cast::<PyStop>() {
        return Ok(s.get().0.clone().into());
    }
    if let Ok(s) = value.cast::<PyWall>() {
        return Ok(s.get().0.clone().into());
    }
    if let Ok(s) = value.cast::<PyNonlinearStop>() {
        return Ok(s.get().0.clone().into());
    }
    Err(PyTypeError::new_err(format!(
        "stops holds {}, but a Stop, Wall or NonlinearStop is needed",
        value.get_type().name()?
    )))
}

pub(crate) fn constraints(value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Constraint>> {
    let Some(value) = value.filter(|v| !v.is_none()) else {
        return Ok(Vec::new());
    };
    match value.try_iter() {
        Ok(items) => items.map(|item| constraint(&item?)).collect(),
        Err(_) => Ok(vec![constraint(value)?]),
    }
}

/// Normals given one after the other, as columns.
pub(crate) fn normals(value: &Bound<'_, PyAny>, n: usize) -> PyResult<DMatrix<f64>> {
    if let Ok(m) = matrix("normals", value) {
        return if m.ncols() == n {
            Ok(m.transpose())
        } else {
            Err(bad(format!(
                "normals has shape ({}, {}), but (k, {n}) is needed",
                m.nrows(),
                m.ncols()
            )))
        };
    }
    let items = value
        .try_iter()
        .map_err(|_| bad("normals must be a list of indices or vectors".to_owned()))?;
    let columns = items
        .enumerate()
        .map(|(i, item)| {
            Ok(Stop::new(normal("normal", &item?)?, 0.0, 0.0)?
                .normal_vector(n, &format!("normals[{i}]"))?)
        })
        .collect::<PyResult<Vec<DVector<f64>>>>()?;
    Ok(if columns.is_empty() {
        DMatrix::zeros(n, 0)
    } else {
        DMatrix::from_columns(&columns)
    })
}

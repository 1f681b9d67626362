//! The source paper's system and scenes in Python.

use crate::model::{self, Kind, PaperOptions};
use crate::python::argument;
use crate::python::model::linear::PyLinearSystem;
use crate::python::model::scene::PyScene;
use pyo3::prelude::*;

/// The source paper's system (7) in symmetric form, with damping ``C = 2 damping K``.
///
/// Parameters
/// ----------
/// mass_ratio : float
///     ``m2/m1`` > 0.
/// length_ratio : float
///     ``l1/l2`` > 0.
/// damping : float
///     zeta; the modal damping ratios are ``damping * w_j``.
///
/// Returns
/// -------
/// LinearSystem
///
/// Raises
/// ------
/// ValueError
///     A ratio that is not positive, a damping that is not finite.
#[pyfunction]
pub(crate) fn paper_system(
    #[pyo3(from_py_with = argument::mass_ratio)] mass_ratio: f64,
    #[pyo3(from_py_with = argument::length_ratio)] length_ratio: f64,
    #[pyo3(from_py_with = argument::damping)] damping: f64,
) -> PyResult<PyLinearSystem> {
    Ok(PyLinearSystem(model::paper_system(
        mass_ratio,
        length_ratio,
        damping,
    )?))
}

/// The source paper's numerical case of the given kind: base motion, and a stop for each pendulum.
///
/// Parameters
/// ----------
/// kind : {1, 2, 3}
///     1: both pendulums hit together (3 forcing periods); 2: the upper one (2 periods); 3: the lower one (2 periods).
/// damping : float, optional
///     zeta, not printed in the paper; default: a value with an admissible orbit.
/// clearance : float, optional
///     theta0, not printed in the paper; default: a value with an admissible orbit.
/// linear : bool, default True
///     The small-angle system (7), or the full eq. (3) with the same damping.
///
/// Returns
/// -------
/// Scene
///
/// Raises
/// ------
/// ValueError
///     An unknown kind, a number that is not finite.
#[pyfunction]
#[pyo3(signature = (kind, damping=None, clearance=None, linear=true))]
pub(crate) fn paper_scene(
    #[pyo3(from_py_with = argument::kind)] kind: i64,
    #[pyo3(from_py_with = argument::damping)] damping: Option<f64>,
    #[pyo3(from_py_with = argument::clearance)] clearance: Option<f64>,
    #[pyo3(from_py_with = argument::linear)] linear: bool,
) -> PyResult<PyScene> {
    let options = PaperOptions {
        damping,
        clearance,
        linear,
    };
    Ok(PyScene(model::paper_scene(
        Kind::try_from(kind)?,
        &options,
    )?))
}

//! Systems, forcing, stops and scenes in Python.

mod equations;
mod forcing;
mod fourier;
mod linear;
mod nonlinear;
mod nonlinear_stop;
mod paper;
mod pendulum;
mod reaction;
mod scene;
mod stop;

pub(crate) use forcing::{PyBaseMotion, PyHarmonic};
pub(crate) use fourier::PyFourier;
pub(crate) use linear::{_rayleigh_coefficients, PyLinearSystem};
pub(crate) use nonlinear::PyNonlinearSystem;
pub(crate) use nonlinear_stop::PyNonlinearStop;
pub(crate) use paper::{paper_scene, paper_system};
pub(crate) use pendulum::{PyDoublePendulum, PyPendulumChain};
pub(crate) use scene::PyScene;
pub(crate) use stop::{PyStop, PyWall, normals};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

fn bad(message: String) -> PyErr {
    PyValueError::new_err(message)
}

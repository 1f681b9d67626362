//! Systems, forcing, stops and scenes in Python.

mod base_motion;
mod equations;
mod forcing;
mod fourier;
mod law;
mod linear;
mod load;
mod nonlinear;
mod nonlinear_stop;
mod normal;
mod paper;
mod pendulum;
mod reaction;
mod scene;
mod signal;
mod stop;
mod stop_motion;

pub(crate) use base_motion::PyBaseMotion;
pub(crate) use forcing::PyHarmonic;
pub(crate) use fourier::PyFourier;
pub(crate) use law::{PyHertz, PyNewton, PySpring};
pub(crate) use linear::{_rayleigh_coefficients, PyLinearSystem};
pub(crate) use load::{PyBaseAcceleration, PyLoad};
pub(crate) use nonlinear::PyNonlinearSystem;
pub(crate) use nonlinear_stop::PyNonlinearStop;
pub(crate) use normal::normal;
pub(crate) use paper::{paper_scene, paper_system};
pub(crate) use pendulum::{PyDoublePendulum, PyPendulumChain};
pub(crate) use scene::PyScene;
pub(crate) use signal::PySignal;
pub(crate) use stop::{PyStop, PyWall, normals};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

fn bad(message: String) -> PyErr {
    PyValueError::new_err(message)
}

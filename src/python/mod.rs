//! The Python module `vibroimpact._core`: frozen newtypes round the core's values. Every function extracts, calls the
//! core with the interpreter released, and converts.

// What `help()` shows is numpydoc: its sections have names, types and exceptions bare, where Rust wants backticks.
#![allow(clippy::doc_markdown)]
// Bound functions have the arguments of the Python signature.
#![allow(clippy::too_many_arguments)]

mod along_branch;
mod answered;
mod argument;
mod array;
mod attractor;
mod basin;
mod branch;
mod c_function;
mod callable;
mod curve;
mod derivative;
mod diagram;
mod error;
mod exponents;
mod files;
mod find;
mod interrupt;
mod made;
mod modal;
mod model;
mod motion;
mod motion_state;
mod named;
mod objective;
mod options;
mod orbit;
mod orbit_facts;
mod orbits;
mod pattern;
mod ramp;
mod record;
mod rows;
mod run_facts;
mod simulate;
mod special;
mod sweep;
mod text;
mod trajectory;
mod varied;

use pyo3::prelude::*;

/// The compiled core of vibroimpact.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::along_branch::{_is_on_branch, _monitored, _orbits_at};
    #[pymodule_export]
    use super::answered::_unknown;
    #[pymodule_export]
    use super::array::_numbers;
    #[pymodule_export]
    use super::attractor::{_group_attractors, _settle_seeds};
    #[pymodule_export]
    use super::basin::{_basin_cells, _basin_entropy, _boundary_dimension, _uncertainty_exponent};
    #[pymodule_export]
    use super::branch::_continuation;
    #[pymodule_export]
    use super::curve::_bifurcation_curve;
    #[pymodule_export]
    use super::diagram::{_bifurcation_diagram, _poincare_points};
    #[pymodule_export]
    use super::exponents::_lyapunov_exponents;
    #[pymodule_export]
    use super::find::find_orbit;
    #[pymodule_export]
    use super::modal::{PyModes, PyRecoveryAudit, audit_recovery, modes, recovery_matrix};
    #[pymodule_export]
    use super::model::{
        _rayleigh_coefficients, PyBaseAcceleration, PyBaseMotion, PyDoublePendulum, PyFourier,
        PyHarmonic, PyHertz, PyLinearSystem, PyLoad, PyNewton, PyNonlinearStop, PyNonlinearSystem,
        PyPendulumChain, PyScene, PySignal, PySpring, PyStop, PyWall, paper_scene, paper_system,
    };
    #[pymodule_export]
    use super::motion_state::{_restore_state, PyMotionState};
    #[pymodule_export]
    use super::objective::{_check_entry, _derivatives_but_multipliers, _objective_at};
    #[pymodule_export]
    use super::orbit::{_restore_orbit, PyOrbit};
    #[pymodule_export]
    use super::orbit_facts::{PyCoefficients, PyFamily, PyStability, PyViolation};
    #[pymodule_export]
    use super::orbits::{_restore_orbits, PyOrbits, periodic_orbits};
    #[pymodule_export]
    use super::ramp::PyRamp;
    #[pymodule_export]
    use super::run_facts::{PyEnergy, PyStats};
    #[pymodule_export]
    use super::simulate::simulate;
    #[pymodule_export]
    use super::special::{_accumulation, _beyond, _branches, _touch_outcome};
    #[pymodule_export]
    use super::sweep::{_check_existence, _existence_at, _existence_cells, _simulate_rows};
    #[pymodule_export]
    use super::trajectory::{_restore_trajectory, PyTrajectory};

    use crate::branch::{BeyondOutcome, SpecialKind};
    use crate::continuation::EndReason;
    use pyo3::prelude::*;
    use pyo3::types::PyTuple;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let kinds = SpecialKind::ALL.map(SpecialKind::name);
        let outcomes = BeyondOutcome::ALL.map(BeyondOutcome::name);
        let reasons = EndReason::ALL.map(EndReason::name);
        let py = module.py();
        module.add("_SPECIAL_KINDS", PyTuple::new(py, kinds)?)?;
        module.add("_BEYOND_OUTCOMES", PyTuple::new(py, outcomes)?)?;
        module.add("_END_REASONS", PyTuple::new(py, reasons)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

//! Facts of a run in Python: its counts and its energy ledger.

use crate::error::digits;
use crate::simulate::{Energy, Stats};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// What a run did, counted.
#[pyclass(name = "Stats", module = "vibroimpact", frozen)]
pub(crate) struct PyStats(pub Stats);

#[pymethods]
impl PyStats {
    /// Evaluations of the right-hand side; none in exact flights.
    #[getter]
    fn n_rhs(&self) -> usize {
        self.0.n_rhs
    }

    /// Steps of an integrator; none in exact flights.
    #[getter]
    fn n_steps(&self) -> usize {
        self.0.n_steps
    }

    /// Evaluations of a gap with its derivatives.
    #[getter]
    fn n_gap_evaluations(&self) -> usize {
        self.0.n_gap_evaluations
    }

    /// Flights.
    #[getter]
    fn n_flights(&self) -> usize {
        self.0.n_flights
    }

    /// Impacts.
    #[getter]
    fn n_impacts(&self) -> usize {
        self.0.n_impacts
    }

    fn __repr__(&self) -> String {
        let s = self.0;
        format!(
            "Stats(n_rhs={}, n_steps={}, n_gap_evaluations={}, n_flights={}, n_impacts={})",
            s.n_rhs, s.n_steps, s.n_gap_evaluations, s.n_flights, s.n_impacts
        )
    }
}

/// Energies along a trajectory, arrays of shape (m,), one entry for each of its times ``t``.
///
/// ``balance`` is what does not add up: kinetic + potential - forcing_work + damping_loss + impact_loss, less its value at
/// the start; zero but for the tolerance of the integration.
#[pyclass(name = "Energy", module = "vibroimpact", frozen)]
pub(crate) struct PyEnergy(pub Energy);

#[pymethods]
impl PyEnergy {
    /// Kinetic energy.
    #[getter]
    fn kinetic<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.kinetic.clone().into_pyarray(py)
    }

    /// Potential energy, zero at q = 0.
    #[getter]
    fn potential<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.potential.clone().into_pyarray(py)
    }

    /// Work of the forcing since the start.
    #[getter]
    fn forcing_work<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.forcing_work.clone().into_pyarray(py)
    }

    /// Loss in dampers since the start.
    #[getter]
    fn damping_loss<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.damping_loss.clone().into_pyarray(py)
    }

    /// Loss at impacts since the start, chatter included; for a reaction that is not that of inertia also what lasting
    /// contact takes.
    #[getter]
    fn impact_loss<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.impact_loss.clone().into_pyarray(py)
    }

    /// What does not add up, zero at the start.
    #[getter]
    fn balance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.balance.clone().into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let worst = self.0.balance.iter().fold(0.0f64, |a, x| a.max(x.abs()));
        format!(
            "Energy({} times, balance within {})",
            self.0.balance.len(),
            digits(worst)
        )
    }
}

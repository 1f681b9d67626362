//! Trajectories in Python.

use crate::observer::stop_if;
use crate::python::array::{matrix, out_matrix, out_vector, times};
use crate::python::model::PyScene;
use crate::python::rows::{is_before, out_grazes, out_impacts, out_segments, out_states};
use crate::python::run_facts::{PyEnergy, PyStats};
use crate::python::{argument, interrupt};
use crate::quantity::room_for;
use crate::simulate::{ImpactSide, Samples, SavedTrajectory, Trajectory};
use nalgebra::DVector;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::OnceLock;

/// A simulated motion.
#[pyclass(name = "Trajectory", module = "vibroimpact", frozen)]
pub(crate) struct PyTrajectory {
    pub core: Trajectory,
    samples: OnceLock<Samples>,
}

impl PyTrajectory {
    pub(crate) fn new(core: Trajectory) -> Self {
        Self {
            core,
            samples: OnceLock::new(),
        }
    }

    fn samples(&self, py: Python<'_>) -> PyResult<&Samples> {
        if self.samples.get().is_none() {
            let core = &self.core;
            let samples = interrupt::run(py, false, |_| core.samples())?;
            let _ = self.samples.set(samples);
        }
        self.samples
            .get()
            .ok_or_else(|| PyValueError::new_err("the trajectory has no samples"))
    }

    fn states(
        &self,
        t: &Bound<'_, PyAny>,
        side: &str,
    ) -> PyResult<(Vec<(DVector<f64>, DVector<f64>)>, bool)> {
        let side = if is_before(side)? {
            ImpactSide::Before
        } else {
            ImpactSide::After
        };
        let (times, is_single) = times("t", t)?;
        let core = &self.core;
        room_for(
            "the motion at these times",
            times.len(),
            4 * core.scene().n_dof(),
        )?;
        let states = interrupt::run(t.py(), false, |observe| {
            let state = |&t: &f64| {
                stop_if(observe(0.0))?;
                core.state(t, side)
            };
            times.iter().map(state).collect::<crate::Result<Vec<_>>>()
        })?;
        Ok((states, is_single))
    }
}

#[pymethods]
impl PyTrajectory {
    /// Times, shape (m,): ``t_eval``, or without it points for drawing, both sides of each impact, at most 200 a segment, fewer
    /// where these would be more than a million.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if let Some(samples) = self.samples.get() {
            return Ok(samples.0.clone().into_pyarray(py));
        }
        let core = &self.core;
        let times = interrupt::run(py, false, |_| core.sample_times())?;
        Ok(times.into_pyarray(py))
    }

    /// Positions at ``t``, shape (m, n).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.samples(py)?.1)
    }

    /// Velocities at ``t``, shape (m, n).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.samples(py)?.2)
    }

    /// Position at times inside the span; needs keep="motion".
    ///
    /// Parameters
    /// ----------
    /// t : float or array_like, shape (m,)
    ///     Times [s].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m, n), or (n,) for a single time
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A time outside the span, or a motion that was not kept.
    fn position<'py>(&self, py: Python<'py>, t: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (states, is_single) = self.states(t, "after")?;
        let rows: Vec<DVector<f64>> = states.into_iter().map(|s| s.0).collect();
        out_states(py, &rows, self.core.scene().n_dof(), is_single)
    }

    /// Velocity at times inside the span; needs keep="motion".
    ///
    /// What is left of impacts that accumulate (a segment "chatter") is given as motion with the stop held: its velocity is off
    /// the true one, which jumps without end there, by no more than the speed of the first impact left out, along the stop's
    /// reaction.
    ///
    /// Parameters
    /// ----------
    /// t : float or array_like, shape (m,)
    ///     Times [s].
    /// side : {"after", "before"}, default "after"
    ///     Which velocity is meant at an impact.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m, n), or (n,) for a single time
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A time outside the span, or a motion that was not kept.
    #[pyo3(signature = (t, side="after"))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = argument::side)] side: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (states, is_single) = self.states(t, side)?;
        let rows: Vec<DVector<f64>> = states.into_iter().map(|s| s.1).collect();
        out_states(py, &rows, self.core.scene().n_dof(), is_single)
    }

    /// Impacts: structured array of time, stop, speed_before, speed_after, impulse, phase.
    #[getter]
    fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_impacts(py, self.core.impacts())
    }

    /// Touches without impact, minima of a gap within its rounding of zero: structured array of time, stop, depth.
    #[getter]
    fn grazes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let grazes = self.core.grazes();
        out_grazes(py, grazes.iter().map(|g| (g.time, g.stop, g.depth)))
    }

    /// The energy ledger at the times ``t``; needs keep="motion".
    ///
    /// Of a NonlinearSystem, given with ``mass`` and ``potential``, ``damping_loss`` is what its forces took beyond the potential,
    /// those of dampers and any others (negative: they brought energy), and ``balance`` checks the motion and the quadrature
    /// alone: a mass or potential that is not that of the acceleration shows as ``damping_loss``.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A motion that was not kept, a NonlinearSystem without ``mass`` or ``potential``.
    #[getter]
    fn energy(&self, py: Python<'_>) -> PyResult<PyEnergy> {
        let core = &self.core;
        let energy = interrupt::run(py, false, |observe| {
            core.energy_observed(&mut || observe(0.0))
        })?;
        Ok(PyEnergy(energy))
    }

    /// Segments: structured array of kind, stop (-1: none), start, end; needs keep="motion".
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_segments(py, &self.core.segments()?)
    }

    /// Final position and velocity, shapes (n,) and (n,).
    #[getter]
    #[pyo3(name = "final")]
    fn last<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let (q, v) = self.core.last();
        (out_vector(py, q), out_vector(py, v))
    }

    /// Time at which the run ended [s], that of ``final``, with every ``keep``: the run goes on with
    /// ``simulate(scene, *run.final, (run.t_end, later))``, in the same phase of the forcing.
    #[getter]
    fn t_end(&self) -> f64 {
        self.core.t_end()
    }

    /// "finished", "max_impacts", "step_underflow" or "unresolved_contact".
    #[getter]
    fn status(&self) -> &'static str {
        self.core.status().name()
    }

    /// How the run ended, in words.
    #[getter]
    fn message(&self) -> &str {
        self.core.message()
    }

    /// What was counted.
    #[getter]
    fn stats(&self) -> PyStats {
        PyStats(self.core.stats())
    }

    /// The scene.
    #[getter]
    fn scene(&self) -> PyScene {
        PyScene(self.core.scene().clone())
    }

    /// Arrays of the trajectory, for ``numpy.savez``.
    ///
    /// Returns
    /// -------
    /// dict of ndarray
    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let arrays = PyDict::new(py);
        if self.samples.get().is_some() || self.core.sample_times().is_ok() {
            arrays.set_item("t", self.t(py)?)?;
            arrays.set_item("q", self.q(py)?)?;
            arrays.set_item("v", self.v(py)?)?;
        }
        let (q, v) = self.last(py);
        arrays.set_item("t_end", vec![self.t_end()].into_pyarray(py))?;
        arrays.set_item("final_q", q)?;
        arrays.set_item("final_v", v)?;
        arrays.set_item("impacts", self.impacts(py)?)?;
        arrays.set_item("grazes", self.grazes(py)?)?;
        Ok(arrays)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (PyScene, Bound<'py, PyDict>))> {
        let saved = self.core.save();
        let numbers = PyDict::new(py);
        numbers.set_item("span", saved.span)?;
        numbers.set_item("status", saved.status)?;
        numbers.set_item("message", saved.message)?;
        numbers.set_item("stats", saved.stats)?;
        numbers.set_item("impacts", saved.impacts)?;
        numbers.set_item("grazes", saved.grazes)?;
        numbers.set_item("last", saved.last)?;
        numbers.set_item("motion", saved.motion)?;
        if let Some((t, q, v)) = saved.samples {
            numbers.set_item("samples", (t, out_matrix(py, &q)?, out_matrix(py, &v)?))?;
        }
        Ok((
            py.import("vibroimpact._core")?
                .getattr("_restore_trajectory")?,
            (self.scene(), numbers),
        ))
    }

    fn __repr__(&self) -> String {
        let (start, end) = self.core.span();
        let s = self.core.stats();
        format!(
            "Trajectory({}, t = {start} to {end}, {} impacts, {} grazes)\n  {}",
            self.status(),
            s.n_impacts,
            self.core.grazes().len(),
            self.core.message()
        )
    }
}

/// A trajectory from what it was saved as; used by pickle.
#[pyfunction]
pub(crate) fn _restore_trajectory(
    scene: PyRef<'_, PyScene>,
    saved: &Bound<'_, PyDict>,
) -> PyResult<PyTrajectory> {
    fn get<'py, T: FromPyObjectOwned<'py>>(saved: &Bound<'py, PyDict>, name: &str) -> PyResult<T> {
        let item = saved
            .get_item(name)?
            .ok_or_else(|| PyValueError::new_err(format!("{name} is missing")))?;
        argument::saved(name, &item)
    }
    let py = saved.py();
    let samples = match saved.get_item("samples")? {
        Some(samples) if !samples.is_none() => {
            let (t, q, v): (Vec<f64>, Bound<'_, PyAny>, Bound<'_, PyAny>) =
                argument::saved("samples", &samples)?;
            Some((t, matrix("q", &q)?, matrix("v", &v)?))
        }
        _ => None,
    };
    let saved = SavedTrajectory {
        span: get(saved, "span")?,
        status: get(saved, "status")?,
        message: get(saved, "message")?,
        stats: get(saved, "stats")?,
        impacts: get(saved, "impacts")?,
        grazes: get(saved, "grazes")?,
        last: get(saved, "last")?,
        motion: get(saved, "motion")?,
        samples,
    };
    let scene = &scene.0;
    let core = interrupt::run(py, false, |_| Trajectory::restore(scene, saved))?;
    Ok(PyTrajectory::new(core))
}

//! Trajectories in Python.

use crate::model::Parameter;
use crate::path::Motion;
use crate::python::array::{matrix, out_matrix, out_vector, times};
use crate::python::derivative::OfRun;
use crate::python::model::PyScene;
use crate::python::motion::{motion_class, out_values};
use crate::python::motion_state::PyMotionState;
use crate::python::ramp::{PyRamp, ramps};
use crate::python::rows::out_grazes;
use crate::python::run_facts::PyStats;
use crate::python::{argument, interrupt};
use crate::simulate::{Samples, SavedTrajectory, Trajectory};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayDyn};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::sync::OnceLock;

/// A simulated motion.
#[pyclass(name = "Trajectory", module = "vibroimpact", frozen)]
pub(crate) struct PyTrajectory {
    pub core: Trajectory,
    samples: OnceLock<Samples>,
    derived: Option<OfRun>,
}

impl PyTrajectory {
    pub(crate) fn new(core: Trajectory) -> Self {
        Self {
            core,
            samples: OnceLock::new(),
            derived: None,
        }
    }

    /// One with its derivatives.
    pub(crate) fn with_derivatives(core: Trajectory, derived: OfRun) -> Self {
        Self {
            derived: Some(derived),
            ..Self::new(core)
        }
    }

    fn samples(&self, py: Python<'_>) -> PyResult<&Samples> {
        if self.samples.get().is_none() {
            let core = &self.core;
            let samples = interrupt::run(py, false, || core.samples())?;
            let _ = self.samples.set(samples);
        }
        self.samples
            .get()
            .ok_or_else(|| PyValueError::new_err("the trajectory has no samples"))
    }
}

motion_class! { PyTrajectory as "trajectory" |own| own.core; (t=None): Option<&Bound<'py, PyAny>>;
    /// Times [s], shape (m,): ``t_eval``, or without it points for drawing, both sides of each impact, at most 200 a segment, fewer
    /// where these would be more than a million.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if let Some(samples) = self.samples.get() {
            return Ok(samples.0.clone().into_pyarray(py));
        }
        let core = &self.core;
        let times = interrupt::run(py, false, || core.sample_times())?;
        Ok(times.into_pyarray(py))
    }

    /// Positions at ``t`` [m], shape (m, n).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.samples(py)?.1)
    }

    /// Velocities at ``t`` [m/s], shape (m, n).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.samples(py)?.2)
    }

    /// Value of a number that a ramp moves.
    ///
    /// Parameters
    /// ----------
    /// t : float or array_like, shape (m,)
    ///     Times [s] inside the span.
    /// name : str, optional
    ///     Which, as ``Ramp`` has it; may be left out where the run has one ramp.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), or () for a single time
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A time outside the span, a number without a ramp; none given where there is no ramp, or several.
    ///
    /// Examples
    /// --------
    /// >>> import vibroimpact as vi
    /// >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], 0.5), vi.Stop(0, 1.0, 0.8))
    /// >>> run = vi.simulate(scene, 0.0, 0.0, (0, 500), ramp=vi.Ramp("frequency", 0.9, levels=3, dwell=10))
    /// >>> run.parameter([0.0, 200.0, 500.0])
    /// array([0.5, 0.7, 0.9])
    #[pyo3(signature = (t, name=None))]
    fn parameter<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = argument::name)] name: Option<&str>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let name = name.map(str::parse::<Parameter>).transpose()?;
        let (times, is_single) = times("t", t)?;
        let values = times.iter().map(|&t| self.core.parameter(t, name));
        out_values(py, values.collect::<crate::Result<_>>()?, is_single)
    }

    /// Forcing phase at times inside the span [rad], from 0 to 2 pi: the angle of the fundamental frequency, which goes on through ramps.
    ///
    /// Parameters
    /// ----------
    /// t : float or array_like, shape (m,)
    ///     Times [s].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), or () for a single time
    ///     Zero without forcing, nan where there is no period.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A time outside the span.
    fn phase<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (times, is_single) = times("t", t)?;
        let values = times.iter().map(|&t| self.core.phase(t));
        out_values(py, values.collect::<crate::Result<_>>()?, is_single)
    }

    /// The ramps of the run: None, one, or a tuple of them.
    #[getter]
    fn ramp<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.core.ramps() {
            [] => Ok(py.None().into_bound(py)),
            [one] => Ok(PyRamp(*one).into_pyobject(py)?.into_any()),
            several => Ok(PyTuple::new(py, several.iter().map(|&one| PyRamp(one)))?.into_any()),
        }
    }

    /// Touches without impact, minima of a gap within its rounding of zero: structured array of time [s], stop, depth [m].
    #[getter]
    fn grazes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let grazes = self.core.grazes();
        out_grazes(py, grazes.iter().map(|g| (g.time, g.stop, g.depth)))
    }

    /// Final position and velocity, shapes (n,) and (n,).
    #[getter]
    #[pyo3(name = "final")]
    fn last<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let (q, v) = self.core.last();
        (out_vector(py, q), out_vector(py, v))
    }

    /// All that a run goes on from, at its end, with every ``keep``: ``simulate(scene, run.state, (run.t_end, later))`` goes on as one that
    /// was not interrupted.
    #[getter]
    fn state(&self) -> PyMotionState {
        PyMotionState(self.core.last_state())
    }

    /// Time at which the run ended [s], that of ``final`` and ``state``, with every ``keep``: the run goes on with
    /// ``simulate(scene, run.state, (run.t_end, later))``, in the same phase of the forcing; after a ramp with the numbers reached, and the
    /// phase that ``phase(run.t_end)`` is, in ``scene``.
    #[getter]
    fn t_end(&self) -> f64 {
        self.core.t_end()
    }

    /// "finished", "max_impacts", "step_underflow", "inside_stop" (a ramp put a stop onto the motion), "unresolved_contact" or
    /// "uncertain" (a search for contacts that could not be certified; the run so far is kept).
    #[getter]
    fn status(&self) -> &'static str {
        self.core.status().name()
    }

    /// How the run ended, in words.
    #[getter]
    fn message(&self) -> String {
        let own = self.core.message();
        let derived = self.derived.as_ref();
        match derived.and_then(|derived| derived.reason.as_ref()) {
            Some(reason) => format!("{own}; derivatives: {reason}"),
            None => own.to_owned(),
        }
    }

    /// How the states change with the numbers that ``simulate(derivatives=)`` names, q0 and v0 being the same: for each name
    /// the derivatives of (q, v) at ``t_eval``, shape (m, 2n), or at the end, shape (2n,). At an instant those behind it. Not a
    /// number from where there are none, and within impacts that accumulate, as ``message`` says; empty where none were asked for.
    #[getter]
    fn derivatives<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let derived = self.derived.iter();
        for (name, by) in derived.clone().flat_map(|derived| &derived.by) {
            if derived.clone().any(|derived| derived.is_of_end) {
                let row: Vec<f64> = by.row(0).iter().copied().collect();
                all.set_item(name, row.into_pyarray(py))?;
            } else {
                all.set_item(name, out_matrix(py, by)?)?;
            }
        }
        Ok(all)
    }

    /// What was counted.
    #[getter]
    fn stats(&self) -> PyStats {
        PyStats(self.core.stats())
    }

    /// Arrays of the trajectory, for ``numpy.savez``.
    ///
    /// Returns
    /// -------
    /// dict of ndarray
    ///     Derivatives by the names of their numbers, ``derivatives_clearance``.
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
        for (name, by) in self.derivatives(py)?.iter() {
            arrays.set_item(format!("derivatives_{name}"), by)?;
        }
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
        numbers.set_item("atol", saved.atol)?;
        numbers.set_item("impacts", saved.impacts)?;
        numbers.set_item("grazes", saved.grazes)?;
        numbers.set_item("last", saved.last)?;
        numbers.set_item("motion", saved.motion)?;
        numbers.set_item("chapters", saved.chapters)?;
        numbers.set_item("ramp", self.ramp(py)?)?;
        numbers.set_item("until", saved.ramps.1)?;
        numbers.set_item("left", saved.left)?;
        if let Some(contacts) = saved.contacts {
            numbers.set_item("contacts", contacts)?;
        }
        if let Some(OfRun {
            by,
            is_of_end,
            reason,
        }) = &self.derived
        {
            let each = by.iter().map(|(name, by)| Ok((name, out_matrix(py, by)?)));
            let each = each.collect::<PyResult<Vec<_>>>()?;
            numbers.set_item("derivatives", (each, *is_of_end, reason))?;
        }
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
            self.message()
        )
    }
}

/// Derivatives from what they were saved as.
fn derivatives_of(saved: &Bound<'_, PyAny>) -> PyResult<OfRun> {
    type Each<'py> = Vec<(String, Bound<'py, PyAny>)>;
    let (each, is_of_end, reason): (Each<'_>, bool, Option<String>) =
        argument::saved("derivatives", saved)?;
    let by = each.into_iter();
    let by = by.map(|(name, by)| Ok((name, matrix("derivatives", &by)?)));
    Ok(OfRun {
        by: by.collect::<PyResult<_>>()?,
        is_of_end,
        reason,
    })
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
    let derived = match saved.get_item("derivatives")? {
        Some(derived) if !derived.is_none() => Some(derivatives_of(&derived)?),
        _ => None,
    };
    let saved = SavedTrajectory {
        span: get(saved, "span")?,
        status: get(saved, "status")?,
        message: get(saved, "message")?,
        stats: get(saved, "stats")?,
        atol: match saved.get_item("atol")? {
            Some(atol) => argument::saved("atol", &atol)?,
            None => f64::NAN,
        },
        impacts: get(saved, "impacts")?,
        grazes: get(saved, "grazes")?,
        last: get(saved, "last")?,
        motion: get(saved, "motion")?,
        chapters: get(saved, "chapters")?,
        ramps: {
            let ramp = saved.get_item("ramp")?.filter(|ramp| !ramp.is_none());
            (ramps(ramp.as_ref())?, get(saved, "until")?)
        },
        left: match saved.get_item("left")? {
            Some(left) => argument::saved("left", &left)?,
            None => None,
        },
        contacts: match saved.get_item("contacts")? {
            Some(contacts) => argument::saved("contacts", &contacts)?,
            None => None,
        },
        samples,
    };
    let scene = &scene.0;
    let core = interrupt::run(py, false, || Trajectory::restore(scene, saved))?;
    Ok(match derived {
        Some(derived) => PyTrajectory::with_derivatives(core, derived),
        None => PyTrajectory::new(core),
    })
}

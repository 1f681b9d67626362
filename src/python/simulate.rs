//! Simulation and trajectories in Python.

use crate::error::digits;
use crate::python::argument;
use crate::python::array::{matrix, out_matrix, out_vector, structured, times, vector};
use crate::python::interrupt;
use crate::python::model::PyScene;
use crate::python::orbit::{is_before, out_grazes, out_impacts, out_states};
use crate::simulate::{
    self as core, ImpactSide, Keep, Method, Samples, SavedTrajectory, SimulateOptions, Stats,
    Trajectory,
};
use nalgebra::DVector;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::OnceLock;

/// What a run did, counted.
#[pyclass(name = "Stats", module = "vibroimpact", frozen)]
pub(crate) struct PyStats(Stats);

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
pub(crate) struct PyEnergy(core::Energy);

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

/// A simulated motion.
#[pyclass(name = "Trajectory", module = "vibroimpact", frozen)]
pub(crate) struct PyTrajectory {
    pub core: Trajectory,
    samples: OnceLock<Samples>,
}

impl PyTrajectory {
    fn samples(&self) -> PyResult<&Samples> {
        if self.samples.get().is_none() {
            let samples = self.core.samples()?;
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
        let states = times
            .iter()
            .map(|&t| self.core.state(t, side))
            .collect::<crate::Result<Vec<_>>>()?;
        Ok((states, is_single))
    }
}

#[pymethods]
impl PyTrajectory {
    /// Times, shape (m,): ``t_eval``, or without it points for drawing, both sides of each impact, at most 200 a segment.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.samples()?.0.clone().into_pyarray(py))
    }

    /// Positions at ``t``, shape (m, n).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.samples()?.1)
    }

    /// Velocities at ``t``, shape (m, n).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.samples()?.2)
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

    /// Touches inside the margin, without impact: structured array of time, stop, depth.
    #[getter]
    fn grazes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let grazes = self.core.grazes();
        out_grazes(py, grazes.iter().map(|g| (g.time, g.stop, g.depth)))
    }

    /// The energy ledger at the times ``t``; needs keep="motion".
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A motion that was not kept, a NonlinearSystem, whose forces cannot be told apart.
    #[getter]
    fn energy(&self, py: Python<'_>) -> PyResult<PyEnergy> {
        let core = &self.core;
        Ok(PyEnergy(py.detach(|| core.energy())?))
    }

    /// Segments: structured array of kind, stop (-1: none), start, end; needs keep="motion".
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let segments = self.core.segments()?;
        let kinds = segments
            .iter()
            .map(|s| s.kind.name())
            .collect::<Vec<_>>()
            .into_pyobject(py)?;
        let stops: Vec<i64> = segments
            .iter()
            .map(|s| s.stop.and_then(|i| i64::try_from(i).ok()).unwrap_or(-1))
            .collect();
        let starts: Vec<f64> = segments.iter().map(|s| s.start).collect();
        let ends: Vec<f64> = segments.iter().map(|s| s.end).collect();
        structured(
            py,
            segments.len(),
            vec![
                ("kind", "U7", kinds.into_any()),
                ("stop", "i8", stops.into_pyarray(py).into_any()),
                ("start", "f8", starts.into_pyarray(py).into_any()),
                ("end", "f8", ends.into_pyarray(py).into_any()),
            ],
        )
    }

    /// Final position and velocity, shapes (n,) and (n,).
    #[getter]
    #[pyo3(name = "final")]
    fn last<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let (q, v) = self.core.last();
        (out_vector(py, q), out_vector(py, v))
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
        if self.samples().is_ok() {
            arrays.set_item("t", self.t(py)?)?;
            arrays.set_item("q", self.q(py)?)?;
            arrays.set_item("v", self.v(py)?)?;
        }
        let (q, v) = self.last(py);
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
        item.extract().map_err(Into::into)
    }
    let samples = match saved.get_item("samples")? {
        Some(samples) if !samples.is_none() => {
            let (t, q, v): (Vec<f64>, Bound<'_, PyAny>, Bound<'_, PyAny>) = samples.extract()?;
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
    Ok(PyTrajectory {
        core: Trajectory::restore(&scene.0, saved)?,
        samples: OnceLock::new(),
    })
}

fn keep(value: &str) -> PyResult<Keep> {
    match value {
        "motion" => Ok(Keep::Motion),
        "impacts" => Ok(Keep::Impacts),
        "final" => Ok(Keep::Final),
        _ => Err(PyValueError::new_err(format!(
            "keep is {value:?}, but it must be \"motion\", \"impacts\" or \"final\""
        ))),
    }
}

/// A pair of times.
pub(crate) fn span(value: &Bound<'_, PyAny>) -> PyResult<(f64, f64)> {
    match vector("t_span", value)?.as_slice() {
        &[start, end] => Ok((start, end)),
        other => Err(PyValueError::new_err(format!(
            "t_span has shape ({},), but (start, end) is needed",
            other.len()
        ))),
    }
}

/// A number of things, none below zero.
pub(crate) fn count(argument: &str, value: Option<i64>) -> PyResult<Option<usize>> {
    value
        .map(|value| {
            usize::try_from(value).map_err(|_| {
                PyValueError::new_err(format!(
                    "{argument} is {value}, but it must not be negative"
                ))
            })
        })
        .transpose()
}

fn method(value: &str) -> PyResult<Method> {
    match value.to_lowercase().as_str() {
        "auto" => Ok(Method::Auto),
        "exact" => Ok(Method::Exact),
        "rk45" => Ok(Method::Rk45),
        "taylor" => Ok(Method::Taylor),
        _ => Err(PyValueError::new_err(format!(
            "method is {value:?}, but it must be \"auto\", \"exact\", \"rk45\" or \"taylor\""
        ))),
    }
}

/// Simulates a scene from (q0, v0) over a span of time.
///
/// A linear scene flies in closed form from impact to impact; others are integrated, every contact located.
///
/// Parameters
/// ----------
/// scene : Scene
///     What moves: linear or not.
/// q0, v0 : array_like, shape (n,)
///     Position and velocity at the start.
/// t_span : pair of float
///     Start and end [s].
/// method : {"auto", "exact", "rk45", "taylor"}, default "auto"
///     "exact": closed-form flights, linear scenes only; "rk45": the Runge-Kutta pair of orders 5 and 4 of Dormand and
///     Prince, any scene; "taylor": Taylor series whose order grows with the digits asked for, a DoublePendulum or a
///     PendulumChain with stops and walls; "auto": the first of exact, taylor, rk45 that the scene allows. Any letter case.
/// rtol, atol : float, default 1e-9, 1e-12
///     Relative and absolute tolerance of each step of an integration; exact flights have no such error. With either method
///     they set the margin of contact: a touch within ``10 (atol |n|_1 + rtol * size)`` of a stop is a graze, no impact.
/// t_eval : array_like, shape (m,), optional
///     Times at which the motion is wanted, ascending.
/// keep : {"motion", "impacts", "final"}, default "motion"
///     What is kept: the whole motion; the impacts (and ``t_eval``); the final state (and ``t_eval``) in constant memory.
/// max_impacts : int, optional
///     The run ends after this many impacts.
/// progress : bool, default False
///     Show a progress bar (needs tqdm).
///
/// Returns
/// -------
/// Trajectory
///     The motion as far as it was kept (``t``, ``q``, ``v``, ``position``, ``velocity``), its ``impacts``, ``grazes`` and
///     ``segments``, the ``final`` state, and how the run ended: ``status``, ``message``, ``stats``.
///
/// Raises
/// ------
/// ValueError
///     Arrays of the wrong shape or not finite, a span that runs backwards, a start inside a stop, ``method="exact"`` for a
///     nonlinear scene, a motion that grows beyond the doubles.
/// TypeError
///     An argument of a wrong type.
///
/// Notes
/// -----
/// In exact flights each next impact is provably the first one: the gap is followed by cubics with a bound on what they
/// leave out. Steps of the pair [1]_ carry each gap along as the quintic that has its value, speed and acceleration at both
/// ends: every contact of the quintic is found, and reached by a step of its own. Chatter, sticking and coupled simultaneous
/// impacts end the run with status "unresolved_contact" and the reason in ``message``.
///
/// References
/// ----------
/// .. [1] J. R. Dormand and P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980) 19.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> orbit = vi.periodic_orbits(vi.paper_scene(kind=3), [1], n_periods=2)[0]
/// >>> run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 100.5 * orbit.period))
/// >>> run.status, len(run.impacts)
/// ('finished', 100)
#[pyfunction]
#[pyo3(signature = (scene, q0, v0, t_span, *, method="auto", rtol=1e-9, atol=1e-12, t_eval=None, keep="motion", max_impacts=None, progress=false))]
#[allow(clippy::too_many_arguments)] // the public signature
pub(crate) fn simulate(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    q0: &Bound<'_, PyAny>,
    v0: &Bound<'_, PyAny>,
    t_span: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: f64,
    t_eval: Option<&Bound<'_, PyAny>>,
    #[pyo3(from_py_with = argument::keep)] keep: &str,
    #[pyo3(from_py_with = argument::max_impacts)] max_impacts: Option<i64>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<PyTrajectory> {
    let (t_span, max_impacts) = (span(t_span)?, count("max_impacts", max_impacts)?);
    let (q0, v0) = (vector("q0", q0)?, vector("v0", v0)?);
    let t_eval = t_eval.map(|t| times("t_eval", t)).transpose()?.map(|t| t.0);
    let options = SimulateOptions {
        method: self::method(method)?,
        rtol,
        atol,
        t_eval,
        keep: self::keep(keep)?,
        max_impacts,
    };
    let model = &scene.0;
    let length = t_span.1 - t_span.0;
    let core = interrupt::run(py, progress, |observe| {
        core::simulate_checked(model, &q0, &v0, t_span, &options, &mut |t| {
            observe((t - t_span.0) / length)
        })
    })?;
    Ok(PyTrajectory {
        core,
        samples: OnceLock::new(),
    })
}

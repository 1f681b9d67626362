//! Trajectories in Python.

use crate::model::Parameter;
use crate::observer::unless_broken_off;
use crate::python::answered::no_attribute;
use crate::python::array::{matrix, out_matrix, out_vector, times};
use crate::python::derivative::OfRun;
use crate::python::model::{PyScene, normal};
use crate::python::outputs::{derivative, out_values, side, times_or_points, window};
use crate::python::pattern::stop_index;
use crate::python::ramp::{PyRamp, ramps};
use crate::python::rows::{out_grazes, out_impacts, out_segments, out_states};
use crate::python::run_facts::{PyEnergy, PyStats};
use crate::python::text::html;
use crate::python::{argument, files, interrupt};
use crate::quantity::room_for;
use crate::simulate::{Samples, SavedTrajectory, Trajectory};
use nalgebra::DVector;
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

    fn states(
        &self,
        t: &Bound<'_, PyAny>,
        side: &str,
    ) -> PyResult<(Vec<(DVector<f64>, DVector<f64>)>, bool)> {
        let side = self::side(side)?;
        let (times, is_single) = times("t", t)?;
        let core = &self.core;
        room_for(
            "the motion at these times",
            times.len(),
            4 * core.scene().n_dof(),
        )?;
        let states = interrupt::run(t.py(), false, || {
            let state = |&t: &f64| {
                unless_broken_off()?;
                core.state(t, side)
            };
            times.iter().map(state).collect::<crate::Result<Vec<_>>>()
        })?;
        Ok((states, is_single))
    }
}

#[pymethods]
impl PyTrajectory {
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

    /// The motion along a direction n: ``n.q``, ``n.v`` or ``n.a``, such as that of the tip of a beam.
    ///
    /// Parameters
    /// ----------
    /// direction : int or array_like, shape (n,)
    ///     Index of a coordinate, counted from 0, or the direction n itself.
    /// t : float or array_like, shape (m,), optional
    ///     Times [s]; default: ``trajectory.t``, where points for drawing stand on both sides of each impact, each on its own.
    /// derivative : {0, 1, 2}, default 0
    ///     Position, velocity or acceleration.
    /// side : {"after", "before"}, default "after"
    ///     Which velocity and acceleration are meant at an impact.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), or () for a single time
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A direction that is no index from 0 to n - 1 and no vector of n finite numbers, another derivative or side, a time
    ///     outside the span; a motion that was not kept, but for position and velocity at ``t_eval``.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import vibroimpact as vi
    /// >>> beam = vi.LinearSystem(np.ones(2), [0.02, 0.1], [1.0, 8.0])   # two modes
    /// >>> tip = np.array([1.0, -1.0])                                   # the modes at the tip
    /// >>> run = vi.simulate(vi.Scene(beam, vi.Harmonic(0.3 * tip, 0.9), vi.Stop(tip, 0.5, 0.8)), [0, 0], [0, 0], (0, 50))
    /// >>> bool(run.along(tip).max() < 0.5 + 1e-12)
    /// True
    #[pyo3(signature = (direction, t=None, derivative=0, side="after"))]
    fn along<'py>(
        &self,
        py: Python<'py>,
        direction: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = argument::derivative)] derivative: i64,
        #[pyo3(from_py_with = argument::side)] side: &str,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let direction = normal("direction", direction)?;
        let (order, side) = (self::derivative(derivative)?, self::side(side)?);
        let ((times, is_single), core) = (times_or_points(t)?, &self.core);
        let values = interrupt::run(py, false, || {
            core.along(direction, times.as_deref(), order, side)
        })?;
        out_values(py, values, is_single)
    }

    /// Acceleration at times inside the span, by the equations of motion; needs keep="motion".
    ///
    /// While a stop is held it is that of the motion along the stop; in a segment "chatter" the same, which is the mean over the
    /// impacts that accumulate.
    ///
    /// Parameters
    /// ----------
    /// t : float or array_like, shape (m,)
    ///     Times [s].
    /// side : {"after", "before"}, default "after"
    ///     Which acceleration is meant at an impact.
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
    fn acceleration<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = argument::side)] side: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (side, (times, is_single)) = (self::side(side)?, times("t", t)?);
        let (core, n) = (&self.core, self.core.scene().n_dof());
        room_for("the accelerations at these times", times.len(), 2 * n)?;
        let rows = interrupt::run(py, false, || core.accelerations(&times, side))?;
        out_states(py, &rows, n, is_single)
    }

    /// The gap of a stop.
    ///
    /// Parameters
    /// ----------
    /// stop : int
    ///     Index of the stop, counted from 0.
    /// t : float or array_like, shape (m,), optional
    ///     Times [s]; default: ``trajectory.t``.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), or () for a single time
    ///     Not below zero but for rounding or the tolerance of steps.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A stop that the scene does not have, a time outside the span; a motion that was not kept, but for the gap at ``t_eval``.
    ///
    /// Examples
    /// --------
    /// >>> import vibroimpact as vi
    /// >>> ball = vi.LinearSystem(1.0, 0.0, 0.0, load=[-9.81])
    /// >>> run = vi.simulate(vi.Scene(ball, stops=vi.Stop(0, 0.0, 0.5, side="lower")), 1.0, 0.0, (0, 2))
    /// >>> run.gap(0, [0.0, 2.0]).round(12) + 0.0
    /// array([1., 0.])
    #[pyo3(signature = (stop, t=None))]
    fn gap<'py>(
        &self,
        py: Python<'py>,
        stop: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (stop, (times, is_single)) = (stop_index("stop", stop)?, times_or_points(t)?);
        let core = &self.core;
        let values = interrupt::run(py, false, || core.gap(stop, times.as_deref()))?;
        out_values(py, values, is_single)
    }

    /// The force of a stop in lasting contact; needs keep="motion".
    ///
    /// Parameters
    /// ----------
    /// stop : int
    ///     Index of the stop, counted from 0.
    /// t : float or array_like, shape (m,), optional
    ///     Times [s]; default: ``trajectory.t``. At the end of a contact the side after is meant.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), or () for a single time
    ///     L >= 0 in ``a = a_free - b L``: a force along the stop's normal for the reaction "inertia", in the unit of an
    ///     acceleration for "coordinate"; zero outside of segments "stick". Impacts that accumulate (a segment "chatter") have
    ///     an ``impulse`` instead.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A stop that the scene does not have, a time outside the span, a motion that was not kept.
    ///
    /// Examples
    /// --------
    /// >>> import vibroimpact as vi
    /// >>> ball = vi.LinearSystem(2.0, 0.0, 0.0, load=[-2.0 * 9.81])
    /// >>> run = vi.simulate(vi.Scene(ball, stops=vi.Stop(0, 0.0, 0.5, side="lower")), 1.0, 0.0, (0, 3))
    /// >>> run.contact_force(0, [0.1, 2.9]).round(12)                    # in flight, and at rest: its weight
    /// array([ 0.  , 19.62])
    #[pyo3(signature = (stop, t=None))]
    fn contact_force<'py>(
        &self,
        py: Python<'py>,
        stop: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (stop, (times, is_single)) = (stop_index("stop", stop)?, times_or_points(t)?);
        let core = &self.core;
        let values = interrupt::run(py, false, || core.contact_force(stop, times.as_deref()))?;
        out_values(py, values, is_single)
    }

    /// All that a stop gave: impacts, impacts that accumulate, the force of lasting contact over its time; needs keep="motion".
    ///
    /// Parameters
    /// ----------
    /// stop : int
    ///     Index of the stop, counted from 0.
    /// span : pair of float, optional
    ///     From right after its start to right after its end [s], inside the run; default: all of it. An impact at the start of
    ///     the run counts where the span begins there.
    ///
    /// Returns
    /// -------
    /// float
    ///     Sum of p in ``v+ = v- - b p`` and of the contact force over its time: an impulse along the stop's normal for the reaction
    ///     "inertia", in the unit of a velocity for "coordinate".
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A stop that the scene does not have, a span that runs backwards or leaves the run, a motion that was not kept.
    ///
    /// Notes
    /// -----
    /// It is the sum of ``impacts["impulse"]`` and ``segments["impulse"]`` of the stop, and closes the balance of momentum:
    /// ``M (v(t2) - v(t1))`` is the integral of all other forces less the impulses along the normals.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import vibroimpact as vi
    /// >>> ball = vi.LinearSystem(2.0, 0.0, 0.0, load=[-2.0 * 9.81])     # dropped from 1 m, it bounces and comes to rest
    /// >>> run = vi.simulate(vi.Scene(ball, stops=vi.Stop(0, 0.0, 0.5, side="lower")), 1.0, 0.0, (0, 3))
    /// >>> bool(np.isclose(run.impulse(0), 3 * 2.0 * 9.81))              # what its weight gave in three seconds
    /// True
    #[pyo3(signature = (stop, span=None))]
    fn impulse(
        &self,
        py: Python<'_>,
        stop: &Bound<'_, PyAny>,
        span: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<f64> {
        let (stop, span) = (stop_index("stop", stop)?, window(span)?);
        let core = &self.core;
        interrupt::run(py, false, || core.impulse(stop, span))
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

    /// Impacts: structured array of time [s], stop, speed_before, speed_after [m/s], impulse [N s], phase [rad].
    #[getter]
    fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_impacts(py, self.core.impacts())
    }

    /// Touches without impact, minima of a gap within its rounding of zero: structured array of time [s], stop, depth [m].
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
        let energy = interrupt::run(py, false, || core.energy())?;
        Ok(PyEnergy(energy))
    }

    /// Segments: structured array of kind ("flight", "chatter", "stick"), stop (-1: none), start, end [s], impulse [N s] (what the stop gives on
    /// it, beside the impacts that are listed: the rest of impacts that accumulate, the contact force over its time); needs
    /// keep="motion".
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let core = &self.core;
        let segments = interrupt::run(py, false, || core.segments())?;
        out_segments(py, &segments)
    }

    /// Final position and velocity, shapes (n,) and (n,).
    #[getter]
    #[pyo3(name = "final")]
    fn last<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let (q, v) = self.core.last();
        (out_vector(py, q), out_vector(py, v))
    }

    /// Time at which the run ended [s], that of ``final``, with every ``keep``: the run goes on with
    /// ``simulate(scene, *run.final, (run.t_end, later))``, in the same phase of the forcing; after a ramp with the numbers reached, and the
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

    /// Write the trajectory to a file, from which ``load`` reads it again, equal to the bit.
    ///
    /// The file is an ``.npz`` archive of arrays with a header in JSON: the versions of the format and of the library, the scene, and what
    /// the trajectory is made of. Nothing in it is pickled.
    ///
    /// Parameters
    /// ----------
    /// path : str or path-like
    ///     The file, as it is to be called.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A scene with functions (NonlinearSystem, NonlinearStop), which a file cannot hold.
    fn save(slf: &Bound<'_, Self>, path: &Bound<'_, PyAny>) -> PyResult<()> {
        files::save(slf.as_any(), path)
    }

    /// The trajectory as an ``xarray.Dataset`` with named dimensions; needs xarray, the extra "xarray".
    ///
    /// Returns
    /// -------
    /// xarray.Dataset
    ///     ``q`` and ``v`` over time and dof, columns of impacts, grazes and segments (``impact_time``, ...), ``final_q`` and ``final_v``,
    ///     derivatives over time and state (``derivatives_clearance``, ...) or state alone; status, message and end as attributes.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     Without xarray.
    fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        files::to_xarray(slf.as_any())
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

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        html(slf.as_any(), "trajectory")
    }

    fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<()> {
        Err(no_attribute(slf.as_any(), name))
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
        samples,
    };
    let scene = &scene.0;
    let core = interrupt::run(py, false, || Trajectory::restore(scene, saved))?;
    Ok(match derived {
        Some(derived) => PyTrajectory::with_derivatives(core, derived),
        None => PyTrajectory::new(core),
    })
}

/// Refuses a trajectory from a file that its scene cannot have.
#[pyfunction]
pub(crate) fn _check_trajectory(py: Python<'_>, trajectory: &PyTrajectory) -> PyResult<()> {
    interrupt::run(py, false, || trajectory.core.check_kept())
}

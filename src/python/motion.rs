//! What Python has of a motion, the same of trajectories and orbits: their outputs, sections, files; and their arguments and arrays.

use crate::error::Result;
use crate::model::PhysicalState;
use crate::path::KeptMotion;
use crate::python::array::{self, vector};
use crate::python::interrupt;
use crate::python::pattern::stop_index;
use crate::quantity::room_for;
use crate::simulate::ImpactSide;
use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Times in Python, which a class may leave out: then there are none, for where the motion is sampled.
pub(crate) trait TimesArgument {
    /// The times, and whether a single one was given.
    fn times(self) -> PyResult<(Option<Vec<f64>>, bool)>;
}

impl TimesArgument for &Bound<'_, PyAny> {
    fn times(self) -> PyResult<(Option<Vec<f64>>, bool)> {
        let (times, is_single) = array::times("t", self)?;
        Ok((Some(times), is_single))
    }
}

impl TimesArgument for Option<&Bound<'_, PyAny>> {
    fn times(self) -> PyResult<(Option<Vec<f64>>, bool)> {
        self.map_or(Ok((None, false)), TimesArgument::times)
    }
}

/// A side of an impact by its name.
pub(crate) fn side(name: &str) -> PyResult<ImpactSide> {
    match name {
        "after" => Ok(ImpactSide::After),
        "before" => Ok(ImpactSide::Before),
        _ => Err(PyValueError::new_err(format!(
            "side is {name:?}, but it must be \"after\" or \"before\""
        ))),
    }
}

/// The order of a derivative, none below zero.
pub(crate) fn derivative(order: i64) -> PyResult<usize> {
    usize::try_from(order).map_err(|_| {
        PyValueError::new_err(format!(
            "derivative is {order}, but it must be 0 (position), 1 (velocity) or 2 (acceleration)"
        ))
    })
}

/// A span of times, or none.
pub(crate) fn window(span: Option<&Bound<'_, PyAny>>) -> PyResult<Option<(f64, f64)>> {
    let Some(span) = span else {
        return Ok(None);
    };
    match vector("span", span)?.as_slice() {
        &[start, end] => Ok(Some((start, end))),
        other => Err(PyValueError::new_err(format!(
            "span has shape ({},), but (start, end) is needed",
            other.len()
        ))),
    }
}

/// Values of a stop at times, or where the motion is sampled.
pub(crate) fn out_at_stop<'py>(
    py: Python<'py>,
    stop: &Bound<'py, PyAny>,
    times: impl TimesArgument,
    values: impl FnOnce(usize, Option<&[f64]>) -> Result<Vec<f64>> + Send,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let stop = stop_index("stop", stop)?;
    let (times, is_single) = times.times()?;
    let values = interrupt::run(py, false, || values(stop, times.as_deref()))?;
    out_values(py, values, is_single)
}

/// Values at times as shape (m,), or () for a single one.
pub(crate) fn out_values(
    py: Python<'_>,
    values: Vec<f64>,
    is_single: bool,
) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    let shape = if is_single {
        Vec::new()
    } else {
        vec![values.len()]
    };
    values.into_pyarray(py).reshape(shape)
}

/// The states of a motion at some times, and whether a single one was given.
pub(crate) fn states<M: KeptMotion + Sync>(
    motion: &M,
    t: &Bound<'_, PyAny>,
    side: ImpactSide,
) -> PyResult<(Vec<PhysicalState>, bool)> {
    let (times, is_single) = array::times("t", t)?;
    let width = 4 * motion.scene().n_dof();
    room_for("the motion at these times", times.len(), width)?;
    let states = interrupt::run(t.py(), false, || motion.states(&times, side))?;
    Ok((states, is_single))
}

/// A class of a motion, which `results/html.py` shows under a name: what is measured of it, at times that are left out as the signature says,
/// and its other methods.
macro_rules! motion_class {
    ($class:ident as $form:literal |$own:ident| $motion:expr; ($($t:tt)*): $times:ty; $($rest:tt)*) => {
        #[pymethods]
        impl $class {
            /// The scene, of an orbit with its phase and clearances: simulated from (q0, v0) at t = 0 it retraces the orbit.
            #[getter]
            fn scene(&self) -> $crate::python::model::PyScene {
                let $own = self;
                let motion = &$motion;
                $crate::python::model::PyScene(motion.scene().clone())
            }

            /// Position at some times; of a trajectory needs keep="motion".
            ///
            /// Parameters
            /// ----------
            /// t : float or array_like, shape (m,)
            ///     Times [s]: inside the span of a trajectory, any real numbers of an orbit.
            ///
            /// Returns
            /// -------
            /// ndarray, shape (m, n), or (n,) for a single time
            ///
            /// Raises
            /// ------
            /// ValueError
            ///     A time outside the span, or that is not finite; a motion that was not kept.
            fn position<'py>(&self, py: Python<'py>, t: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                let after = $crate::simulate::ImpactSide::After;
                let (states, is_single) = $crate::python::motion::states(motion, t, after)?;
                let rows: Vec<_> = states.into_iter().map(|state| state.0).collect();
                $crate::python::rows::out_states(py, &rows, motion.scene().n_dof(), is_single)
            }

            /// Velocity at some times; of a trajectory needs keep="motion".
            ///
            /// What is left of impacts that accumulate (a segment "chatter") is given as motion with the stop held: its velocity is off
            /// the true one, which jumps without end there, by no more than the speed of the first impact left out, along the stop's
            /// reaction.
            ///
            /// Parameters
            /// ----------
            /// t : float or array_like, shape (m,)
            ///     Times [s]: inside the span of a trajectory, any real numbers of an orbit.
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
            ///     A time outside the span, or that is not finite; another side; a motion that was not kept.
            #[pyo3(signature = (t, side="after"))]
            fn velocity<'py>(
                &self,
                py: Python<'py>,
                t: &Bound<'py, PyAny>,
                #[pyo3(from_py_with = $crate::python::argument::side)] side: &str,
            ) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                let side = $crate::python::motion::side(side)?;
                let (states, is_single) = $crate::python::motion::states(motion, t, side)?;
                let rows: Vec<_> = states.into_iter().map(|state| state.1).collect();
                $crate::python::rows::out_states(py, &rows, motion.scene().n_dof(), is_single)
            }

            /// The motion along a direction n: ``n.q``, ``n.v`` or ``n.a``, such as that of the tip of a beam.
            ///
            /// Parameters
            /// ----------
            /// direction : int or array_like, shape (n,)
            ///     Index of a coordinate, counted from 0, or the direction n itself.
            /// t : float or array_like, shape (m,)
            ///     Times [s]: inside the span of a trajectory, any real numbers of an orbit. Of a trajectory they may be left out; default:
            ///     ``trajectory.t``, where points for drawing stand on both sides of each impact, each on its own.
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
            ///     outside the span or that is not finite; a motion that was not kept, but for position and velocity at ``t_eval``.
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
            /// >>> orbit = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
            /// >>> bool(abs(orbit.along(1, 0.0) - 0.15) < 1e-12)                  # on the stop of the lower pendulum
            /// True
            #[pyo3(signature = (direction, $($t)*, derivative=0, side="after"))]
            fn along<'py>(
                &self,
                py: Python<'py>,
                direction: &Bound<'py, PyAny>,
                t: $times,
                #[pyo3(from_py_with = $crate::python::argument::derivative)] derivative: i64,
                #[pyo3(from_py_with = $crate::python::argument::side)] side: &str,
            ) -> PyResult<Bound<'py, numpy::PyArrayDyn<f64>>> {
                let $own = self;
                let motion = &$motion;
                let direction = $crate::python::model::normal("direction", direction)?;
                let order = $crate::python::motion::derivative(derivative)?;
                let side = $crate::python::motion::side(side)?;
                let (times, is_single) = $crate::python::motion::TimesArgument::times(t)?;
                let values = || motion.along(direction, times.as_deref(), order, side);
                let values = $crate::python::interrupt::run(py, false, values)?;
                $crate::python::motion::out_values(py, values, is_single)
            }

            /// Acceleration at some times, by the equations of motion; of a trajectory needs keep="motion".
            ///
            /// While a stop is held it is that of the motion along the stop; in a segment "chatter" the same, which is the mean over the
            /// impacts that accumulate.
            ///
            /// Parameters
            /// ----------
            /// t : float or array_like, shape (m,)
            ///     Times [s]: inside the span of a trajectory, any real numbers of an orbit.
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
            ///     A time outside the span, or that is not finite; another side; a motion that was not kept.
            #[pyo3(signature = (t, side="after"))]
            fn acceleration<'py>(
                &self,
                py: Python<'py>,
                t: &Bound<'py, PyAny>,
                #[pyo3(from_py_with = $crate::python::argument::side)] side: &str,
            ) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                let side = $crate::python::motion::side(side)?;
                let (times, is_single) = $crate::python::array::times("t", t)?;
                let n = motion.scene().n_dof();
                $crate::quantity::room_for("the accelerations at these times", times.len(), 2 * n)?;
                let rows = || $crate::path::KeptMotion::accelerations(motion, &times, side);
                let rows = $crate::python::interrupt::run(py, false, rows)?;
                $crate::python::rows::out_states(py, &rows, n, is_single)
            }

            /// The gap of a stop.
            ///
            /// Parameters
            /// ----------
            /// stop : int
            ///     Index of the stop, counted from 0.
            /// t : float or array_like, shape (m,)
            ///     Times [s], as of ``along``.
            ///
            /// Returns
            /// -------
            /// ndarray, shape (m,), or () for a single time
            ///     Of a trajectory not below zero but for rounding or the tolerance of steps.
            ///
            /// Raises
            /// ------
            /// ValueError
            ///     A stop that the scene does not have, a time outside the span or that is not finite; a motion that was not kept, but for the
            ///     gap at ``t_eval``.
            ///
            /// Examples
            /// --------
            /// >>> import vibroimpact as vi
            /// >>> ball = vi.LinearSystem(1.0, 0.0, 0.0, load=[-9.81])
            /// >>> run = vi.simulate(vi.Scene(ball, stops=vi.Stop(0, 0.0, 0.5, side="lower")), 1.0, 0.0, (0, 2))
            /// >>> run.gap(0, [0.0, 2.0]).round(12) + 0.0
            /// array([1., 0.])
            #[pyo3(signature = (stop, $($t)*))]
            fn gap<'py>(
                &self,
                py: Python<'py>,
                stop: &Bound<'py, PyAny>,
                t: $times,
            ) -> PyResult<Bound<'py, numpy::PyArrayDyn<f64>>> {
                let $own = self;
                let motion = &$motion;
                let gap = |stop, times: Option<&[f64]>| motion.gap(stop, times);
                $crate::python::motion::out_at_stop(py, stop, t, gap)
            }

            /// The force of a stop in lasting contact; of a trajectory needs keep="motion".
            ///
            /// Parameters
            /// ----------
            /// stop : int
            ///     Index of the stop, counted from 0.
            /// t : float or array_like, shape (m,)
            ///     Times [s], as of ``along``. At the end of a contact the side after is meant.
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
            ///     A stop that the scene does not have, a time outside the span or that is not finite, a motion that was not kept.
            ///
            /// Examples
            /// --------
            /// >>> import vibroimpact as vi
            /// >>> ball = vi.LinearSystem(2.0, 0.0, 0.0, load=[-2.0 * 9.81])
            /// >>> run = vi.simulate(vi.Scene(ball, stops=vi.Stop(0, 0.0, 0.5, side="lower")), 1.0, 0.0, (0, 3))
            /// >>> run.contact_force(0, [0.1, 2.9]).round(12)                    # in flight, and at rest: its weight
            /// array([ 0.  , 19.62])
            #[pyo3(signature = (stop, $($t)*))]
            fn contact_force<'py>(
                &self,
                py: Python<'py>,
                stop: &Bound<'py, PyAny>,
                t: $times,
            ) -> PyResult<Bound<'py, numpy::PyArrayDyn<f64>>> {
                let $own = self;
                let motion = &$motion;
                let force = |stop, times: Option<&[f64]>| motion.contact_force(stop, times);
                $crate::python::motion::out_at_stop(py, stop, t, force)
            }

            /// All that a stop gives: impacts, impacts that accumulate, the force of lasting contact over its time; of a trajectory needs
            /// keep="motion".
            ///
            /// Parameters
            /// ----------
            /// stop : int
            ///     Index of the stop, counted from 0.
            /// span : pair of float, optional
            ///     From right after its start to right after its end [s]; default: all of a run, one period of an orbit. Inside the run, where an
            ///     impact at its start counts if the span begins there; any real numbers of an orbit.
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
            ///     A stop that the scene does not have, a span that runs backwards, is not finite or leaves the run, a motion that was not kept.
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
            /// >>> ball = vi.LinearSystem(1.0, 0.0, 0.0, load=[-1.0])            # on a shaken table, its weight is 1
            /// >>> scene = vi.Scene(ball, vi.Harmonic(1.2, 1.0), vi.Stop(0, 0.0, 0.5, side="lower"))
            /// >>> orbit = vi.periodic_orbits(scene, pattern=[0])[0]
            /// >>> bool(np.isclose(orbit.impulse(0), orbit.period))              # carries it over a period
            /// True
            #[pyo3(signature = (stop, span=None))]
            fn impulse(
                &self,
                py: Python<'_>,
                stop: &Bound<'_, PyAny>,
                span: Option<&Bound<'_, PyAny>>,
            ) -> PyResult<f64> {
                let $own = self;
                let motion = &$motion;
                let stop = $crate::python::pattern::stop_index("stop", stop)?;
                let span = $crate::python::motion::window(span)?;
                $crate::python::interrupt::run(py, false, || motion.impulse(stop, span))
            }

            /// Impacts, of an orbit those of one period: structured array of time [s], stop, speed_before, speed_after [m/s], impulse [N s],
            /// phase [rad].
            #[getter]
            fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                $crate::python::rows::out_impacts(py, motion.impacts())
            }

            /// Segments, of an orbit those of one period: structured array of kind ("flight", "chatter", "stick"), stop (-1: none), start, end [s],
            /// impulse [N s] (what the stop gives on it, beside the impacts that are listed: the rest of impacts that accumulate, the contact force
            /// over its time); of a trajectory needs keep="motion".
            #[getter]
            fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                let segments = $crate::python::interrupt::run(py, false, || motion.segments())?;
                $crate::python::rows::out_segments(py, &segments)
            }

            /// Contacts by their starts, of an orbit those of one period: structured array of stop, start, end [s], phase (of the start)
            /// [rad], speed_before, speed_after [m/s] (nan where the motion begins or ends in it), impulse [N s], peak_force [N] (inf of an
            /// impact), peak_approach [m], loss [J] (nan of impacts on rigid stops whose reactions are not those of inertia, with
            /// keep="impacts"); not of a trajectory with keep="final".
            #[getter]
            fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                let contacts = $crate::python::interrupt::run(py, false, || motion.contacts())?;
                $crate::python::rows::out_contacts(py, &contacts)
            }

            /// Regimes, of an orbit those of one period: structured array of start, end [s], mode (0), state: "free", "held", "pressed",
            /// "relaxing", "idle" or "seated" of each of ``scene.elements``; of a trajectory needs keep="motion".
            #[getter]
            fn regimes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                let motion = &$motion;
                let rows = motion.regimes()?;
                $crate::python::rows::out_regimes(py, &rows, motion.scene().stops().len())
            }

            /// The energy ledger: of a trajectory at the times ``trajectory.t``, which needs keep="motion"; of one period of an orbit, from right after
            /// the first impact to right after it a period later (``t``, both sides of each impact), where what the forcing brought is what was lost in
            /// dampers and at impacts.
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
            fn energy(&self, py: Python<'_>) -> PyResult<$crate::python::run_facts::PyEnergy> {
                let $own = self;
                let motion = &$motion;
                let energy = $crate::python::interrupt::run(py, false, || motion.energy())?;
                Ok($crate::python::run_facts::PyEnergy(energy))
            }

            /// Write the motion to a file, from which ``load`` reads it again, equal to the bit.
            ///
            /// The file is an ``.npz`` archive of arrays with a header in JSON: the versions of the format and of the library, the scene, and what
            /// the motion is made of. Nothing in it is pickled.
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
                $crate::python::files::save(slf.as_any(), path)
            }

            /// The motion as an ``xarray.Dataset`` with named dimensions; needs xarray, the extra "xarray".
            ///
            /// Returns
            /// -------
            /// xarray.Dataset
            ///     Columns of impacts and segments (``impact_time``, ...). Of a trajectory ``q`` and ``v`` over time and dof, columns of grazes,
            ///     ``final_q`` and ``final_v``, derivatives over time and state (``derivatives_clearance``, ...) or state alone; status, message and
            ///     end as attributes. Of an orbit ``q0`` and ``v0`` over dof, ``floquet_multipliers``; period, phase, pattern and verdicts as
            ///     attributes.
            ///
            /// Raises
            /// ------
            /// ImportError
            ///     Without xarray.
            fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
                $crate::python::files::to_xarray(slf.as_any())
            }

            /// Refuse a motion from a file that its scene cannot have.
            fn _check_kept(&self, py: Python<'_>) -> PyResult<()> {
                let $own = self;
                let motion = &$motion;
                $crate::python::interrupt::run(py, false, || motion.check_kept())
            }

            fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
                $crate::python::text::html(slf.as_any(), $form)
            }

            fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<()> {
                Err($crate::python::answered::no_attribute(slf.as_any(), name))
            }

            $($rest)*
        }
    };
}
pub(crate) use motion_class;

//! Simulation in Python.

use crate::python::array::{times, vector};
use crate::python::derivative;
use crate::python::model::PyScene;
use crate::python::motion_state::PyMotionState;
use crate::python::ramp::ramps;
use crate::python::trajectory::PyTrajectory;
use crate::python::{argument, interrupt};
use crate::simulate::{self as core, Keep, Method, MotionState, SimulateOptions, Solver};
use nalgebra::DVector;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// What is kept, by its name.
pub(crate) fn keep(value: &str) -> PyResult<Keep> {
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
    if let Ok(pair) = value.extract::<(f64, f64)>() {
        return Ok(pair);
    }
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

/// The method of a name, in any letter case.
pub(crate) fn solver(method: &str, rtol: f64, atol: Option<f64>) -> PyResult<Solver> {
    let method = Method::from_name(method)?;
    Ok(Solver { method, rtol, atol })
}

/// Where a run begins.
enum GivenStart {
    Plain(DVector<f64>, DVector<f64>),
    State(Box<MotionState>),
}

/// The start of a run and its span: a position, a velocity and a span, or a state and a span, which comes in the second place or by name.
fn start(
    q0: &Bound<'_, PyAny>,
    v0: Option<&Bound<'_, PyAny>>,
    t_span: Option<&Bound<'_, PyAny>>,
) -> PyResult<(GivenStart, (f64, f64))> {
    if let Ok(state) = q0.cast::<PyMotionState>() {
        let (Some(given), None) = (v0.or(t_span), v0.and(t_span)) else {
            return Err(PyTypeError::new_err(
                "simulate() is given a state, which takes the place of q0 and v0: simulate(scene, state, t_span)",
            ));
        };
        return Ok((
            GivenStart::State(Box::new(state.get().0.clone())),
            span(given)?,
        ));
    }
    let missing: Vec<&str> = [("'v0'", v0), ("'t_span'", t_span)]
        .iter()
        .filter_map(|(name, value)| value.is_none().then_some(*name))
        .collect();
    let (Some(v0), Some(t_span)) = (v0, t_span) else {
        let plural = if missing.len() > 1 { "s" } else { "" };
        return Err(PyTypeError::new_err(format!(
            "simulate() missing {} required positional argument{plural}: {}",
            missing.len(),
            missing.join(" and ")
        )));
    };
    let plain = GivenStart::Plain(vector("q0", q0)?, vector("v0", v0)?);
    Ok((plain, span(t_span)?))
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
///     Position and velocity at the start. In their place the ``state`` of another run: ``simulate(scene, state, t_span)`` goes on from it.
/// t_span : pair of float
///     Start and end [s]; with a state, from its time on.
/// method : {"auto", "exact", "taylor", "rk45", "dop853", "radau"}, default "auto"
///     "exact": closed-form flights, linear scenes only; "taylor": Taylor series whose order grows with the digits asked for, a
///     DoublePendulum or a PendulumChain with stops and walls; any scene: "rk45", the Runge-Kutta pair of orders 5 and 4 of Dormand
///     and Prince; "dop853", their method of order 8; "radau", the implicit Radau IIA method of order 5, for stiff motions.
///     "auto": exact or taylor where the scene allows it; else dop853 for rtol below 1e-7 and rk45 above, and radau from the
///     step on at which the motion is found stiff, as ``message`` says. Any letter case.
/// rtol : float, default 1e-9
///     Relative tolerance [-] of each step of an integration; exact flights have no such error. With every method it says, with
///     ``atol``, when impacts that accumulate are completed, and how deep inside a stop a start may lie: one that lies inside by no more than
///     ``10 (atol |n|_1 + rtol * size)`` is moved onto it, in contact. That margin of exact flights is narrowed by tolerances stricter
///     than 1e-9 and 1e-12, but not widened by looser ones.
/// atol : float, optional
///     Absolute tolerance [units of the coordinates]. By default 1e-12 of how far the motion goes, so that a scene in other units of
///     length moves alike: of each gap 1e-12 times the largest of ``|clearance|``, the motion of the stop, the terms of ``n.q`` at
///     the start and in the steady response of a linear scene (without its resonances), and those of ``n.v`` at the start times the
///     time of a turn (a period of the forcing or one over the fastest rate, whichever is shorter); where steps are taken one number,
///     of the smallest of the coordinates and their speeds; 1e-12 where all are zero. ``stats.atol`` has the smallest that was used.
/// t_eval : array_like, shape (m,), optional
///     Times at which the motion is wanted, ascending.
/// keep : {"motion", "impacts", "final"}, default "motion"
///     What is kept: the whole motion; the impacts and contacts (and ``t_eval``); the final state (and ``t_eval``) in constant memory.
/// max_impacts : int, optional
///     The run ends after this many impacts.
/// ramp : Ramp, or sequence of Ramp, optional
///     Numbers of the scene that drift along the run. In levels every method follows them, and exact flights stay exact. Steadily:
///     clearances and restitutions in every method; of what acts on a linear scene "taylor", which "auto" picks: the force in pieces of
///     polynomials that are it to 1e-14, and exact flights under those; the damping in steps. ``parameter`` and ``phase`` of the
///     trajectory say where they are.
/// derivatives : str, or sequence of str, optional
///     Numbers of ``Scene.replace`` ("clearance[0]", "frequency", ...) by which the states are to be derived, q0 and v0 being the
///     same: ``derivatives`` of the trajectory, at ``t_eval`` or at the end. Needs ``keep="motion"`` and no ramp.
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
///     Arrays of the wrong shape or not finite, a span that runs backwards, a start deeper inside a stop than its margin,
///     ``method="exact"`` for a nonlinear scene, or along a steady ramp of what acts on it, a motion that grows beyond the doubles;
///     a ramp of a number that the scene does not have, or over a value that it may not take, two ramps of one number; a state of a
///     scene with other elements or of another size, a span that does not begin at its time.
/// TypeError
///     An argument of a wrong type.
///
/// Notes
/// -----
/// In exact flights each next impact is provably the first one: the gap is followed by cubics with a bound on what they
/// leave out. Steps of the pair [1]_ carry each gap along as the quintic that has its value, speed and acceleration at both
/// ends: every contact of the quintic is found, and reached by a step of its own, as is a minimum that the quintic cannot tell
/// from a contact. The longer steps of dop853 [2]_ and radau [3]_ are searched on the same quintic, with its distance from their own
/// polynomial as its error. radau uses the ``jacobian`` of a NonlinearSystem where there is one; its polynomial inside a step is
/// known to its estimate of the error alone, so that samples at rtol = 1e-11 are off by tens of tolerances where contacts and the end
/// are not. Along a Taylor series the gap is a polynomial with the same proof as in exact flights.
///
/// A stop that the computed motion passes by more than the rounding of the gap is hit, however slowly; no tolerance has a say. A
/// minimum within that rounding is a graze, in ``grazes`` and no impact, and so is a gap that stays within it. Of steps the
/// motion itself is off by their error: a touch that is closer than that may come out as an impact, or as none.
///
/// Impacts that accumulate are completed by the limit of their map (a segment "chatter"); a stop that stays in contact is held
/// (a segment "stick") and let go when its contact force falls through zero; several stops at one instant are resolved by
/// complementarity. What cannot be resolved, such as a jam, ends the run with status "unresolved_contact" and the reason in
/// ``message``; a search for contacts that cannot be certified, such as that of a gap that jumps, with "uncertain".
///
/// From the state of a run of the same scene exact flights go on, by the same tolerances, to the bit as a run that was not interrupted:
/// impacts, contacts, the motion at ``t_eval`` and at the end; in between on the flight that was under way but for the rounding of its last
/// digits. Steps begin anew, with a length of their own, and agree to the tolerances; so does a run of a scene with other numbers, or by other
/// tolerances. Each element goes on in its state. What (q0, v0) leaves open ``message`` says where it matters: a stop that relaxes is taken
/// to do so from where the body is.
///
/// Ctrl-C is answered within 0.2 s, but for one piece of work: in exact flights the first lasting contact of n coordinates
/// that are damped takes an eigenproblem of order 2 n, at 200 of them a second or more.
///
/// References
/// ----------
/// .. [1] J. R. Dormand and P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980) 19.
/// .. [2] E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, section II.10.
/// .. [3] E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II", Springer 1996, section IV.8.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> orbit = vi.periodic_orbits(vi.paper_scene(kind=3), [1], n_periods=2)[0]
/// >>> run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 100.5 * orbit.period))
/// >>> run.status, len(run.impacts)
/// ('finished', 100)
///
/// How a motion changes with the place of a stop and its restitution:
///
/// >>> scene = vi.Scene(vi.LinearSystem(1, 0.0, 0.0), stops=vi.Stop(0, 1.0, 0.5))
/// >>> run = vi.simulate(scene, 0.0, 2.0, (0, 2), derivatives=("clearance", "restitution"))
/// >>> {name: own.round(9).tolist() for name, own in run.derivatives.items()}
/// {'clearance': [1.5, 0.0], 'restitution': [-3.0, -2.0]}
#[pyfunction]
#[pyo3(signature = (scene, q0, v0=None, t_span=None, *, method="auto", rtol=1e-9, atol=None, t_eval=None, keep="motion", max_impacts=None, ramp=None, derivatives=None, progress=false))]
#[allow(clippy::too_many_arguments)] // the public signature
pub(crate) fn simulate(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    q0: &Bound<'_, PyAny>,
    v0: Option<&Bound<'_, PyAny>>,
    t_span: Option<&Bound<'_, PyAny>>,
    #[pyo3(from_py_with = argument::method)] method: &str,
    #[pyo3(from_py_with = argument::rtol)] rtol: f64,
    #[pyo3(from_py_with = argument::atol)] atol: Option<f64>,
    t_eval: Option<&Bound<'_, PyAny>>,
    #[pyo3(from_py_with = argument::keep)] keep: &str,
    #[pyo3(from_py_with = argument::max_impacts)] max_impacts: Option<i64>,
    ramp: Option<&Bound<'_, PyAny>>,
    derivatives: Option<&Bound<'_, PyAny>>,
    #[pyo3(from_py_with = argument::progress)] progress: bool,
) -> PyResult<PyTrajectory> {
    let (start, t_span) = start(q0, v0, t_span)?;
    let max_impacts = count("max_impacts", max_impacts)?;
    let t_eval = t_eval.map(|t| times("t_eval", t)).transpose()?.map(|t| t.0);
    let options = SimulateOptions {
        solver: solver(method, rtol, atol)?,
        t_eval,
        keep: self::keep(keep)?,
        max_impacts,
        ramps: ramps(ramp)?,
    };
    let model = &scene.0;
    let names = derivatives.map(|given| derivative::names_for_run(model, given));
    let names = names.transpose()?;
    if let (Some(_), false) = (
        &names,
        options.keep == Keep::Motion && options.ramps.is_empty(),
    ) {
        return Err(PyValueError::new_err(
            "derivatives are asked for, which need keep=\"motion\" and no ramp",
        ));
    }
    let core = interrupt::run(py, progress, || match &start {
        GivenStart::Plain(q0, v0) => core::simulate(model, q0, v0, t_span, &options),
        GivenStart::State(state) => core::simulate_from(model, state, t_span, &options),
    })?;
    let Some(names) = names else {
        return Ok(PyTrajectory::new(core));
    };
    let times = options.t_eval.as_deref();
    let found = derivative::of_run(py, &core, names, times)?;
    Ok(PyTrajectory::with_derivatives(core, found))
}

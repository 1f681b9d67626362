//! `find_orbit`.

use crate::orbit::{self, Guess};
use crate::python::array::vector;
use crate::python::model::PyScene;
use crate::python::orbit::PyOrbit;
use crate::python::simulate::count;
use crate::python::trajectory::PyTrajectory;
use crate::python::{argument, interrupt, pattern};
use nalgebra::DVector;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// A periodic motion near a guess: another orbit (of other parameters, say), a trajectory that comes near it, or a state.
///
/// Any scene, any number of instants; flights in closed form, or integrated to 2e-13; Newton's method on the flight times and
/// the states after the impacts, regular also where an impact has no speed. Where the orbits form a family, the member
/// nearest the guess is returned. The motion may chatter, stay on stops and be let go: see ``segments`` of the orbit, whose
/// t = 0 is then right after the first impact that follows a release. An orbit of a stop held for good has no impacts.
///
/// Parameters
/// ----------
/// scene : Scene
///     Any scene. Its forcing phase is not used: the orbit's own comes out.
/// guess : Orbit, Trajectory, (q0, v0), or (q0, v0, period)
///     An orbit of this pattern, of another scene with the same degrees of freedom; or a trajectory, with
///     ``keep="motion"``, whose end comes near the orbit; or a state at t = 0, at the scene's own forcing phase, from which the motion
///     is followed for ``n_periods`` (default 1), without forcing for the period. The pattern is the guess's.
/// n_periods : int, optional
///     Forcing periods in one period, 1 or more; default: those of the orbit, or the least number after which the
///     trajectory comes back. For an orbit a multiple of its own. Not for scenes without forcing, whose period is found.
/// pattern : list, optional
///     The stops to be hit, as in ``periodic_orbits``: from the state of the guess (of a trajectory the last one, of an orbit the
///     one in the middle of its last flight) they are hit in this order, each as soon as it is met, and all others are passed
///     through. So orbits are found that are not admissible, or whose pattern the motion from the guess has not. A trajectory
///     needs a forcing then; ``n_periods`` is 1, of an orbit its own, and may be any.
/// signature : sequence of (str, str or int), optional
///     The events of a period, as ``orbit.signature`` has them, in a linear scene: from that state they are waited for in this
///     order, each in the regime that those before have led to, and all other guards are passed by. "press", "leave" and "relax" of
///     stops that give way, "strike" of rigid ones; one that relaxes in the end is taken to be back at the beginning.
///
/// Returns
/// -------
/// Orbit
///     Closed to 1e-11 of its size; perhaps inadmissible (see ``violation``).
///
/// Raises
/// ------
/// ConvergenceError
///     If no motion of the pattern closes near the guess; it says how far the iteration got.
/// ValueError
///     A guess that does not fit it; a trajectory that did not keep its motion or does not come back; a stop of ``pattern`` that is
///     not hit within a period; an event of ``signature`` that does not come within one, or that the law of its stop has not then; stops let go at one time; a contact with e > 0 that comes to rest while another stop is held or hit; of
///     stops that give way a scene that is not linear, a body that comes to a seat or leaves it, a change of state at the instant of
///     another event.
/// TypeError
///     A guess that is none of these.
///
/// Notes
/// -----
/// Multiple shooting: unknown are the states after the impacts and the times of the impacts, each with the gap of the stop
/// hit as its equation. Which stop is met first is not asked, so that nothing is singular at a grazing impact. Impacts that
/// accumulate are one instant: they are gone through until what is left of them is 1e-12 of the motion, whatever the
/// tolerances of the guess, and completed there [1]_; a release is an instant whose contact force is zero. Each chatter that
/// ends in lasting contact has two zero multipliers, and so has each impact with e = 0 that does. Stops of a linear scene may give way:
/// t = 0 is then where a contact begins, each change of a state is an instant, and ``orbit.signature`` names them.
///
/// References
/// ----------
/// .. [1] A. B. Nordmark and P. T. Piiroinen, "Simulation and stability analysis of impacting systems with complete
///    chattering", Nonlinear Dynamics 58 (2009) 85.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> guess = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
/// >>> orbit = vi.find_orbit(vi.paper_scene(kind=3, damping=0.06), guess)
/// >>> orbit.is_admissible, orbit.n_periods
/// (True, 2)
///
/// A ball that chatters to rest on a shaken table and is let go where the table falls faster than it would:
///
/// >>> ball = vi.LinearSystem([1.0], [0.0], [0.0], load=[-1.0])
/// >>> scene = vi.Scene(ball, vi.Harmonic([1.3], 1.0), [vi.Stop(0, 0.0, 0.5, side="lower")])
/// >>> orbit = vi.find_orbit(scene, vi.simulate(scene, 0.3, 0.0, (0, 12 * scene.period)))
/// >>> orbit.is_admissible, bool(abs(orbit.floquet_multipliers).max() < 1e-12)
/// (True, True)
///
/// An unstable motion from where it is thought to be:
///
/// >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([7.0], 2.4), vi.Stop(0, 1.0, 0.8))
/// >>> known = vi.periodic_orbits(scene, [0])[0]
/// >>> vi.find_orbit(scene.replace(phase=known.phase), (1.0, -1.5)).is_stable
/// False
///
/// A motion before a stop that gives way:
///
/// >>> soft = vi.Stop(0, 0.5, contact=vi.Spring(20.0, 0.5, release="gap"))
/// >>> before = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 0.8), soft)
/// >>> orbit = vi.find_orbit(before, vi.simulate(before, 0.0, 0.3, (0, 60 * before.period)))
/// >>> orbit.signature, orbit.is_stable
/// ((('press', 'stop[0]'), ('leave', 'stop[0]')), True)
/// >>> again = vi.find_orbit(before, (0.0, 1.8), signature=[("press", "stop[0]"), ("leave", "stop[0]")])
/// >>> again.signature == orbit.signature
/// True
///
/// One that passes through a stop, whatever the motion from the guess does there:
///
/// >>> scene = scene.replace(stops=[vi.Stop(0, 1.0, 0.8), vi.Stop(0, 1.1, 0.8)])
/// >>> vi.find_orbit(scene, (0.0, 2.0), pattern=[1]).is_admissible
/// False
#[pyfunction]
#[pyo3(signature = (scene, guess, n_periods=None, *, pattern=None, signature=None))]
pub(crate) fn find_orbit(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    guess: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::n_periods)] n_periods: Option<i64>,
    pattern: Option<&Bound<'_, PyAny>>,
    signature: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyOrbit> {
    let pattern = pattern.map(pattern::pattern).transpose()?;
    let signature = signature.map(events).transpose()?;
    if pattern.is_some() && signature.is_some() {
        let rule = "pattern and signature are both given, but a signature has the pattern in it: leave one out";
        return Err(PyValueError::new_err(rule));
    }
    let n_periods = count("n_periods", n_periods)?;
    let orbit = guess.extract::<PyRef<'_, PyOrbit>>().ok();
    let trajectory = guess.extract::<PyRef<'_, PyTrajectory>>().ok();
    let state = state(guess)?;
    let guess = match (&orbit, &trajectory, &state) {
        (Some(orbit), ..) => Guess::Orbit(&orbit.0),
        (_, Some(trajectory), _) => Guess::Trajectory(&trajectory.core),
        (_, _, Some((q, v, period))) => Guess::State {
            q,
            v,
            period: *period,
        },
        _ => {
            let given = guess.get_type().name()?;
            return Err(PyTypeError::new_err(format!(
                "guess is of type {given}, but it must be an Orbit, a Trajectory or (q0, v0); of several orbits pass one, orbits[0]"
            )));
        }
    };
    let scene = &scene.0;
    let found = interrupt::run(py, false, || match (&pattern, &signature) {
        (Some(pattern), _) => orbit::find_orbit_in_order(scene, guess, n_periods, pattern),
        (None, Some(events)) => {
            let events: Vec<_> = events.iter().map(|own| (own.0.as_str(), own.1)).collect();
            orbit::find_orbit_of_signature(scene, guess, n_periods, &events)
        }
        (None, None) => orbit::find_orbit(scene, guess, n_periods),
    })?;
    Ok(PyOrbit(found))
}

/// The events of a signature: pairs of a name and an element, by its name or its number.
fn events(signature: &Bound<'_, PyAny>) -> PyResult<Vec<(String, usize)>> {
    let refused = |k: usize, own: &Bound<'_, PyAny>| {
        let found = own.repr().map(|text| text.to_string()).unwrap_or_default();
        PyValueError::new_err(format!(
            "signature[{k}] is {found}, but it must be a pair of an event and an element, as (\"press\", \"stop[0]\")"
        ))
    };
    let mut all = Vec::new();
    for (k, own) in signature.try_iter()?.enumerate() {
        let own = own?;
        let pair: Option<(String, Bound<'_, PyAny>)> = own.extract().ok();
        let (event, element) = pair.ok_or_else(|| refused(k, &own))?;
        let named = element.extract::<String>().ok().and_then(|name| {
            let number = name.strip_prefix("stop[")?.strip_suffix(']')?;
            number.parse().ok()
        });
        let number = named.or_else(|| element.extract::<usize>().ok());
        all.push((event, number.ok_or_else(|| refused(k, &own))?));
    }
    Ok(all)
}

/// Position, velocity and, where it is given, the period of a guess that is a tuple or a list of them.
fn state(guess: &Bound<'_, PyAny>) -> PyResult<Option<(DVector<f64>, DVector<f64>, Option<f64>)>> {
    let is_state = guess.is_instance_of::<PyTuple>() || guess.is_instance_of::<PyList>();
    if !is_state || !(2..=3).contains(&guess.len()?) {
        return Ok(None);
    }
    let part = |k: usize| vector(&format!("guess[{k}]"), &guess.get_item(k)?);
    let period = match guess.len()? {
        3 => Some(argument::period(&guess.get_item(2)?)?),
        _ => None,
    };
    Ok(Some((part(0)?, part(1)?, period)))
}

"""Branches: periodic orbits followed over a number of their scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import few, shown
from vibroimpact.results.branch import Branch
from vibroimpact.results.special import Candidate, Special

__all__ = ["continuation"]

Monitor = Callable[[Orbit], float]


def continuation(
    orbit: Orbit | Special | Candidate,
    parameter: str | Callable[[float], Scene],
    between: tuple[float, float],
    *,
    start: float | None = None,
    direction: str = "both",
    max_points: int = 2000,
    step: tuple[float, float, float] = (1e-8, 1e-3, 0.05),
    monitor: Mapping[str, Monitor] | None = None,
    virtual: str = "stop",
    symmetric: bool | None = None,
    progress: bool = False,
) -> Branch:
    """Follow a periodic orbit over a number of its scene, through folds.

    Parameters
    ----------
    orbit : Orbit, Candidate or Special
        An orbit of ``periodic_orbits`` or ``find_orbit``: linear or not, with or without forcing, through chatter and lasting
        contact, or one that hits nothing. A candidate of ``Special.branches``; of a special point its first one. Factors then
        count as on the branch that they come from.
    parameter : str or callable
        A number of ``Scene.replace`` ("frequency", "clearance[1]", "forcing_scale", ...; not "phase", which shifts time
        alone); "energy", of orbits that keep it (no forcing, no damping, elastic impacts), of which there is one at each value;
        or a callable ``p -> Scene``.
    between : (float, float)
        The range, with the orbit in it.
    start : float, optional
        Of a callable, its value at the orbit; a candidate knows it.
    direction : {"both", "up", "down"}, default "both"
        Which way at first; through folds it goes on.
    max_points : int, default 2000
        Points each way at the most.
    step : (float, float, float), default (1e-8, 1e-3, 0.05)
        The smallest, the first and the largest step: arclength of unknowns scaled to the size of the motion, and of the number
        in parts of its range.
    monitor : dict of str to callable, optional
        Functions ``f(orbit) -> float``, called with each orbit at the end; where one is zero the branch has a special point of
        the kind "user:name".
    virtual : {"stop", "keep"}, default "stop"
        Whether the branch ends at a boundary of motion, beyond which its orbits break a rule of contact (a stop is passed, an
        impact has lost its speed), or goes on with orbits that say so. Kept, it has its boundaries among its special points,
        but for those of orbits that break another rule already.
    symmetric : bool, optional
        Whether the motion is kept its own mirror image half a period later, ``q(t + T/2) = -q(t)``: by default where it is, in
        scenes that are odd (opposite stops that are alike, forces of odd harmonics). Such a branch cannot fall off its symmetry;
        where it ceases to be stable it has a pitchfork, at which two others are born.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    Branch
        The orbits and their stability, and why the branch ends. On Ctrl-C the branch so far, its end "interrupted"; in a monitor
        the exception has the branch, as ``.branch``.

    Raises
    ------
    ValueError
        A number that does not exist or that the stops do not share; a range that is upside down, not finite or without the
        orbit, or whose ends the number may not take; steps that are not in order; a callable without ``start``; an orbit that
        breaks a rule of contact, unless such orbits are kept; stops that are hit together; a motion without forcing that hits
        nothing; orbits that form a family (elastic impacts without damping) over another number than "energy", and over that
        those that form none; a monitor that is not finite; a special point from
        which no branch goes off; ``symmetric=True`` of an orbit that is not its own mirror image.
    ConvergenceError
        An orbit that does not close in the scene that the callable makes of ``start``.

    Notes
    -----
    From each orbit a step along the branch, and Newton's method back to it on the plane at right angles to the step [1]_, on the
    equations of ``find_orbit``. A step is halved until Newton's method converges at once, the branch turns by less than 0.35 and
    no impact moves by more than 0.5 in phase. The pattern is that of the orbit all along. A boundary is found by halves, to
    1e-11 in arclength. Between two points nothing is proved: what comes and goes there is not seen. An exception of the
    callable has the branch so far as ``.branch``; a ``ValueError`` of it is the end of its domain and none.

    A linear scene of 24 coordinates and more, whose modes all decay and whose stops are hit one at a time, is followed by the
    impulses and times of its impacts alone, two unknowns each, and its multipliers are counted without an eigenproblem:
    ``multipliers`` are nan then, and ``orbit.floquet_multipliers`` of an orbit are there as ever. Such a branch is kept its own
    mirror image only with ``symmetric=True``, which takes all unknowns (theory 19, "Many modes").

    Over "energy" the scene is one, and no orbit attracts: ``is_stable`` says that deviations do not grow, but by the difference
    of two periods, and tori are not looked for (theory 19, "Families").

    References
    ----------
    .. [1] E. J. Doedel, H. B. Keller and J. P. Kernevez, "Numerical analysis and control of bifurcation problems (II)",
       International Journal of Bifurcation and Chaos 1 (1991) 745.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> orbit = vi.periodic_orbits(scene, [0])[0]
    >>> branch = vi.continuation(orbit, "forcing_scale", (0.1, 1.5))
    >>> [(own.kind, round(8.5 * own.parameter, 6)) for own in branch.special]
    [('lost_impact', 4.766047), ('period_doubling', 7.733258)]

    How the period of a free mass before a stop shortens with its energy, from the touch at 1/2 on:

    >>> scene = vi.Scene(vi.LinearSystem(1, None, 1), stops=vi.Stop(0, 1.0, 1.0))
    >>> family = vi.continuation(vi.find_orbit(scene, (-2.0, 0.0, 4.2)), "energy", (0.1, 8.0))
    >>> family.special[0].kind, round(family.special[0].parameter, 9), round(family[-1].period, 6)
    ('lost_impact', 0.5, 3.646953)
    """
    begin, known = _orbit_of(orbit)
    if virtual not in ("stop", "keep"):
        message = f'virtual is {virtual!r}, but it must be "stop" or "keep"'
        raise ValueError(message)
    if not (isinstance(parameter, str) or callable(parameter)):
        message = f'parameter is {shown(parameter)}, but a number of Scene.replace, "energy" or a callable p -> Scene is needed'
        raise TypeError(message)
    if isinstance(parameter, str) and start is not None:
        message = f"start is {shown(start)}, but it is that of a callable: the orbit has its own {parameter}"
        raise ValueError(message)
    if symmetric is not None and not isinstance(symmetric, bool):
        message = f"symmetric is {symmetric!r}, but True, False or None is needed"
        raise TypeError(message)
    low, high = few("between", between, ("low", "high"))
    smallest, first_step, largest = few("step", step, ("smallest", "first", "largest"))
    measures = _checked(monitor)
    name, make = (parameter, None) if isinstance(parameter, str) else (None, parameter)
    steps = (smallest, first_step, largest)
    start = known if start is None else start
    options = {"direction": direction, "max_points": max_points, "step": steps}
    options |= {"keeps_virtual": virtual == "keep", "symmetric": symmetric, "progress": progress}
    found, raised = _core._continuation(begin, name, make, start, (low, high), options)
    marked = tuple(Special._of(own, name, (low, high), make) for own in found.pop("special"))
    branch = Branch(parameter_name=name, special=marked, monitor={}, **found)
    # Not a part of the result: functions are not saved.
    branch._set("_make", make)
    values = branch.parameter
    if raised is not None and not isinstance(raised, KeyboardInterrupt):
        raised.add_note(f"the branch is kept from {values.min():g} to {values.max():g}, as .branch of this exception")
        raised.branch = branch  # type: ignore[attr-defined]
        raise raised
    zeros: list[Special] = []
    try:
        for own, measure in measures.items():
            monitored = _core._monitored(branch, make, own, measure)
            branch.monitor[own] = monitored["values"]
            zeros += [Special._of(zero, name, (low, high), make) for zero in monitored["zeros"]]
    except (Exception, KeyboardInterrupt) as error:
        error.branch = branch  # type: ignore[union-attr]
        raise
    if zeros:
        branch._set("special", tuple(sorted((*branch.special, *zeros), key=lambda own: own.arclength)))
    return branch


def _orbit_of(given: Any) -> tuple[Any, float | None]:
    """Return the orbit of a candidate, of a special point that of its first one, and its value; an orbit as it is."""
    if isinstance(given, Special):
        found = given.branches()
        if not found:
            message = f"orbit is {shown(given)}, but no branch goes off there: an orbit is needed"
            raise ValueError(message)
        given = found[0]
    return (given.orbit, given.parameter) if isinstance(given, Candidate) else (given, None)


def _checked(monitor: Mapping[str, Monitor] | None) -> Mapping[str, Monitor]:
    """Refuse monitors that are no functions with names."""
    found = {} if monitor is None else monitor
    if not isinstance(found, Mapping) or not all(isinstance(name, str) and callable(f) for name, f in found.items()):
        message = f"monitor is {shown(monitor)}, but names with functions f(orbit) -> float are needed"
        raise TypeError(message)
    return found

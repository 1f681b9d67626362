"""Curves in two numbers on which special points of branches lie."""

from __future__ import annotations

from collections.abc import Callable

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import few, shown
from vibroimpact.results.curve import BifurcationCurve, CurvePoint, two_names
from vibroimpact.results.special import Special

__all__ = ["bifurcation_curve"]


def bifurcation_curve(
    special: Special | Orbit,
    parameters: tuple[str, str] | Callable[[float, float], Scene],
    between: tuple[tuple[float, float], tuple[float, float]],
    *,
    start: tuple[float, float] | None = None,
    direction: str = "both",
    max_points: int = 2000,
    step: tuple[float, float, float] = (1e-8, 1e-3, 0.05),
    progress: bool = False,
) -> BifurcationCurve:
    """Follow a special point of a branch over two numbers of its scene.

    Parameters
    ----------
    special : Special or Orbit
        A fold, period doubling, torus, pitchfork, graze, lost impact or corner of a branch; or an orbit that hits two stops at
        one instant, which one number alone cannot keep.
    parameters : (str, str) or callable
        Two numbers of ``Scene.replace``, or a callable ``(x, y) -> Scene``. Factors count from the scene of the special point's
        orbit, but for that of its branch, which counts as there.
    between : ((float, float), (float, float))
        The range of each, with the point in it.
    start : (float, float), optional
        Of a callable its numbers at the point.
    direction, max_points, step, progress
        As for ``continuation``; up is towards larger first numbers.

    Returns
    -------
    BifurcationCurve
        The orbits, both numbers, and why the curve ends. On Ctrl-C the curve so far, its end "interrupted".

    Raises
    ------
    ValueError
        A branch point, a chatter border or a rise, which have no equation here; an orbit that does not hit two stops at
        one instant; numbers that do not exist or are one; ranges that are upside down, not finite or without the point; steps
        that are not in order; a callable without ``start``.
    ConvergenceError
        A point that does not close in the scene of its numbers.

    Notes
    -----
    The equations of ``continuation`` with both numbers as unknowns and one more (theory 20): a determinant that is zero where
    the multiplier is 1 or -1, of half a period for a symmetric orbit; the modulus of a pair of multipliers; the speed of an
    impact, of one inserted at the touch of a graze. A curve is followed wherever its equations go; what breaks a rule of contact
    says so. A curve of tori ends where its
    two multipliers meet on the real axis. Where a point of ``special`` is not reached from one side it is located to the step.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> branch = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.1, 1.5))
    >>> doubling = branch.special[1]
    >>> curve = vi.bifurcation_curve(doubling, ("frequency", "forcing_scale"), ((2.1, 3.0), (0.1, 2.0)))
    >>> curve.kind, bool(abs(curve.y[curve.arclength == 0.0][0] - doubling.parameter) < 1e-9)
    ('period_doubling', True)
    """
    if not isinstance(special, Special | Orbit):
        message = f"special is {shown(special)}, but a Special or an Orbit is needed"
        raise TypeError(message)
    if isinstance(special, Special) and special.parameter_name == "energy":
        message = f"special is {shown(special)}, but a curve is over numbers of a scene: its orbits keep their energy in any"
        raise ValueError(message)
    make: Callable[[float, float], Scene] | None = None
    names: tuple[str, str] | None = None
    pair: tuple[float | None, float | None] = (None, None)
    if callable(parameters):
        make = parameters
        if start is None:
            message = "start is None, but with a callable it must be the pair of values at the orbit"
            raise ValueError(message)
        x0, y0 = few("start", start, ("x", "y"))
        pair = (x0, y0)
    else:
        if start is not None:
            message = f"start is {shown(start)}, but it is that of a callable: the orbit has its own numbers"
            raise ValueError(message)
        names = two_names(parameters)
        known = {} if not isinstance(special, Special) else {special.parameter_name: special.parameter}
        pair = (known.get(names[0]), known.get(names[1]))
    try:
        first, second = between
    except (TypeError, ValueError):
        message = f"between is {shown(between)}, but ((low, high), (low, high)) is needed"
        raise ValueError(message) from None
    ranges = (few("between[0]", first, ("low", "high")), few("between[1]", second, ("low", "high")))
    options = {"direction": direction, "max_points": max_points, "progress": progress}
    options["step"] = few("step", step, ("smallest", "first", "largest"))
    found = _core._bifurcation_curve(special, names, make, pair, ranges, options)
    of = special.kind if isinstance(special, Special) else "together"
    marked = tuple(CurvePoint(**own) for own in found.pop("special"))
    return BifurcationCurve(kind=of, parameter_names=names, special=marked, **found)

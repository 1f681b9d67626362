"""Curves in two numbers on which special points of branches lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._numbers import few, shown
from vibroimpact._results import ArrayResult, ItemsResult
from vibroimpact.branch import REASONS
from vibroimpact.special import KINDS, Special

__all__ = ["BifurcationCurve", "CurvePoint", "bifurcation_curve"]

#: What happens on a curve at once with what it is a curve of.
TWO_AT_ONCE = (
    *("cusp", "strong_1_1", "strong_1_2", "strong_1_3", "strong_1_4", "fold_flip"),
    *("resonant_graze", "graze_fold", "double_graze", "degenerate_graze", "graze_corner"),
    *KINDS[KINDS.index("graze") :],
)


@dataclass(frozen=True, eq=False)
class CurvePoint(ArrayResult):
    """A point of a curve at which two things happen at once.

    Attributes
    ----------
    kind : str
        "cusp": two curves of folds meet and end. "fold_flip": on a curve of folds a multiplier -1, on one of doublings a
        multiplier 1. "strong_1_1", "strong_1_2": two multipliers are 1, or -1; a curve of tori ends there. "strong_1_3",
        "strong_1_4": on a curve of tori they turn by a third of a turn, or by a quarter. "resonant_graze": on a curve of folds,
        doublings or tori an impact loses its speed; on one of grazes a curve of doublings ends. "graze_fold": on one of grazes
        a curve of folds ends. "double_graze": on one of grazes another touch. "degenerate_graze": there is no acceleration at
        a touch. "graze_corner": of two stops hit at one instant one is touched only, or another touch comes to a corner or a
        corner to a touch. Else the kind of ``Special`` of a boundary of motion, beyond which the orbits of the curve are
        virtual.
    parameter, error : (float, float)
        Both numbers, and how far each is known.
    arclength : float
        How far along the curve it is [-].
    orbit : Orbit
        The orbit there.
    """

    kind: str
    parameter: tuple[float, float]
    error: tuple[float, float]
    arclength: float
    orbit: Orbit

    def __post_init__(self) -> None:
        """Refuse what is none."""
        for name in ("parameter", "error"):
            object.__setattr__(self, name, few(name, getattr(self, name), ("x", "y")))
        self._check_types({"kind": str, "arclength": float, "orbit": Orbit})
        if self.kind not in TWO_AT_ONCE:
            message = f"kind is {self.kind!r}, but it must be one of {TWO_AT_ONCE}"
            raise ValueError(message)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its numbers as arrays, for ``numpy.savez``."""
        return {name: np.array(getattr(self, name)) for name in ("kind", "parameter", "error", "arclength")}

    def __repr__(self) -> str:
        """Say what happens, and where."""
        x, y = self.parameter
        return f"CurvePoint({self.kind} at ({x:.10g}, {y:.10g}))"


@dataclass(frozen=True, eq=False)
class BifurcationCurve(ItemsResult[Orbit]):
    """Periodic orbits at special points over two numbers of their scene: a sequence of m orbits, beside each other.

    Attributes
    ----------
    kind : str
        What lies on it: a kind of ``Special``, or "together" of an orbit that hits stops at one instant.
    parameter_names : tuple of str or None
        Both numbers, None of a curve made by a callable.
    orbits : tuple of Orbit
        The orbits; of a graze those that touch.
    x, y : ndarray, shape (m,)
        The numbers at each [its own unit].
    arclength : ndarray, shape (m,)
        How far along the curve [-] each is from the point that was given, in scaled unknowns.
    is_virtual : ndarray of bool, shape (m,)
        Whether each breaks a rule of contact.
    special : tuple of CurvePoint
        Where two things happen at once.
    ends : tuple of (str, str), length 2
        Why it ends before its first point and after its last, as ``Branch.ends``.
    """

    kind: str
    parameter_names: tuple[str, str] | None
    orbits: tuple[Orbit, ...]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    arclength: NDArray[np.float64]
    is_virtual: NDArray[np.bool_]
    special: tuple[CurvePoint, ...]
    ends: tuple[tuple[str, str], tuple[str, str]]

    def __post_init__(self) -> None:
        """Refuse what is none of one curve; lists become tuples."""
        for name in ("orbits", "special"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if self.parameter_names is not None:
            object.__setattr__(self, "parameter_names", _two(self.parameter_names))
        object.__setattr__(self, "ends", tuple((str(reason), str(detail)) for reason, detail in self.ends))
        self._check_types({"kind": str})
        if self.kind not in (*KINDS, "together"):
            message = f'kind is {self.kind!r}, but it must be a kind of Special or "together"'
            raise ValueError(message)
        if not self.orbits or not all(isinstance(orbit, Orbit) for orbit in self.orbits):
            message = f"orbits is {shown(self.orbits)}, but a sequence of Orbit, one at least, is needed"
            raise TypeError(message)
        if not all(isinstance(own, CurvePoint) for own in self.special):
            message = f"special is {shown(self.special)}, but a sequence of CurvePoint is needed"
            raise TypeError(message)
        if len(self.ends) != 2 or any(reason not in REASONS for reason, _ in self.ends):
            message = f"ends is {shown(self.ends)}, but two pairs of a reason and its detail are needed"
            raise ValueError(message)
        m = (len(self.orbits),)
        self._check({"x": ("f", m), "y": ("f", m), "arclength": ("f", m), "is_virtual": ("b", m)})

    def _items(self) -> tuple[Orbit, ...]:
        return self.orbits

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the curve, for ``numpy.savez``."""
        return {name: getattr(self, name) for name in ("x", "y", "arclength", "is_virtual")}

    def __repr__(self) -> str:
        """Say where the curve goes and what ends it."""
        names = "callable" if self.parameter_names is None else ", ".join(self.parameter_names)
        ranges = f"{self.x.min():.6g} to {self.x.max():.6g}, {self.y.min():.6g} to {self.y.max():.6g}"
        lines = [f"BifurcationCurve({self.kind} over {names}: {ranges}, {len(self)} orbits)"]
        lines += [f"  {own}" for own in self.special]
        lines += [f"  {reason}: {detail}" for reason, detail in self.ends]
        return "\n".join(lines)


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
    orbit, point = _begun(special)
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
        names = _two(parameters)
        known = {} if not isinstance(special, Special) else {special.parameter_name: special.parameter}
        pair = (known.get(names[0]), known.get(names[1]))
    try:
        first, second = between
    except (TypeError, ValueError):
        message = f"between is {shown(between)}, but ((low, high), (low, high)) is needed"
        raise ValueError(message) from None
    ranges = (few("between[0]", first, ("low", "high")), few("between[1]", second, ("low", "high")))
    steps = few("step", step, ("smallest", "first", "largest"))
    found = _core._bifurcation_curve(point, orbit, names, make, pair, ranges, direction, max_points, steps, progress)
    orbits, xs, ys, arclength, is_virtual, points, (low, high) = found
    of = special.kind if isinstance(special, Special) else "together"
    marked = tuple(CurvePoint(kind, (x, y), (dx, dy), at, orbit) for kind, (x, y), (dx, dy), at, orbit in points)
    return BifurcationCurve(of, names, tuple(orbits), xs, ys, arclength, is_virtual, marked, (low, high))


def _begun(special: Any) -> tuple[Orbit, tuple[Any, ...] | None]:
    """Return the orbit of a special point and what the core takes of it; an orbit as it is."""
    if isinstance(special, Orbit):
        return special, None
    if not isinstance(special, Special):
        message = f"special is {shown(special)}, but a Special or an Orbit is needed"
        raise TypeError(message)
    if special.parameter_name == "energy":
        message = f"special is {shown(special)}, but a curve is over numbers of a scene: its orbits keep their energy in any"
        raise ValueError(message)
    return special.orbit, special._given()


def _two(parameters: Any) -> tuple[str, str]:
    """Return two names."""
    given = tuple(parameters) if isinstance(parameters, (tuple, list)) else ()
    if len(given) != 2 or not all(isinstance(own, str) for own in given):
        message = f"parameters is {shown(parameters)}, but two numbers of Scene.replace or a callable (x, y) -> Scene are needed"
        raise TypeError(message)
    if given[0] == given[1]:
        message = f"parameters is {shown(parameters)}, but they must be two"
        raise ValueError(message)
    return given[0], given[1]

"""Branches: periodic orbits followed over a number of their scene."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core, _html
from vibroimpact._core import Orbit, Scene
from vibroimpact._numbers import few, finite, shown
from vibroimpact._results import ItemsResult
from vibroimpact.diagram import Pattern
from vibroimpact.errors import ConvergenceError
from vibroimpact.special import Candidate, Special

__all__ = ["Branch", "continuation"]

#: Why a branch ends.
REASONS = ("range", "closed", "points", "step", "boundary", "doubling", "domain", "interrupted", "start")

#: Points of a way from a point of a branch to a value beside it: of one that begins at a boundary there may be many.
_MOST_STEPS = (100, 10_000)

Monitor = Callable[[Orbit], float]


class _Node(NamedTuple):
    """A point of a branch, or a fold between two of them."""

    arclength: float
    parameter: float
    orbit: Orbit
    turns: bool  # from it the number goes the same way on both sides


@dataclass(frozen=True, eq=False)
class Branch(ItemsResult[Orbit]):
    """Periodic orbits of one pattern over a number of their scene: a sequence of m orbits, each beside those that it comes from.

    Attributes
    ----------
    parameter_name : str or None
        The number, None of a branch made by a callable.
    orbits : tuple of Orbit
        The orbits, in the order in which they follow each other.
    parameter : ndarray, shape (m,)
        The number at each [its own unit].
    arclength : ndarray, shape (m,)
        How far along the branch [-] each is from the orbit that was given, in scaled unknowns; negative on the way down.
    is_admissible, is_stable : ndarray of bool, shape (m,)
        Whether each was proved to keep the rules of contact; whether small deviations from it die out. False where undecided.
    n_unstable : ndarray of int, shape (m,)
        How many multipliers lie outside the unit circle; -1 where the return map has no derivative.
    multipliers : ndarray of complex, shape (m, 2n)
        The multipliers of each [-], the largest first; nan where it has none.
    special : tuple of Special
        Its bifurcations and the boundaries at its ends, in their order.
    monitor : dict of str to ndarray, shape (m,)
        What functions that were asked for give.
    ends : tuple of (str, str), length 2
        Why it ends before its first point and after its last, and the same in words. The reason is "range", "closed", "points",
        "step" (Newton's method came no further), "boundary" (beyond it a rule of contact is broken), "doubling" (its two rounds
        are one there, from which it is doubled: it would come back over itself), "domain" (there is no scene beyond),
        "interrupted", or "start" (the orbit that was given, where the branch was followed one way).
    is_closed : bool
        Whether its last point is its first one again.
    """

    parameter_name: str | None
    orbits: tuple[Orbit, ...]
    parameter: NDArray[np.float64]
    arclength: NDArray[np.float64]
    is_admissible: NDArray[np.bool_]
    is_stable: NDArray[np.bool_]
    n_unstable: NDArray[np.int64]
    multipliers: NDArray[np.complex128]
    special: tuple[Special, ...]
    monitor: dict[str, NDArray[np.float64]]
    ends: tuple[tuple[str, str], tuple[str, str]]
    is_closed: bool

    def __post_init__(self) -> None:
        """Refuse what is none of one branch; lists become tuples."""
        object.__setattr__(self, "orbits", tuple(self.orbits))
        object.__setattr__(self, "special", tuple(self.special))
        object.__setattr__(self, "ends", tuple((str(reason), str(detail)) for reason, detail in self.ends))
        self._check_types({"parameter_name": (str, type(None)), "monitor": dict, "is_closed": bool})
        if not self.orbits or not all(isinstance(orbit, Orbit) for orbit in self.orbits):
            message = f"orbits is {shown(self.orbits)}, but a sequence of Orbit, one at least, is needed"
            raise TypeError(message)
        if not all(isinstance(own, Special) for own in self.special):
            message = f"special is {shown(self.special)}, but a sequence of Special is needed"
            raise TypeError(message)
        if len(self.ends) != 2 or any(reason not in REASONS for reason, _ in self.ends):
            message = f"ends is {shown(self.ends)}, but two pairs of a reason and its detail are needed"
            raise ValueError(message)
        m = (len(self.orbits),)
        columns = {"parameter": "f", "arclength": "f", "is_admissible": "b", "is_stable": "b", "n_unstable": "i"}
        self._check({name: (kind, m) for name, kind in columns.items()})
        self._check({"multipliers": ("c", (*m, 2 * self.scene.n_dof))})
        for name, values in self.monitor.items():
            if np.shape(values) != m:
                message = f"monitor[{name!r}] has shape {np.shape(values)}, but {m} is needed"
                raise ValueError(message)

    @property
    def scene(self) -> Scene:
        """The scene of the first orbit."""
        return self.orbits[0].scene

    @property
    def pattern(self) -> Pattern:
        """The stops hit in one period, a tuple at one instant."""
        return self.orbits[0].pattern

    @property
    def n_periods(self) -> int:
        """Periods of the forcing in one period of the orbits."""
        return self.orbits[0].n_periods

    @property
    def is_virtual(self) -> NDArray[np.bool_]:
        """Whether each orbit breaks a rule of contact, shape (m,)."""
        return np.array([orbit.is_admissible is False for orbit in self.orbits])

    @property
    def speeds_before(self) -> NDArray[np.float64]:
        """The speeds at which stops are approached [m/s], shape (m, k); nan where an orbit has fewer impacts than others."""
        return self._of_impacts("speed_before")

    @property
    def phases(self) -> NDArray[np.float64]:
        """The phases of the forcing at the impacts [rad], in [0, 2 pi), shape (m, k); as ``speeds_before``."""
        return self._of_impacts("phase")

    def _of_impacts(self, column: str) -> NDArray[np.float64]:
        each = [orbit.impacts[column] for orbit in self.orbits]
        rows = np.full((len(each), max(map(len, each))), np.nan)
        for row, own in zip(rows, each, strict=True):
            row[: len(own)] = own
        return rows

    def _items(self) -> tuple[Orbit, ...]:
        return self.orbits

    def at(self, value: float) -> list[Orbit]:
        """Return every orbit that the branch has at a value of its number, one for each of its points or passages.

        Parameters
        ----------
        value : float
            The value.

        Returns
        -------
        list of Orbit
            In the order of the branch: each is followed to the value from the point beside it.

        Raises
        ------
        ValueError
            A value that is not finite; a branch made by a callable that was saved, at a value between its points.
        ConvergenceError
            A value to which the branch is not followed from the points beside it.
        """
        value = finite("value", value)
        nodes = self._nodes()
        found = [nodes[0].orbit] if nodes[0].parameter == value else []
        for here, there in itertools.pairwise(nodes):
            if there.parameter == value:
                found.append(there.orbit)
            elif min(here.parameter, there.parameter) < value < max(here.parameter, there.parameter):
                found.append(self._between((here, there), value))
        return found

    def _nodes(self) -> list[_Node]:
        """Return the points, and the folds between them: from one of these to the next the number goes one way."""
        ends = {k for k, (reason, _) in zip((0, len(self) - 1), self.ends, strict=True) if reason == "doubling"}
        points = enumerate(zip(self.arclength, self.parameter, self.orbits, strict=True))
        nodes = [_Node(float(along), float(value), orbit, k in ends) for k, (along, value, orbit) in points]
        folds = [own for own in self.special if own.kind == "fold"]
        nodes += [_Node(own.arclength, own.parameter, own.orbit, True) for own in folds]
        return sorted(nodes, key=lambda node: node.arclength)

    def _between(self, ends: tuple[_Node, _Node], value: float) -> Orbit:
        """Return the orbit at a value between two nodes, from one of them, that is no fold if there is one."""
        make = getattr(self, "_make", None)
        if self.parameter_name is None and make is None:
            message = f"value is {value}, but it must be that of a point: the callable that made the branch was not saved with it"
            raise ValueError(message)
        is_factor = self.parameter_name in ("forcing_scale", "damping_scale")

        def order(node: _Node) -> tuple[bool, float]:
            # Of factors none counts from zero.
            return is_factor and node.parameter == 0.0, abs(node.parameter - value)

        # From the nearer one in few steps; where that is a boundary many may be needed, and the other may be better.
        nodes = sorted([node for node in ends if not node.turns] or ends, key=order)
        reached: list[tuple[float, str]] = []
        for most, node in itertools.product(_MOST_STEPS, nodes):
            start, up = node.parameter, value > node.parameter
            way = ("up" if up else "down", most, (1e-12, 0.1, 0.5), True, None, False)
            part = _core._continuation(node.orbit, self.parameter_name, make, start, (min(start, value), max(start, value)), *way)
            last = -1 if up else 0
            if part[10] is not None:
                raise part[10]
            if part[1][last] == value:
                return part[0][last]
            reached.append((float(part[1][last]), part[8][last][1]))
        far, why = min(reached, key=lambda own: abs(own[0] - value))
        beside = " and ".join(f"{end.parameter:.10g}" for end in ends)
        message = f"the branch was not followed to {value:.10g} between its points at {beside}"
        raise ConvergenceError(f"{message}: it came to {far:.10g} ({why})")

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the branch, for ``numpy.savez``; monitors by their names."""
        names = ("parameter", "arclength", "is_admissible", "is_stable", "is_virtual", "n_unstable", "multipliers")
        arrays = {name: getattr(self, name) for name in (*names, "speeds_before", "phases")}
        return arrays | {f"monitor_{name}": values for name, values in self.monitor.items()}

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        return _html.branch(self)

    def __repr__(self) -> str:
        """Say where the branch goes and what ends it."""
        low, high = self.parameter.min(), self.parameter.max()
        stable = f"{np.count_nonzero(self.is_stable)} stable, {np.count_nonzero(self.is_virtual)} virtual"
        lines = [f"Branch({self.parameter_name or 'callable'} from {low:.6g} to {high:.6g}, {len(self)} orbits: {stable})"]
        lines += [f"  {own}" for own in self.special]
        lines += [f"  {reason}: {detail}" for reason, detail in self.ends]
        return "\n".join(lines)


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
    keeps = virtual == "keep"
    steps = (smallest, first_step, largest)
    start = known if start is None else start
    way = (direction, max_points, steps, keeps, symmetric, progress)
    found = _core._continuation(begin, name, make, start, (low, high), *way)
    orbits, values, arclength, is_admissible, is_stable, n_unstable, multipliers = found[:7]
    special, (first, last), is_closed, raised = found[7:]
    columns = (values, arclength, is_admissible, is_stable, n_unstable, multipliers)
    marked = tuple(Special._of(own, name, (low, high), make) for own in special)
    branch = Branch(name, tuple(orbits), *columns, marked, {}, (first, last), is_closed)
    # Not a part of the result: functions are not saved.
    object.__setattr__(branch, "_make", make)
    if raised is not None and not isinstance(raised, KeyboardInterrupt):
        raised.add_note(f"the branch is kept from {values.min():g} to {values.max():g}, as .branch of this exception")
        raised.branch = branch  # type: ignore[attr-defined]
        raise raised
    try:
        branch.monitor.update({own: _measured(own, measure, branch.orbits) for own, measure in measures.items()})
        zeros = [zero for own, measure in measures.items() for zero in _zeros(branch, (low, high), own, measure)]
    except (Exception, KeyboardInterrupt) as error:
        error.branch = branch  # type: ignore[union-attr]
        raise
    if zeros:
        object.__setattr__(branch, "special", tuple(sorted((*branch.special, *zeros), key=lambda own: own.arclength)))
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


def _measured(name: str, measure: Monitor, orbits: Sequence[Orbit]) -> NDArray[np.float64]:
    """Return what a function gives of each orbit."""
    given = [measure(orbit) for orbit in orbits]
    values = np.empty(len(given))
    for k, value in enumerate(given):
        values[k] = finite(f"monitor[{name!r}] at point {k}", value)
    return values


#: A change of sign is a zero where a function comes to so small a part of its values on both sides.
_ZERO = 1e-6


def _zeros(branch: Branch, between: tuple[float, float], name: str, measure: Monitor) -> Iterator[Special]:
    """Give the points between others at which a function is zero, by the false position in the branch's number."""
    span = np.ptp(branch.parameter)
    known = dict(zip(branch.arclength.tolist(), branch.monitor[name].tolist(), strict=True))
    nodes = [(node, known[node.arclength] if node.arclength in known else measure(node.orbit)) for node in branch._nodes()]
    for (here, f), (there, g) in itertools.pairwise(nodes):
        if not f * g < 0.0:
            continue
        x, y = here.parameter, there.parameter
        size, at, value, orbit = max(abs(f), abs(g)), x, f, here.orbit
        while x != y:
            before, at = at, x - f * (y - x) / (g - f)
            if not min(x, y) < at < max(x, y):
                break
            orbit = branch._between((here, there), at)
            value = measure(orbit)
            # The side that stays is halved, so that both come nearer (Illinois).
            (x, f, y, g) = (at, value, y, 0.5 * g) if value * f > 0.0 else (x, 0.5 * f, at, value)
            if value == 0.0 or abs(at - before) <= 1e-13 * span:
                break
        if abs(value) > _ZERO * size:
            continue
        part = (at - here.parameter) / (there.parameter - here.parameter)
        arclength = float(here.arclength + part * (there.arclength - here.arclength))
        error = max(abs(at - before), np.finfo(float).eps * span)
        point: tuple[Any, ...] = (f"user:{name}", float(at), float(error), arclength, orbit, None, None, None, [])
        yield Special._of(point, branch.parameter_name, between, getattr(branch, "_make", None))

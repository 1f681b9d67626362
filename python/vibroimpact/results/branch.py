"""Branches: periodic orbits over a number of their scene."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import finite, shown
from vibroimpact.errors import ConvergenceError
from vibroimpact.results import html, labelled
from vibroimpact.results.diagram import Pattern
from vibroimpact.results.record import ItemsRecord, array, items
from vibroimpact.results.special import Special

#: Why a branch ends.
REASONS = ("range", "closed", "points", "step", "boundary", "doubling", "domain", "interrupted", "start")

#: Points of a way from a point of a branch to a value beside it: of one that begins at a boundary there may be many.
_MOST_STEPS = (100, 10_000)


class _Node(NamedTuple):
    """A point of a branch, or a fold between two of them."""

    arclength: float
    parameter: float
    orbit: Orbit
    turns: bool  # from it the number goes the same way on both sides


class Followed(NamedTuple):
    """What the core returns of a branch that it followed."""

    orbits: list[Orbit]
    parameter: NDArray[np.float64]
    arclength: NDArray[np.float64]
    is_admissible: NDArray[np.bool_]
    is_stable: NDArray[np.bool_]
    n_unstable: NDArray[np.int64]
    multipliers: NDArray[np.complex128]
    special: list[tuple[Any, ...]]
    ends: list[tuple[str, str]]
    is_closed: bool
    raised: BaseException | None


def check_ends(ends: Sequence[tuple[str, str]]) -> None:
    """Refuse what is none of the two ends of a branch or of a curve."""
    if len(ends) != 2 or any(reason not in REASONS for reason, _ in ends):
        message = f"ends is {shown(ends)}, but two pairs of a reason and its detail are needed"
        raise ValueError(message)


class Branch(ItemsRecord[Orbit]):
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
    orbits: tuple[Orbit, ...] = items("orbit", least=1)
    parameter: NDArray[np.float64] = array("orbit", coordinate="parameter")
    arclength: NDArray[np.float64] = array("orbit")
    is_admissible: NDArray[np.bool_] = array("orbit")
    is_stable: NDArray[np.bool_] = array("orbit")
    n_unstable: NDArray[np.int64] = array("orbit")
    multipliers: NDArray[np.complex128] = array("orbit multiplier")
    special: tuple[Special, ...]
    monitor: dict[str, NDArray[np.float64]]
    ends: tuple[tuple[str, str], tuple[str, str]]
    is_closed: bool

    def _prepare(self) -> None:
        self._set("ends", tuple((str(reason), str(detail)) for reason, detail in self.ends))

    def _sizes(self) -> dict[str, int]:
        return {"orbit": len(self.orbits), "multiplier": 2 * self.scene.n_dof}

    def _check_more(self) -> None:
        check_ends(self.ends)
        m = (len(self.orbits),)
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
            between = (min(start, value), max(start, value))
            part = Followed(*_core._continuation(node.orbit, self.parameter_name, make, start, between, *way))
            last = -1 if up else 0
            if part.raised is not None:
                raise part.raised
            if part.parameter[last] == value:
                return part.orbits[last]
            reached.append((float(part.parameter[last]), part.ends[last][1]))
        far, why = min(reached, key=lambda own: abs(own[0] - value))
        beside = " and ".join(f"{end.parameter:.10g}" for end in ends)
        message = f"the branch was not followed to {value:.10g} between its points at {beside}"
        raise ConvergenceError(f"{message}: it came to {far:.10g} ({why})")

    def _derived(self) -> dict[str, tuple[tuple[str, ...], NDArray[Any]]]:
        """Return the arrays beside the fields, with their dimensions: verdicts, impacts and monitors."""
        found: dict[str, tuple[tuple[str, ...], NDArray[Any]]] = {"is_virtual": (("orbit",), self.is_virtual)}
        found |= {name: (("orbit", "impact"), getattr(self, name)) for name in ("speeds_before", "phases")}
        return found | {f"monitor_{name}": (("orbit",), values) for name, values in self.monitor.items()}

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the branch, for ``numpy.savez``; monitors by their names."""
        return super().to_arrays() | {name: values for name, (_, values) in self._derived().items()}

    def _labelled(self) -> labelled.Parts:
        variables, coordinates, attributes = super()._labelled()
        attributes |= {"name": attributes.pop("parameter_name")} if self.parameter_name is not None else {}
        attributes |= {f"end_{k}": f"{reason}: {detail}" for k, (reason, detail) in enumerate(self.ends)}
        return variables | self._derived(), coordinates, attributes | {"pattern": str(self.pattern), "n_periods": self.n_periods}

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        name = escape(self.parameter_name or "parameter")
        count = f"{int(self.is_stable.sum())} stable, {int(self.is_virtual.sum())} virtual"
        rows = [
            (name, f"{html.number(self.parameter.min())} to {html.number(self.parameter.max())}"),
            ("orbits", f"{len(self)}: {count}"),
            *(("end", escape(f"{reason}: {detail}")) for reason, detail in self.ends),
        ]
        special = html.cut(self.special, lambda one: (escape(one.kind), f"{one.parameter:.10g}", f"{one.error:.1g}"))
        parts = [html.table(special, ("special point", name, "error"))] if self.special else []
        return html.page("Branch of periodic orbits", html.table(rows), *parts)

    def __repr__(self) -> str:
        """Say where the branch goes and what ends it."""
        low, high = self.parameter.min(), self.parameter.max()
        stable = f"{np.count_nonzero(self.is_stable)} stable, {np.count_nonzero(self.is_virtual)} virtual"
        lines = [f"Branch({self.parameter_name or 'callable'} from {low:.6g} to {high:.6g}, {len(self)} orbits: {stable})"]
        lines += [f"  {own}" for own in self.special]
        lines += [f"  {reason}: {detail}" for reason, detail in self.ends]
        return "\n".join(lines)

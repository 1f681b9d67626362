"""Branches: periodic orbits over a number of their scene."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import finite, shown
from vibroimpact.results import html, labelled
from vibroimpact.results.diagram import Pattern
from vibroimpact.results.record import ItemsRecord, array, items
from vibroimpact.results.special import Special

#: Why a branch ends.
REASONS: tuple[str, ...] = _core._END_REASONS


def check_ends(ends: Sequence[tuple[str, str]]) -> None:
    """Refuse what is none of the two ends of a branch or of a curve."""
    if len(ends) != 2 or any(reason not in REASONS for reason, _ in ends):
        message = f"ends is {shown(ends)}, but two pairs of a reason and its detail are needed"
        raise ValueError(message)


def _rows(each: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return lists of numbers as rows of one array, nan where one has fewer than others."""
    rows = np.full((len(each), max(map(len, each))), np.nan)
    for row, own in zip(rows, each, strict=True):
        row[: len(own)] = own
    return rows


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
        # Of stops that relax as a period begins there are more than two for each degree of freedom.
        known = self.multipliers.shape[-1] if np.ndim(self.multipliers) == 2 else 0
        return {"orbit": len(self.orbits), "multiplier": max(2 * self.scene.n_dof, known)}

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

    @property
    def durations(self) -> NDArray[np.float64]:
        """The durations of the contacts of each orbit [s], shape (m, k), zero of an impact; nan where it has fewer."""
        return _rows([orbit.contacts["end"] - orbit.contacts["start"] for orbit in self.orbits])

    def _of_impacts(self, column: str) -> NDArray[np.float64]:
        return _rows([orbit.impacts[column] for orbit in self.orbits])

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
        make = getattr(self, "_make", None)
        if self.parameter_name is None and make is None:
            found = [orbit for orbit, own in zip(self.orbits, self.parameter, strict=True) if own == value]
            if not found:
                message = (
                    f"value is {value}, but it must be that of a point: the callable that made the branch was not saved with it"
                )
                raise ValueError(message)
            return found
        return _core._orbits_at(self, make, value)

    def _derived(self) -> dict[str, tuple[tuple[str, ...], NDArray[Any]]]:
        """Return the arrays beside the fields, with their dimensions: verdicts, impacts and monitors."""
        found: dict[str, tuple[tuple[str, ...], NDArray[Any]]] = {"is_virtual": (("orbit",), self.is_virtual)}
        found |= {name: (("orbit", "impact"), getattr(self, name)) for name in ("speeds_before", "phases")}
        if any(stop.restitution is None for stop in self.scene.stops):
            found["durations"] = ("orbit", "contact"), self.durations
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

"""Derivatives of periodic orbits by numbers of their scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact._numbers import shown
from vibroimpact._results import ArrayResult

__all__ = ["Derivatives"]


@dataclass(frozen=True, eq=False)
class Derivatives(ArrayResult):
    """Derivatives of an orbit of n degrees of freedom, with k impacts in a period, by d numbers of its scene.

    Each is that of what the orbit, or a column of its impacts, has under the same or the given name; t = 0 is right after the
    first impact, wherever in time that is. Units are for one of the number. What does not exist is nan, with the reason.

    Attributes
    ----------
    parameters : tuple of str, length d, or None
        The numbers; None of a callable.
    q0, v0 : ndarray, shape (n, d)
        Of the position [m] and the velocity [m/s] right after the first impact.
    phase : ndarray, shape (d,)
        Of the phase of the forcing there [rad]; zero without forcing.
    period : ndarray, shape (d,)
        Of the period [s].
    speeds_before, times : ndarray, shape (k, d)
        Of ``impacts["speed_before"]`` [m/s] and ``impacts["time"]`` [s].
    multipliers : ndarray of complex, shape (2n, d)
        Of ``floquet_multipliers`` [-], in their order; nan of those that meet, and where the orbit has none.
    min_gap : ndarray, shape (stops, d)
        Of the least gap of every stop [m]: zero where it is that of an impact.
    max_displacement : ndarray, shape (n, d)
        Of the largest distance of every coordinate from zero [m].
    reason : str
        Why some do not exist, empty where all do: a fold (they are infinite), a graze, stops hit together, a contact without
        duration (they exist on one side alone), a family of orbits; multipliers that meet; an extreme that is reached at several
        times.
    """

    parameters: tuple[str, ...] | None
    q0: NDArray[np.float64]
    v0: NDArray[np.float64]
    phase: NDArray[np.float64]
    period: NDArray[np.float64]
    speeds_before: NDArray[np.float64]
    times: NDArray[np.float64]
    multipliers: NDArray[np.complex128]
    min_gap: NDArray[np.float64]
    max_displacement: NDArray[np.float64]
    reason: str

    def __post_init__(self) -> None:
        """Refuse what is none of one orbit; a list of names becomes a tuple."""
        if self.parameters is not None:
            object.__setattr__(self, "parameters", tuple(str(name) for name in self.parameters))
        self._check_types({"reason": str})
        d = np.size(self.phase)
        n, k, stops = (len(np.atleast_1d(own)) for own in (self.q0, self.times, self.min_gap))
        if self.parameters is not None and len(self.parameters) != d:
            message = f"parameters is {shown(self.parameters)}, but {d} names are needed"
            raise ValueError(message)
        rows = {"q0": n, "v0": n, "max_displacement": n, "speeds_before": k, "times": k, "min_gap": stops}
        self._check({name: ("f", (count, d)) for name, count in rows.items()})
        self._check({"phase": ("f", (d,)), "period": ("f", (d,)), "multipliers": ("c", (2 * n, d))})

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the derivatives, for ``numpy.savez``."""
        names = ("q0", "v0", "phase", "period", "speeds_before", "times", "multipliers", "min_gap", "max_displacement")
        return {name: getattr(self, name) for name in names}

    def __repr__(self) -> str:
        """Say by what, and what is missing."""
        n, d = self.q0.shape
        by = f"{d} numbers" if self.parameters is None else ", ".join(self.parameters) or "nothing"
        text = f"Derivatives(of an orbit of {n} coordinates and {len(self.times)} impacts, by {by})"
        return f"{text}\n  {self.reason}" if self.reason else text

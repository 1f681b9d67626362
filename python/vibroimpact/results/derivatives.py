"""Derivatives of periodic orbits by numbers of their scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array, items


class Derivatives(Record):
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

    parameters: tuple[str, ...] | None = items("number", coordinate="number")
    q0: NDArray[np.float64] = array("dof number")
    v0: NDArray[np.float64] = array("dof number")
    phase: NDArray[np.float64] = array("number")
    period: NDArray[np.float64] = array("number")
    speeds_before: NDArray[np.float64] = array("impact number")
    times: NDArray[np.float64] = array("impact number")
    multipliers: NDArray[np.complex128] = array("multiplier number")
    min_gap: NDArray[np.float64] = array("stop number")
    max_displacement: NDArray[np.float64] = array("dof number")
    reason: str

    def _sizes(self) -> dict[str, int]:
        return {"multiplier": 2 * len(np.atleast_1d(self.q0)), "number": np.size(self.phase)}

    def __repr__(self) -> str:
        """Say by what, and what is missing."""
        n, d = self.q0.shape
        by = f"{d} numbers" if self.parameters is None else ", ".join(self.parameters) or "nothing"
        text = f"Derivatives(of an orbit of {n} coordinates and {len(self.times)} impacts, by {by})"
        return f"{text}\n  {self.reason}" if self.reason else text

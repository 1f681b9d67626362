"""Many trajectories at once, one row each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array


class Ensemble(Record):
    """Many trajectories, one row each: their ends, or their motions at given times, and their impacts.

    Attributes
    ----------
    q, v : ndarray, shape (k, n), or (k, m, n)
        Final positions [m] and velocities [m/s], or those at ``t_eval``, nan after an early end.
    n_impacts : ndarray of int, shape (k,)
        Impacts of each trajectory.
    status : ndarray of str, shape (k,)
        How each ended.
    impacts : ndarray or None
        With ``keep="impacts"`` those of all, run after run: structured array of run, time, stop, speed_before, speed_after,
        impulse, phase.
    contacts : ndarray or None
        With ``keep="impacts"`` those of all, run after run: structured array of run, then as ``Trajectory.contacts``.
    """

    q: NDArray[np.float64] = array("run dof", "run time dof", unit="m")
    v: NDArray[np.float64] = array("run dof", "run time dof", unit="m/s")
    n_impacts: NDArray[np.int64] = array("run")
    status: NDArray[np.str_] = array("run")
    impacts: NDArray[np.void] | None = array("impact", default=None)
    contacts: NDArray[np.void] | None = array("contact", default=None)

    def __repr__(self) -> str:
        """Say how many trajectories there are and how they ended."""
        kinds, counts = np.unique(self.status, return_counts=True)
        ends = ", ".join(f"{count} {kind}" for kind, count in zip(kinds, counts, strict=True))
        return f"Ensemble({len(self.status)} trajectories: {ends}; {self.n_impacts.sum()} impacts)"

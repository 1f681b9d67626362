"""numbalsoda: the compiled loop of one trajectory, called for all of them in compiled code."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numba as nb
import numpy as np

from ...problems import Ensemble
from .. import Tolerances
from ..numbalsoda import loops
from . import Ends


def methods(_: Ensemble) -> list[str]:
    """Both integrators."""
    return ["dop853", "lsoda"]


@lru_cache(maxsize=4)
def over_all(problem: Ensemble, method: str):
    """The loop over the trajectories."""
    one = loops(problem)[0][method]

    @nb.njit
    def all_of_them(starts, end, rtol, atol):
        states, counts = np.empty_like(starts), np.empty(len(starts), np.int64)
        for i in range(len(starts)):
            states[i], times = one(starts[i], end, rtol, atol)
            counts[i] = len(times)
        return states, counts

    return all_of_them


def prepare(problem: Ensemble, method: str, tolerances: Tolerances) -> Callable[[], Ends]:
    """One compiled call."""
    loop, rows = over_all(problem, method), np.arange(len(problem.starts))
    starts, end, rtol, atol = problem.starts, problem.end, tolerances.relative, tolerances.absolute
    loop(starts[:1], 1e-6, rtol, atol)

    def run() -> Ends:
        return Ends(rows, *loop(starts, end, rtol, atol))

    return run

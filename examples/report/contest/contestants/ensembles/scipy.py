"""SciPy, one trajectory after another, and only a few: a quarter of those that have a reference."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...problems import Ensemble
from .. import Tolerances, scipy
from . import Ends


def methods(_: Ensemble) -> list[str]:
    """The explicit pairs."""
    return ["RK45", "DOP853"]


def prepare(problem: Ensemble, method: str, tolerances: Tolerances) -> Callable[[], Ends]:
    """A loop over the trajectories."""
    rows = problem.sample[::4]
    runs = [scipy.prepare(problem.member(i), method, tolerances) for i in rows]

    def run() -> Ends:
        found = [each() for each in runs]
        return Ends(rows, np.array([each.state for each in found]), np.array([len(each.times) for each in found]))

    return run

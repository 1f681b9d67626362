"""`simulate_many` on one thread."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import vibroimpact as vi

from ...problems import Ensemble
from .. import Tolerances
from . import Ends


def methods(problem: Ensemble) -> list[str]:
    """What `simulate_many` takes for the scene."""
    return ["exact" if isinstance(problem.scene.system, vi.LinearSystem) else "taylor"]


def prepare(problem: Ensemble, _: str, tolerances: Tolerances) -> Callable[[], Ends]:
    """One call for all."""
    q0, v0 = np.hsplit(problem.starts, 2)
    rows = np.arange(len(q0))
    options = {"rtol": tolerances.relative, "atol": tolerances.absolute, "workers": 1}

    def run() -> Ends:
        found = vi.simulate_many(problem.scene, q0, v0, (0.0, problem.end), **options)
        if np.any(found.status != "finished"):
            raise RuntimeError(f"{np.count_nonzero(found.status != 'finished')} trajectories not finished")
        return Ends(rows, np.hstack([found.q, found.v]), found.n_impacts)

    return run

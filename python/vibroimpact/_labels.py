"""Labels of states: to which attractor each leads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core, _workers
from vibroimpact._core import Scene
from vibroimpact.attractors import Attractor, Attractors, check_all

#: Labels of states that lead to no attractor.
UNDECIDED, LOST, INSIDE = 0, -1, -2

#: Cells of a piece of work: chunks of a store are as large.
_PIECE = 10_000


def _label(piece: tuple[Any, ...], ask: _workers.Ask) -> tuple[Any, Any]:
    arguments: tuple[Any, ...] = (*piece, 1, False, ask)
    return _core._basin_cells(*arguments)


def labels_of(
    scene: Scene,
    attractors: Sequence[Attractor],
    box: NDArray[np.float64],
    starts: tuple[NDArray[np.float64], NDArray[np.float64]],
    options: tuple[Any, ...],
    workers: _workers.Workers,
    progress: bool,
) -> tuple[NDArray[np.int16], NDArray[np.int32]]:
    """Return the label of each state, and the periods until it was decided."""
    seen = [(one.kind, one.orbit, one.n_periods, one.points) for one in attractors]
    states, phases = starts
    if not _workers.is_elsewhere(workers):
        whole: tuple[Any, ...] = (scene, seen, box, states, phases, *options, _workers.threads(workers), progress, None)
        return _core._basin_cells(*whole)
    bounds = _workers.bounds(len(states), max(-(-len(states) // _PIECE), 1))
    pieces = [(scene, seen, box, states[i:j], phases[i:j], *options) for i, j in bounds]
    parts = _workers.run(_label, pieces, workers, progress=progress)
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def check_attractors(scene: Scene, attractors: Sequence[Attractor], phase: float) -> None:
    """Refuse attractors of another scene, or at another phase."""
    if isinstance(attractors, Attractors):
        if attractors.scene != scene:
            message = "attractors are those of another scene"
            raise ValueError(message)
        if attractors.phase != phase:
            message = f"attractors have their points at phase {attractors.phase}, but phase is {phase}"
            raise ValueError(message)
    check_all(attractors)

"""Labels of states: to which attractor each leads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Scene
from vibroimpact._validation import shown
from vibroimpact.analysis.find_attractors import turns
from vibroimpact.results.attractors import Attractor, Attractors, check_all
from vibroimpact.run import pool

#: States, one a row, and their phases.
Starts = tuple[NDArray[np.float64], NDArray[np.float64]]


def labelled(shared: tuple[Any, ...], starts: Starts, own: pool.Own) -> dict[str, NDArray[Any]]:
    """Return the labels of states, and the iterations: the periods until each was decided.

    Shared are a scene, attractors, a box, its angles, and options.
    """
    scene, attractors, box, wrap, options = shared
    return _core._basin_cells(scene, [vars(one) for one in attractors], box, wrap, *starts, options, own)


def turns_of(wrap: Mapping[int, float] | None, attractors: Sequence[Attractor] | None) -> tuple[tuple[int, float], ...]:
    """Return the positions that are angles, and their turns: those of the attractors where none are given."""
    return attractors.wrap if wrap is None and isinstance(attractors, Attractors) else turns(wrap)


def check_attractors(scene: Scene, attractors: Sequence[Attractor], phase: float) -> None:
    """Refuse attractors of another scene, or at another phase."""
    if not isinstance(attractors, Sequence):
        message = f"attractors is {shown(attractors)}, but a sequence of Attractor is needed"
        raise TypeError(message)
    if isinstance(attractors, Attractors):
        if attractors.scene != scene:
            message = "attractors are those of another scene"
            raise ValueError(message)
        if attractors.phase != phase:
            message = f"attractors have their points at phase {attractors.phase}, but phase is {phase}"
            raise ValueError(message)
    check_all(attractors)

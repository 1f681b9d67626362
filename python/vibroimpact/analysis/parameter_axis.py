"""The axes of maps and diagrams: a number of a scene, and its values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._validation import shown


def grid(values: ArrayLike, argument: str) -> NDArray[np.float64]:
    """Return the values of an axis, one at least."""
    found = _core._numbers(argument, values)
    if found.ndim != 1 or found.size == 0:
        message = f"{argument} has shape {found.shape}, but (m,) with at least one value is needed"
        raise ValueError(message)
    return found


def named(axis: Any, argument: str) -> tuple[str, NDArray[np.float64]]:
    """Return the name of a number of a scene and its values."""
    try:
        name, values = axis
    except (TypeError, ValueError):
        name = None
    if not isinstance(name, str):
        message = f"{argument} is {shown(axis)}, but (name of Scene.replace, values) is needed"
        raise ValueError(message)
    return name, grid(values, argument)

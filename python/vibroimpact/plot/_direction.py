"""Directions along which motions are drawn: a coordinate by its index, or any vector n, which shows ``n.q`` and ``n.v``."""

import operator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vibroimpact.plot._data import FloatArray


@dataclass(frozen=True)
class Direction:
    """A vector (n,), and the index of the coordinate that it stands for, if any."""

    vector: FloatArray
    index: int | None = None

    def of(self, rows: FloatArray) -> FloatArray:
        """Return the component of positions or velocities, one a row."""
        return rows[:, self.index] if self.index is not None else rows @ self.vector

    @property
    def position(self) -> str:
        """Name the position in a legend."""
        return "n\u00b7q" if self.index is None else f"q[{self.index}]"

    @property
    def velocity(self) -> str:
        """Name the velocity in a legend."""
        return "n\u00b7q'" if self.index is None else f"q'[{self.index}]"

    @property
    def acceleration(self) -> str:
        """Name the acceleration in a legend."""
        return "n\u00b7q''" if self.index is None else f"q''[{self.index}]"

    @property
    def position_label(self) -> str:
        """Name the position on an axis, whatever its unit."""
        return f"position {self.position}"

    @property
    def velocity_label(self) -> str:
        """Name the velocity on an axis, whatever its unit."""
        return f"velocity {self.velocity}"


def check_direction(along: ArrayLike, n_dof: int) -> Direction:
    """Return what is drawn along, or say what is wrong with it."""
    if np.ndim(along) == 0:
        try:
            index = operator.index(along)  # type: ignore[arg-type]
        except TypeError:
            index = -1
        if 0 <= index < n_dof:
            return Direction(np.eye(1, n_dof, index)[0], index)
    else:
        try:
            vector = np.asarray(along, dtype=float)
        except (TypeError, ValueError):
            vector = np.empty(0)
        if vector.shape == (n_dof,) and np.all(np.isfinite(vector)) and np.any(vector):
            return Direction(vector)
    raise ValueError(
        f"along must be an index from 0 to {n_dof - 1} or a direction of {n_dof} finite numbers, not all 0, got {along!r}"
    )


def normal_of(stop: Any, n_dof: int) -> FloatArray | None:
    """Return the normal of a plane stop as a vector (n,); a wall of a pendulum and a stop given by functions have none."""
    normal = getattr(stop, "normal", None)
    if normal is None:
        return None
    if np.ndim(normal) == 0:
        return np.asarray(np.eye(1, n_dof, int(normal))[0])
    return np.asarray(normal, dtype=float)


def acts_along(stop: Any, direction: Direction) -> bool:
    """Say whether a stop may change the velocity along a direction by a force of its own."""
    if hasattr(stop, "bob"):
        return bool(np.any(direction.vector[: stop.bob + 1]))
    normal = normal_of(stop, len(direction.vector))
    return normal is None or bool(normal @ direction.vector != 0.0)

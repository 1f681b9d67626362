"""Planes of states: two coordinates vary, or phase and speed of the states right after an impact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Newton, Scene
from vibroimpact._validation import shown
from vibroimpact.analysis import parameter_axis
from vibroimpact.run.tiles import Tile

#: Cells of an axis at most.
_MOST_CELLS = 1 << 24

_Values = NDArray[np.float64] | float


@dataclass(frozen=True)
class Plane:
    """States over x and y: of each coordinate, and of the phase, x, y or a number; y may be given with a factor."""

    x_name: str
    y_name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    coordinates: tuple[str | float, ...]
    phase: str | float
    y_factor: float = 1.0

    @property
    def box(self) -> NDArray[np.float64]:
        """Low and high of each coordinate."""
        sides = {"x": self.x, "y": self.y_factor * self.y}
        own = [sides[one] if isinstance(one, str) else np.array([one]) for one in self.coordinates]
        return np.array([(values.min(), values.max()) for values in own], dtype=np.float64)

    def starts(self, tile: Tile) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the states of the cells of a tile, one a row, and their phases."""
        rows, columns = tile
        grid = dict(zip("xy", np.meshgrid(self.x[columns], self.y_factor * self.y[rows]), strict=True))
        cells = grid["x"].size
        each = [grid[one].ravel() if isinstance(one, str) else np.full(cells, one) for one in (*self.coordinates, self.phase)]
        return np.column_stack(each[:-1]), each[-1]


def _axis_values(name: str, axis: Any) -> _Values:
    """Return the midpoints of ``(low, high, cells)``, the values of an axis, or a number."""
    if isinstance(axis, tuple) and len(axis) == 3:
        if isinstance(axis[2], bool) or not isinstance(axis[2], (int, np.integer)):
            message = f"{name} is {shown(axis)}, but (low, high, cells) needs a whole number of cells; values stand in a list"
            raise ValueError(message)
        low, high = (float(side) for side in _core._numbers(name, axis[:2]))
        cells = int(axis[2])
        if cells > _MOST_CELLS:
            message = f"{name} has {cells} cells, but no more than {_MOST_CELLS} have room"
            raise ValueError(message)
        if not (np.isfinite(low) and np.isfinite(high) and low < high and cells >= 1):
            message = f"{name} is {shown(axis)}, but (low, high, cells) must be finite, low below high, with at least one cell"
            raise ValueError(message)
        return low + (high - low) * (np.arange(cells) + 0.5) / cells
    if np.ndim(axis) == 0:
        value = float(_core._numbers(name, axis))
        if not np.isfinite(value):
            message = f"{name} is {value}, but it must be finite"
            raise ValueError(message)
        return value
    values = parameter_axis.grid(axis, name)
    if not np.isfinite(values).all():
        message = f"{name} has a value that is not finite"
        raise ValueError(message)
    return values


def _coordinates(scene: Scene, q: Any, v: Any) -> dict[str, _Values]:
    """Return an axis or a number for each coordinate, those that vary first in the order given."""
    given: dict[str, _Values] = {}
    for kind, own in (("q", q), ("v", v)):
        if not isinstance(own, Mapping):
            if own is not None and scene.n_dof > 1:
                message = (
                    f"{kind} is {own!r}, but of {scene.n_dof} degrees of freedom a dict {{coordinate: axis or number}} is needed"
                )
                raise ValueError(message)
            own = {0: own} if own is not None else {}
        for index, axis in own.items():
            if not isinstance(index, (int, np.integer)) or not 0 <= index < scene.n_dof:
                message = f"{kind} has the coordinate {index!r}, but the scene has {scene.n_dof}, counted from 0"
                raise ValueError(message)
            given[f"{kind}[{index}]"] = _axis_values(f"{kind}[{index}]", axis)
    names = [f"{kind}[{i}]" for kind in "qv" for i in range(scene.n_dof)]
    missing = [name for name in names if name not in given]
    if missing:
        message = f"{', '.join(missing)} is not given, but every coordinate needs an axis or a number"
        raise ValueError(message)
    return given


def of_coordinates(scene: Scene, q: Any, v: Any, phase: float) -> Plane:
    """Return the plane of two coordinates, the others numbers; the first given is x.

    Raises
    ------
    ValueError
        Other than two axes, values that are not finite, a coordinate that is not there or not given.
    """
    given = _coordinates(scene, q, v)
    names = [name for name, axis in given.items() if isinstance(axis, np.ndarray)]
    if len(names) != 2:
        message = f"{len(names)} coordinates vary, but two must: (low, high, cells) or values each, the others numbers"
        raise ValueError(message)
    x, y = (np.asarray(given[name]) for name in names)
    places = dict(zip(names, "xy", strict=True))
    all_names = [f"{kind}[{i}]" for kind in "qv" for i in range(scene.n_dof)]
    coordinates = tuple(places[name] if name in places else float(given[name]) for name in all_names)
    return Plane(names[0], names[1], x, y, coordinates, phase)


def after_impact(scene: Scene, impact: Mapping[str, Any]) -> Plane:
    """Return the plane of the states right after an impact, or at the beginning of a contact: its phase is x, the speed y.

    Raises
    ------
    ValueError
        A scene of more than one degree of freedom, other keys, numbers where axes should be, a stop that is not there or moves.
    """
    if scene.n_dof != 1:
        message = f"impact is given, but the scene has {scene.n_dof} degrees of freedom: states right after an impact need one"
        raise ValueError(message)
    if set(impact) != {"stop", "phase", "speed"}:
        message = f"impact has the keys {sorted(impact)}, but stop, phase and speed are needed"
        raise ValueError(message)
    stop = impact["stop"]
    if not isinstance(stop, (int, np.integer)) or not 0 <= stop < len(scene.stops):
        message = f"stop is {stop!r}, but the scene has {len(scene.stops)} stops"
        raise ValueError(message)
    phase, speed = (_axis_values(name, impact[name]) for name in ("phase", "speed"))
    if not (isinstance(phase, np.ndarray) and isinstance(speed, np.ndarray)):
        message = "impact has a number in place of an axis, but phase and speed must both vary"
        raise ValueError(message)
    if (speed < 0.0).any():
        message = f"speed has {speed.min()}, but what leaves a stop has a speed of 0 or more"
        raise ValueError(message)
    if getattr(scene.stops[stop], "motion", None) is not None:
        message = f"stop {stop} moves, but states after an impact are those of a stop that rests: give q and v"
        raise ValueError(message)
    here, there = (float(scene.gaps([x])[stop]) for x in (0.0, 1.0))
    place, opening = -here / (there - here), float(np.sign(there - here))
    if not isinstance(scene.stops[stop].contact, Newton):
        opening = -opening  # the beginning of a contact
    return Plane("phase", "speed", phase, speed, (place, "y"), "x", opening)

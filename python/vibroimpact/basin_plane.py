"""Basins: which states of a scene lead to which of its attractors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _axis, _boundary, _workers
from vibroimpact._boundary import Fit
from vibroimpact._core import Scene
from vibroimpact._labels import INSIDE, LOST, UNDECIDED, check_attractors, labels_of
from vibroimpact._results import ArrayResult
from vibroimpact.attractors import Attractor, Attractors, check_all, find_attractors

__all__ = ["Basins", "Fit", "basins"]


@dataclass(frozen=True, eq=False)
class Basins(ArrayResult):
    """Which states of a plane lead to which attractor: ny x nx cells.

    Attributes
    ----------
    labels : ndarray of int16, shape (ny, nx)
        k + 1 where a state leads to ``attractors[k]``; 0 undecided, -1 lost, -2 inside a stop.
    iterations : ndarray of int32, shape (ny, nx)
        Periods of the forcing until it was decided.
    x, y : ndarray, shape (nx,) and (ny,)
        The states: values of ``x_name`` and ``y_name``, such as "q[0]", "v[0]", "phase", "speed".
    attractors : Attractors or tuple of Attractor
        The attractors.
    """

    labels: NDArray[np.int16]
    iterations: NDArray[np.int32]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    x_name: str
    y_name: str
    attractors: Attractors | tuple[Attractor, ...]

    def __post_init__(self) -> None:
        """Refuse arrays that are none of one plane."""
        if not isinstance(self.attractors, Attractors):
            object.__setattr__(self, "attractors", tuple(self.attractors))
        self._check_types({"x_name": str, "y_name": str})
        check_all(self.attractors)
        shape = (*np.shape(self.y)[:1], *np.shape(self.x)[:1])
        self._check({"labels": ("i", shape), "iterations": ("i", shape), "x": ("f", shape[1:]), "y": ("f", shape[:1])})

    @property
    def fractions(self) -> NDArray[np.float64]:
        """The part of the cells outside every stop that leads to each attractor."""
        outside = max(int((self.labels != INSIDE).sum()), 1)
        return np.array([(self.labels == k + 1).sum() / outside for k in range(len(self.attractors))])

    def entropy(self, cells: int = 10) -> tuple[float, float]:
        """Return the basin entropy, and that of the boundary, of boxes of so many cells a side (Daza et al. 2016).

        The first is the mean over all boxes of ``-sum p ln p``, p the parts of a box that lead to each attractor, or are lost;
        the second the mean over boxes with more than one. Beyond ``ln 2`` the boundary is fractal.
        """
        return _boundary.entropy(self.labels, cells)

    def boundary_dimension(self) -> Fit:
        """Return the dimension of the boundary: boxes of each size that hold more than one basin are counted."""
        return _boundary.dimension(self.labels)

    def uncertainty_exponent(self) -> Fit:
        """Return the exponent by which states become certain: those with another label at a distance are counted, over distances.

        The dimension of the boundary is that of the plane, 2, less the exponent.
        """
        return _boundary.uncertainty(self.labels)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the plane, for ``numpy.savez``."""
        return {name: getattr(self, name) for name in ("labels", "iterations", "x", "y")}

    def __repr__(self) -> str:
        """Say how large the basins are, and what to do about states that were not decided."""
        parts = [f"{fraction:.3g}" for fraction in self.fractions]
        left = [(name, int((self.labels == label).sum())) for name, label in (("lost", LOST), ("inside a stop", INSIDE))]
        others = "".join(f", {count} {name}" for name, count in left if count)
        undecided = int((self.labels == UNDECIDED).sum())
        remedy = ""
        if undecided:
            remedy = f", {undecided} undecided: more max_periods, or find_attractors with these states as seeds"
        plane = f"{self.x_name} x {self.y_name}, {self.labels.shape[1]} x {self.labels.shape[0]}"
        return f"Basins({plane}: fractions [{', '.join(parts)}]{others}{remedy})"


def _axis_values(name: str, axis: Any) -> NDArray[np.float64] | float:
    """Return the midpoints of ``(low, high, cells)``, the values of an axis, or a number."""
    if isinstance(axis, tuple) and len(axis) == 3 and isinstance(axis[2], (int, np.integer)) and not isinstance(axis[2], bool):
        low, high, cells = float(axis[0]), float(axis[1]), int(axis[2])
        if not (np.isfinite(low) and np.isfinite(high) and low < high and cells >= 1):
            message = f"{name} is {axis!r}, but (low, high, cells) must be finite, low below high, with at least one cell"
            raise ValueError(message)
        return low + (high - low) * (np.arange(cells) + 0.5) / cells
    if np.ndim(axis) == 0:
        value = float(axis)
        if not np.isfinite(value):
            message = f"{name} is {value}, but it must be finite"
            raise ValueError(message)
        return value
    values = _axis.grid(axis, name)
    if not np.isfinite(values).all():
        message = f"{name} has a value that is not finite"
        raise ValueError(message)
    return values


def _coordinates(scene: Scene, q: Any, v: Any) -> dict[str, NDArray[np.float64] | float]:
    """Return an axis or a number for each coordinate, those that vary first in the order given."""
    given: dict[str, NDArray[np.float64] | float] = {}
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


def _plane(scene: Scene, q: Any, v: Any) -> tuple[list[str], list[NDArray[np.float64]], NDArray[np.float64], NDArray[np.float64]]:
    """Return names and values of both axes, the states of all cells, and the box that they span."""
    given = _coordinates(scene, q, v)
    names = [name for name, axis in given.items() if isinstance(axis, np.ndarray)]
    if len(names) != 2:
        message = f"{len(names)} coordinates vary, but two must: (low, high, cells) or values each, the others numbers"
        raise ValueError(message)
    x, y = (np.asarray(given[name]) for name in names)
    columns = []
    sides = []
    for kind in "qv":
        for i in range(scene.n_dof):
            axis = given[f"{kind}[{i}]"]
            sides.append((np.min(axis), np.max(axis)))
            place = names.index(f"{kind}[{i}]") if f"{kind}[{i}]" in names else None
            shaped = np.asarray(axis) if place is None else (x[None, :] if place == 0 else y[:, None])
            columns.append(np.broadcast_to(shaped, (len(y), len(x))).ravel())
    return names, [x, y], np.column_stack(columns), np.array(sides, dtype=np.float64)


def _after_impact(
    scene: Scene, impact: Mapping[str, Any]
) -> tuple[list[str], list[NDArray[np.float64]], NDArray[np.float64], NDArray[np.float64]]:
    """Return names and values of both axes, the states right after the impacts, and their phases."""
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
    if getattr(scene.stops[stop], "motion", None) is not None:
        message = f"stop {stop} moves, but states after an impact are those of a stop that rests: give q and v"
        raise ValueError(message)
    here, there = (float(scene.gaps([x])[stop]) for x in (0.0, 1.0))
    place, opening = -here / (there - here), np.sign(there - here)
    grid_phase, grid_speed = np.meshgrid(phase, speed)
    states = np.column_stack([np.full(grid_phase.size, place), opening * grid_speed.ravel()])
    return ["phase", "speed"], [phase, speed], states, grid_phase.ravel()


def basins(
    scene: Scene,
    *,
    q: Any = None,
    v: Any = None,
    phase: float = 0.0,
    impact: Mapping[str, Any] | None = None,
    attractors: Sequence[Attractor] | None = None,
    box: ArrayLike | None = None,
    hits: int | None = None,
    max_periods: int = 2000,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float = 1e-12,
    workers: _workers.Workers = None,
    progress: bool = False,
) -> Basins:
    """Say of each state of a plane to which attractor it leads.

    Two passes: the attractors are found first; then each cell alone is followed until it stays on one of them, so that the result
    has the same bits whoever computes it. Motions are looked at once in each period, at the phase farthest from the impacts of
    all orbits. A label is a numerical statement about the state in the middle of a cell, no proof; near a fractal boundary it
    says no more than that (theory 18).

    Parameters
    ----------
    scene : Scene
        A scene whose forcing has a period.
    q, v : dict, (low, high, cells), array_like or float
        Of each coordinate an axis (cells between low and high, of which the midpoints are taken, or values) or a number:
        ``q={0: (-1, 1, 200), 1: 0.2}``; of one degree of freedom the axis alone. Two vary, the first is x.
    phase : float, default 0.0
        The phase of the forcing [rad] at which the motions begin.
    impact : dict, optional
        In place of q and v, of one degree of freedom: states right after an impact, ``{"stop": 0, "phase": axis, "speed":
        axis}``.
    attractors : sequence of Attractor, optional
        As ``find_attractors`` finds them at this phase; without, it is called with the box first.
    box : array_like, shape (2n, 2), optional
        Low and high of each coordinate, by which distances are measured and attractors are sought; default that of the
        attractors, or of the plane.
    hits : int, optional
        Periods for which a motion must follow an attractor; default three of an orbit's own, 20 of a set.
    max_periods : int, default 2000
        Periods after which a state is left undecided.
    method, rtol, atol
        As for ``simulate``.
    workers : int, Executor or callable, optional
        As for ``simulate_many``. The bits are the same with any.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    Basins
        Labels, periods until they were decided, the attractors.

    Raises
    ------
    ValueError
        Other than two axes, axes or numbers that are not finite, a coordinate without either, ``impact`` with q or v or more than
        one degree of freedom; a scene without a forcing period; attractors of another scene.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> found = vi.basins(scene, q=(-3, 1, 20), v=(-5, 5, 20))
    >>> found.labels.shape, [one.n_periods for one in found.attractors]
    ((20, 20), [3, 1])
    """
    if impact is not None and (q is not None or v is not None):
        message = "impact is given with q or v, but states are given by one of them"
        raise ValueError(message)
    if impact is None:
        names, axes, states, sides = _plane(scene, q, v)
        phases = np.full(len(states), float(phase))
    else:
        names, axes, states, phases = _after_impact(scene, impact)
        sides = None
    around = _box(box, attractors, sides)
    if attractors is None:
        search = {"phase": phase, "method": method, "rtol": rtol, "atol": atol, "workers": workers, "progress": progress}
        attractors = find_attractors(scene, around, **search)  # type: ignore[arg-type]
    check_attractors(scene, attractors, phase)
    options = (float(phase), max_periods, hits, method, rtol, atol)
    labels, iterations = labels_of(scene, attractors, around, (states, phases), options, workers, progress)
    shape = (len(axes[1]), len(axes[0]))
    kept = attractors if isinstance(attractors, Attractors) else tuple(attractors)
    return Basins(labels.reshape(shape), iterations.reshape(shape), axes[0], axes[1], names[0], names[1], kept)


def _box(box: ArrayLike | None, attractors: Sequence[Attractor] | None, sides: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Return the box by which distances are measured."""
    if box is not None:
        return np.array(box, dtype=np.float64)
    if isinstance(attractors, Attractors):
        return attractors.box
    if sides is None:
        message = (
            "box is not given, but with impact= it, or attractors of find_attractors, must say by what distances are measured"
        )
        raise ValueError(message)
    return sides

"""Existence maps: where in a plane of two parameters a pattern has periodic orbits."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _axis, _core, _workers
from vibroimpact._core import Scene
from vibroimpact._results import ArrayResult

__all__ = ["ExistenceMap", "existence_map"]

#: Pieces handed to an executor where a function of Python, which may be slow, makes each cell.
_CALLED_PIECES = 1024

Pattern = Iterable[int | tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class ExistenceMap(ArrayResult):
    """Where in a plane of two parameters a pattern has periodic orbits.

    Attributes
    ----------
    x, y : ndarray, shape (nx,) and (ny,)
        Values of the parameters.
    x_name, y_name : str or None
        What they are, None for a map made by a callable.
    n_orbits : ndarray of int, shape (ny, nx)
        Number of orbits, admissible or not.
    is_admissible, is_stable : ndarray of bool, shape (ny, nx)
        Whether one of them is admissible; admissible and stable.
    multiplier : ndarray, shape (ny, nx)
        Largest modulus of the multipliers of the first orbit, nan where there is none.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    x_name: str | None
    y_name: str | None
    n_orbits: NDArray[np.int64]
    is_admissible: NDArray[np.bool_]
    is_stable: NDArray[np.bool_]
    multiplier: NDArray[np.float64]

    def __post_init__(self) -> None:
        """Refuse arrays that are none of one map."""
        cells = (np.size(self.y), np.size(self.x))
        axes = {"x": ("f", cells[1:]), "y": ("f", cells[:1])}
        found = {"n_orbits": "i", "is_admissible": "b", "is_stable": "b", "multiplier": "f"}
        self._check(axes | {name: (kind, cells) for name, kind in found.items()})

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the map, for ``numpy.savez``."""
        names = ("x", "y", "n_orbits", "is_admissible", "is_stable", "multiplier")
        return {name: getattr(self, name) for name in names}

    def __repr__(self) -> str:
        """Say what the map is over and what it found."""
        cells = self.n_orbits.size
        found = (
            f"{np.count_nonzero(self.n_orbits)} with an orbit, {np.count_nonzero(self.is_admissible)} with an admissible "
            f"one, {np.count_nonzero(self.is_stable)} with a stable admissible one"
        )
        return f"ExistenceMap({self.x_name or 'x'} x {self.y_name or 'y'}, {cells} cells: {found})"


def _tile(piece: tuple[Any, ...], ask: _workers.Ask) -> tuple[NDArray[Any], ...]:
    arguments: tuple[Any, ...] = (*piece, ask)
    return _core._existence_tile(*arguments)


def _called_cells(piece: tuple[Any, ...], ask: _workers.Ask) -> tuple[NDArray[Any], ...]:
    """Cells of a map whose scenes a callable makes."""
    make, pattern, n_periods, values = piece
    cells = []
    for x, y in values:
        ask()
        cells.append(_core._existence_at(make(x, y), pattern, n_periods, ask))
    kinds: tuple[type, ...] = (np.int64, np.bool_, np.bool_, np.float64)
    return tuple(np.array([cell[k] for cell in cells], dtype=kind) for k, kind in enumerate(kinds))


def existence_map(
    scene: Scene | Callable[[float, float], Scene],
    pattern: Pattern,
    x: tuple[str, ArrayLike] | ArrayLike,
    y: tuple[str, ArrayLike] | ArrayLike,
    n_periods: int = 1,
    *,
    workers: _workers.Workers = None,
    progress: bool = False,
) -> ExistenceMap:
    """Map where in a plane of two parameters a pattern has a periodic orbit, an admissible one, a stable one.

    Parameters
    ----------
    scene : Scene or callable
        A linear, forced scene, or ``(x, y) -> Scene`` (slower; called in the calling process or, pickled, by ``workers``).
    pattern : list
        Indices of stops in order of impact; a tuple is hit at one instant.
    x, y : (str, array_like) or array_like, shape (nx,) and (ny,)
        A name of ``Scene.replace`` ("frequency", "forcing_scale", "damping_scale", "restitution", "clearance",
        "clearance[1]" for one stop; "amplitude" of a base motion) and its values; for a callable the values alone.
    n_periods : int, default 1
        Forcing periods in one period of the orbit.
    workers : int, Executor or callable, optional
        Threads (default: every core), a ``concurrent.futures.Executor``, or a map-like callable. The result has the same bits
        with any of them. A piece that fails, or Ctrl-C, cancels those of an executor that wait.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    ExistenceMap
        Arrays ``n_orbits``, ``is_admissible``, ``is_stable``, ``multiplier`` of shape ``(len(y), len(x))``. Where doubles do
        not hold the motion, as ``periodic_orbits`` says by an error (it outgrows them within a period, or the period has more
        than 1e12 turns of the fastest mode), there is no orbit.

    Raises
    ------
    ValueError
        A name that does not exist, a value that breaks its rule, a scene or pattern that ``periodic_orbits`` refuses.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> vi.existence_map(scene, [1], ("frequency", [1.4, 1.5]), ("clearance", [0.15, 10.0]), n_periods=2).n_orbits
    array([[2, 2],
           [0, 0]])
    """
    pattern = list(pattern)
    if callable(scene):
        x_values, y_values = _axis.grid(x, "x"), _axis.grid(y, "y")  # type: ignore[arg-type]
        points = [(float(a), float(b)) for b in y_values for a in x_values]
        pieces = [(scene, pattern, n_periods, points[i:j]) for i, j in _workers.bounds(len(points), _CALLED_PIECES)]
        parts = _workers.run(_called_cells, pieces, workers if _workers.is_elsewhere(workers) else map, progress=progress)
        return _assemble(parts, (None, x_values), (None, y_values))
    x_axis, y_axis = _axis.named(x, "x"), _axis.named(y, "y")
    if not _workers.is_elsewhere(workers):
        cells = _core._existence_cells(scene, pattern, x_axis, y_axis, n_periods, _workers.threads(workers), progress)
        return _assemble([cells], x_axis, y_axis)
    bounds = _workers.bounds(x_axis[1].size * y_axis[1].size)
    tiles = [(scene, pattern, x_axis, y_axis, n_periods, cells) for cells in bounds]
    return _assemble(_workers.run(_tile, tiles, workers, progress=progress), x_axis, y_axis)


def _assemble(
    parts: list[tuple[NDArray[Any], ...]],
    x: tuple[str | None, NDArray[np.float64]],
    y: tuple[str | None, NDArray[np.float64]],
) -> ExistenceMap:
    """Put the cells of the pieces together."""
    shape = (y[1].size, x[1].size)
    n_orbits, admissible, stable, multiplier = (np.concatenate([part[k] for part in parts]).reshape(shape) for k in range(4))
    return ExistenceMap(x[1], y[1], x[0], y[0], n_orbits, admissible, stable, multiplier)

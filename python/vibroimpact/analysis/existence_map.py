"""Existence maps: where in a plane of two parameters a pattern has periodic orbits."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import Scene
from vibroimpact.analysis import parameter_axis
from vibroimpact.results.existence_map import ExistenceMap
from vibroimpact.run import pool
from vibroimpact.run.store import STORED_RESULTS, Restored, Store, check_axes, check_options
from vibroimpact.run.stored_arguments import decode
from vibroimpact.run.tiled_work import Columns, Found, worked_out
from vibroimpact.run.tiles import Tile

__all__ = ["existence_map"]

COLUMNS: Columns = {
    "is_admissible": ("?", False),
    "is_stable": ("?", False),
    "multiplier": ("f8", np.nan),
    "n_orbits": ("i8", -1),
}

#: Pieces where a function of Python, which may be slow, makes each cell.
_CALLED_PIECES = 1024

_Axis = tuple[str | None, NDArray[np.float64]]

Pattern = Iterable[int | tuple[int, ...]]


def _tile(shared: tuple[Any, ...], tile: Tile, own: pool.Own) -> Found:
    """Cells of a map whose scenes `replace` makes."""
    scene, pattern, n_periods, (x_name, x), (y_name, y) = shared
    rows, columns = tile
    arguments: tuple[Any, ...] = (scene, pattern, (x_name, x[columns]), (y_name, y[rows]), n_periods, own)
    return _core._existence_cells(*arguments)


def _called_tile(shared: tuple[Any, ...], tile: Tile, own: pool.Own) -> Found:
    """Cells of a map whose scenes a callable makes."""
    make, pattern, n_periods, (_, x), (_, y) = shared
    rows, columns = tile
    ask = own[2]
    found = []
    for b in y[rows].tolist():
        for a in x[columns].tolist():
            if ask is not None:
                ask()
            found.append(_core._existence_at(make(a, b), pattern, n_periods, ask))
    return {name: np.array([cell[name] for cell in found]) for name in COLUMNS}


def existence_map(
    scene: Scene | Callable[[float, float], Scene],
    pattern: Pattern,
    x: tuple[str, ArrayLike] | ArrayLike,
    y: tuple[str, ArrayLike] | ArrayLike,
    n_periods: int = 1,
    *,
    workers: pool.Workers = None,
    store: Any = None,
    overwrite: bool = False,
    key: str | None = None,
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
    store : str, path-like or store of zarr, optional
        A folder (needs zarr) into which cells are written while they are worked out. The same call goes on where one was broken
        off, with the same bits; ``load`` opens what is there. A callable is told from others by its code, values and
        attributes, and by those of all that it reads and calls outside of libraries; an object by what pickle keeps of it, so
        that what a call changes in it can be left out by ``__getstate__``.
    overwrite : bool, default False
        Whether a store that other arguments have made is replaced; one that the same have made is gone on with.
    key : str, optional
        A text that stands for code that a store cannot look through, as functions compiled from C: another code, another key.
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
        A name that does not exist, a value that breaks its rule, a scene or pattern that ``periodic_orbits`` refuses; a store
        that is a file, has something else in it, or was made with other arguments or other code, or, without a key, a callable
        with a part that cannot be looked through.
    OSError
        A store that cannot be written. What it had before is kept.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> vi.existence_map(scene, [1], ("frequency", [1.4, 1.5]), ("clearance", [0.15, 10.0]), n_periods=2).n_orbits
    array([[2, 2],
           [0, 0]])
    """
    check_options(overwrite, key)
    pattern = list(pattern)
    axes: tuple[_Axis, _Axis]
    if callable(scene):
        axes = (None, parameter_axis.grid(x, "x")), (None, parameter_axis.grid(y, "y"))  # type: ignore[arg-type]
        work, pieces = _called_tile, _CALLED_PIECES
    else:
        x_named, y_named = parameter_axis.named(x, "x"), parameter_axis.named(y, "y")
        _core._check_existence(scene, pattern, x_named, y_named, n_periods)
        work, pieces, axes = _tile, pool.count(workers), (x_named, y_named)
    (x_name, x_values), (y_name, y_values) = axes
    kept = None
    if store is not None:
        arguments = {"scene": scene, "pattern": pattern, "x": axes[0], "y": axes[1], "n_periods": n_periods}
        kept = Store(store, "ExistenceMap", arguments, {"x": x_values, "y": y_values}, COLUMNS, overwrite=overwrite, key=key)
    shared = (scene, pattern, n_periods, *axes)
    found = worked_out(work, shared, (y_values.size, x_values.size), COLUMNS, pieces, workers, progress, kept)
    return ExistenceMap(x_values, y_values, x_name, y_name, **found)


def from_store(contents: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> ExistenceMap:
    """Return the map that a store holds, finished or not."""
    (x_name, x), (y_name, y) = (decode(contents["arguments"][axis]) for axis in ("x", "y"))
    check_axes(arrays, x, y)
    return ExistenceMap(x_name=x_name, y_name=y_name, **arrays)


STORED_RESULTS["ExistenceMap"] = Restored(COLUMNS, from_store)

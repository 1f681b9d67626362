"""Sweeps: existence maps over two parameters, and many trajectories at once."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core, _workers
from vibroimpact._core import LinearSystem, Ramp, Scene

__all__ = ["Ensemble", "ExistenceMap", "existence_map", "simulate_many"]

#: Pieces handed to an executor: enough to share evenly, each long enough to be worth sending.
_PIECES = 64

#: The same where a function of Python, which may be slow, makes each cell.
_CALLED_PIECES = 1024

Pattern = Iterable[int | tuple[int, ...]]


def _check_arrays(result: Any, arrays: dict[str, tuple[str, tuple[int, ...]]]) -> None:
    """Refuse what is no array of the kind (a letter of NumPy) and shape that it has in a result."""
    for name, (kind, shape) in arrays.items():
        array = getattr(result, name)
        if not isinstance(array, np.ndarray) or array.shape != shape:
            message = f"{name} has shape {np.shape(array)}, but an array of shape {shape} is needed"
            raise ValueError(message)
        if array.dtype.kind != kind:
            message = f"{name} has dtype {array.dtype}, but one of kind {kind!r} is needed"
            raise ValueError(message)


@dataclass(frozen=True, eq=False)
class ExistenceMap:
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
        _check_arrays(self, axes | {name: (kind, cells) for name, kind in found.items()})

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the arguments, which are looked at again."""
        return ExistenceMap, tuple(getattr(self, own.name) for own in fields(self))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map to a file, an ``.npz`` archive with a header in JSON, from which ``load`` reads it again."""
        from vibroimpact import _files

        _files.save(self, path)

    def to_xarray(self) -> Any:
        """Return the map as an ``xarray.Dataset``; needs xarray, the extra "xarray".

        Returns
        -------
        xarray.Dataset
            ``n_orbits``, ``is_admissible``, ``is_stable`` and ``multiplier`` over y and x.

        Raises
        ------
        ImportError
            Without xarray.
        """
        from vibroimpact import _xarray

        return _xarray.to_xarray(self)

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


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Many trajectories, one row each: their ends, or their motions at given times, and their impacts.

    Attributes
    ----------
    q, v : ndarray, shape (k, n), or (k, m, n)
        Final positions and velocities, or those at ``t_eval``, nan after an early end.
    n_impacts : ndarray of int, shape (k,)
        Impacts of each trajectory.
    status : ndarray of str, shape (k,)
        How each ended.
    impacts : ndarray or None
        With ``keep="impacts"`` those of all, run after run: structured array of run, time, stop, speed_before, speed_after,
        impulse, phase.
    """

    q: NDArray[np.float64]
    v: NDArray[np.float64]
    n_impacts: NDArray[np.int64]
    status: NDArray[np.str_]
    impacts: NDArray[np.void] | None = field(default_factory=lambda: None)

    def __post_init__(self) -> None:
        """Refuse arrays that are none of one ensemble."""
        k = np.shape(self.status)[:1]
        n = np.shape(self.q)[1:3]
        arrays = {"q": ("f", k + n), "v": ("f", k + n), "n_impacts": ("i", k), "status": ("U", k)}
        if self.impacts is not None:
            arrays["impacts"] = ("V", np.shape(self.impacts)[:1])
        _check_arrays(self, arrays)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the arguments, which are looked at again."""
        return Ensemble, tuple(getattr(self, own.name) for own in fields(self))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the ensemble to a file, an ``.npz`` archive with a header in JSON, from which ``load`` reads it again."""
        from vibroimpact import _files

        _files.save(self, path)

    def to_xarray(self) -> Any:
        """Return the ensemble as an ``xarray.Dataset``; needs xarray, the extra "xarray".

        Returns
        -------
        xarray.Dataset
            ``q`` and ``v`` over run, time with ``t_eval``, and dof, ``n_impacts`` and ``status`` over run; columns of the
            impacts.

        Raises
        ------
        ImportError
            Without xarray.
        """
        from vibroimpact import _xarray

        return _xarray.to_xarray(self)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the ensemble, for ``numpy.savez``."""
        arrays = {name: getattr(self, name) for name in ("q", "v", "n_impacts", "status", "impacts")}
        return {name: array for name, array in arrays.items() if array is not None}

    def __repr__(self) -> str:
        """Say how many trajectories there are and how they ended."""
        kinds, counts = np.unique(self.status, return_counts=True)
        ends = ", ".join(f"{count} {kind}" for kind, count in zip(kinds, counts, strict=True))
        return f"Ensemble({len(self.status)} trajectories: {ends}; {self.n_impacts.sum()} impacts)"


def _bounds(total: int, pieces: int = _PIECES) -> list[tuple[int, int]]:
    """Cut ``range(total)`` into pieces of nearly equal length."""
    edges = np.linspace(0, total, min(total, pieces) + 1).astype(int)
    return [(int(a), int(b)) for a, b in itertools.pairwise(edges)]


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


def _grid(values: ArrayLike, argument: str) -> NDArray[np.float64]:
    grid = _core._numbers(argument, values)
    if grid.ndim != 1 or grid.size == 0:
        message = f"{argument} has shape {grid.shape}, but (m,) with at least one value is needed"
        raise ValueError(message)
    return grid


def _named(axis: Any, argument: str) -> tuple[str, NDArray[np.float64]]:
    try:
        name, values = axis
    except (TypeError, ValueError):
        name = None
    if not isinstance(name, str):
        message = f"{argument} is {axis!r}, but (name of Scene.replace, values) is needed"
        raise ValueError(message)
    return name, _grid(values, argument)


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
        x_values, y_values = _grid(x, "x"), _grid(y, "y")  # type: ignore[arg-type]
        points = [(float(a), float(b)) for b in y_values for a in x_values]
        pieces = [(scene, pattern, n_periods, points[i:j]) for i, j in _bounds(len(points), _CALLED_PIECES)]
        parts = _workers.run(_called_cells, pieces, workers if _workers.is_elsewhere(workers) else map, progress=progress)
        return _assemble(parts, (None, x_values), (None, y_values))
    x_axis, y_axis = _named(x, "x"), _named(y, "y")
    if not _workers.is_elsewhere(workers):
        cells = _core._existence_cells(scene, pattern, x_axis, y_axis, n_periods, _workers.threads(workers), progress)
        return _assemble([cells], x_axis, y_axis)
    bounds = _bounds(x_axis[1].size * y_axis[1].size)
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


#: A scene without anything, of which no run is made.
_NOTHING = Scene(LinearSystem(1.0, 0.0, 0.0))


def _rows(piece: tuple[Any, ...], ask: _workers.Ask) -> tuple[Any, ...]:
    arguments: tuple[Any, ...] = (*piece, ask)
    return _core._simulate_rows(*arguments)


def _scenes(scene: Any, q0: ArrayLike, v0: ArrayLike) -> list[Scene]:
    """Return scenes that are given one by one, or made by a function for each row."""
    if callable(scene):
        first = _made("scene(0)", scene(0))
        k = max(len(_states("q0", q0, first.n_dof)), len(_states("v0", v0, first.n_dof)))
        return [first, *(_made(f"scene({i})", scene(i)) for i in range(1, k))][:k]
    try:
        scenes = list(scene)
    except TypeError:
        message = f"scene is {scene!r}, but a Scene, a sequence of them or a callable is needed"
        raise TypeError(message) from None
    return [_made(f"scene[{i}]", one) for i, one in enumerate(scenes)]


def _made(argument: str, scene: Any) -> Scene:
    if not isinstance(scene, Scene):
        message = f"{argument} is {scene!r}, but a Scene is needed"
        raise TypeError(message)
    return scene


def _states(argument: str, value: ArrayLike, n_dof: int) -> NDArray[np.float64]:
    """Return states, one a row, that can be cut into pieces; for one degree of freedom a list of numbers is a list of rows."""
    rows = _core._numbers(argument, value)
    if rows.ndim == 1 and n_dof == 1:
        rows = rows[:, np.newaxis]
    if rows.shape == (n_dof,) or rows.ndim == 0:
        rows = rows.reshape(1, -1)
    if rows.ndim != 2 or rows.shape[1] != n_dof:
        message = f"{argument} has shape {rows.shape}, but (k, {n_dof}) is needed"
        raise ValueError(message)
    for i in np.flatnonzero(~np.isfinite(rows).all(axis=1)):
        message = f"{argument}[{i}] is {rows[i]}, but it must be finite"
        raise ValueError(message)
    return rows


def _in_pieces(scene: Scene | list[Scene], q0: ArrayLike, v0: ArrayLike) -> list[tuple[Any, ...]]:
    """Cut scenes and states into pieces: scene or scenes, rows, and the number of the first."""
    n_dof = scene.n_dof if isinstance(scene, Scene) else scene[0].n_dof
    states = [_states("q0", q0, n_dof), _states("v0", v0, n_dof)]
    counts = [len(rows) for rows in states] + ([len(scene)] if isinstance(scene, list) else [])
    k = next((count for count in counts if count != 1), 1)
    for argument, count in zip(("q0", "v0", "scene"), counts, strict=False):
        if count not in (1, k):
            message = f"{argument} has shape ({count}, {n_dof}), but ({k}, {n_dof}) is needed"
            raise ValueError(message)

    def part(rows: NDArray[np.float64], i: int, j: int) -> NDArray[np.float64]:
        return rows if len(rows) == 1 and k > 1 else rows[i:j]

    def scenes(i: int, j: int) -> Scene | list[Scene]:
        return scene[i:j] if isinstance(scene, list) else scene

    return [(scenes(i, j), *(part(rows, i, j) for rows in states), i) for i, j in _bounds(k) or [(0, 0)]]


def simulate_many(
    scene: Scene | Sequence[Scene] | Callable[[int], Scene],
    q0: ArrayLike,
    v0: ArrayLike,
    t_span: tuple[float, float],
    *,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float = 1e-12,
    t_eval: ArrayLike | None = None,
    keep: str = "final",
    max_impacts: int | None = None,
    ramp: Ramp | Sequence[Ramp] | None = None,
    workers: _workers.Workers = None,
    progress: bool = False,
) -> Ensemble:
    """Simulate one scene from many states, or many scenes; the same bits as one by one.

    Parameters
    ----------
    scene : Scene, sequence of Scene, or callable
        One for all; one each, all of n degrees of freedom; or ``i -> Scene`` for the i-th row of ``q0``. Pendulums with stops
        and walls that share a scene run four or eight abreast. q0, v0 : array_like, shape (k, n), or (n,) for all
        Positions and velocities at the start, one row each.
    t_span : pair of float
        Start and end [s].
    method : {"auto", "exact", "taylor", "rk45", "dop853", "radau"}, default "auto"
        As for ``simulate``, in any letter case.
    rtol, atol, max_impacts, ramp
        As for ``simulate``.
    t_eval : array_like, shape (m,), optional
        Times at which the motions are wanted, ascending.
    keep : {"final", "impacts"}, default "final"
        Final states, in constant memory for each trajectory, or their impacts too.
    workers : int, Executor or callable, optional
        Threads (default: every core), a ``concurrent.futures.Executor``, or a map-like callable. A piece that fails, or
        Ctrl-C, cancels those of an executor that wait.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    Ensemble
        ``q``, ``v`` (k, n), or (k, m, n) with ``t_eval``; ``n_impacts``, ``status`` (k,); ``impacts``. A start inside a stop
        has the status "inside_stop" and its state as given; the others run.

    Raises
    ------
    ValueError
        As for ``simulate``, naming the row; ``keep="motion"``; scenes and rows that are not as many.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> ends = vi.simulate_many(scene, np.zeros((3, 2)), [[0, 0], [0, 0.1], [0.1, 0]], (0, 20))
    >>> ends.q.shape
    (3, 2)
    >>> scenes = [scene.replace(restitution=e) for e in (0.5, 0.7, 0.9)]
    >>> runs = vi.simulate_many(scenes, [0, 0], [0, 0.1], (0, 100), keep="impacts")
    >>> np.bincount(runs.impacts["run"]).tolist() == runs.n_impacts.tolist()
    True
    """
    if keep not in ("final", "impacts"):
        message = f'keep is "{keep}", but an ensemble keeps impacts, or final states alone: it must be "impacts" or "final"'
        raise ValueError(message)
    if not isinstance(scene, Scene):
        scene = _scenes(scene, q0, v0)
    if isinstance(scene, list) and not scene:
        scene, q0, v0 = _NOTHING, np.empty((0, 1)), np.empty((0, 1))
    rest = (t_span, method, rtol, atol, t_eval, keep, max_impacts, ramp)
    if _workers.is_elsewhere(workers):
        pieces = [(*piece[:3], *rest, 1, False, piece[3]) for piece in _in_pieces(scene, q0, v0)]
        parts = _workers.run(_rows, pieces, workers, progress=progress)
    else:
        parts = [_core._simulate_rows(scene, q0, v0, *rest, _workers.threads(workers), progress, 0, None)]
    q, v, n_impacts = (np.concatenate([part[k] for part in parts]) for k in range(3))
    status = np.concatenate([np.array(part[3], dtype=np.str_) for part in parts])
    impacts = np.concatenate([part[4] for part in parts]) if keep == "impacts" else None
    return Ensemble(q, v, n_impacts, status, impacts)

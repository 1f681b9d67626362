"""Many trajectories at once, of one scene or of as many."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import LinearSystem, Ramp, Scene
from vibroimpact._validation import shown
from vibroimpact.results.ensemble import Ensemble
from vibroimpact.run import pool

__all__ = ["simulate_many"]


#: A scene without anything, of which no run is made.
_NOTHING = Scene(LinearSystem(1.0, 0.0, 0.0))


def _rows(shared: tuple[Any, ...], piece: tuple[Any, ...], own: pool.Own) -> dict[str, Any]:
    scene, t_span, options = shared
    scenes, q0, v0, first = piece
    return _core._simulate_rows(scene if scenes is None else scenes, q0, v0, t_span, options, first, own)


def _scenes(scene: Any, q0: ArrayLike, v0: ArrayLike) -> list[Scene]:
    """Return scenes that are given one by one, or made by a function for each row."""
    if callable(scene):
        first = _made("scene(0)", scene(0))
        k = max(len(_states("q0", q0, first.n_dof)), len(_states("v0", v0, first.n_dof)))
        return [first, *(_made(f"scene({i})", scene(i)) for i in range(1, k))][:k]
    try:
        scenes = list(scene)
    except TypeError:
        message = f"scene is {shown(scene)}, but a Scene, a sequence of them or a callable is needed"
        raise TypeError(message) from None
    return [_made(f"scene[{i}]", one) for i, one in enumerate(scenes)]


def _made(argument: str, scene: Any) -> Scene:
    if not isinstance(scene, Scene):
        message = f"{argument} is {shown(scene)}, but a Scene is needed"
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


def _in_pieces(scene: Scene | list[Scene], q0: ArrayLike, v0: ArrayLike, workers: pool.Workers) -> list[tuple[Any, ...]]:
    """Cut scenes and states into pieces: their scenes, unless all share one, rows, and the number of the first."""
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

    def scenes(i: int, j: int) -> list[Scene] | None:
        return scene[i:j] if isinstance(scene, list) else None

    return [(scenes(i, j), *(part(rows, i, j) for rows in states), i) for i, j in pool.cut(k, workers)]


def simulate_many(
    scene: Scene | Sequence[Scene] | Callable[[int], Scene],
    q0: ArrayLike,
    v0: ArrayLike,
    t_span: tuple[float, float],
    *,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float | None = None,
    t_eval: ArrayLike | None = None,
    keep: str = "final",
    max_impacts: int | None = None,
    ramp: Ramp | Sequence[Ramp] | None = None,
    workers: pool.Workers = None,
    progress: bool = False,
) -> Ensemble:
    """Simulate one scene from many states, or many scenes; the same bits as one by one.

    Parameters
    ----------
    scene : Scene, sequence of Scene, or callable
        One for all; one each, all of n degrees of freedom; or ``i -> Scene`` for the i-th row of ``q0``. Pendulums with stops
        and walls that share a scene run four or eight abreast.
    q0, v0 : array_like, shape (k, n), or (n,) for all
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
        Final states, in constant memory for each trajectory, or their impacts and contacts too.
    workers : int, Executor or callable, optional
        Threads (default: every core), a ``concurrent.futures.Executor``, or a map-like callable. A piece that fails, or
        Ctrl-C, cancels those of an executor that wait.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    Ensemble
        ``q``, ``v`` (k, n), or (k, m, n) with ``t_eval``; ``n_impacts``, ``status`` (k,); ``impacts``, ``contacts``. A start
        inside a stop has the status "inside_stop" and its state as given; the others run.

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
    options = {
        "method": method,
        "rtol": rtol,
        "atol": atol,
        "t_eval": t_eval,
        "keep": keep,
        "max_impacts": max_impacts,
        "ramp": ramp,
    }
    pieces = _in_pieces(scene, q0, v0, workers) if pool.is_elsewhere(workers) else [(scene, q0, v0, 0)]
    shared = (scene if isinstance(scene, Scene) else None, t_span, options)
    parts = pool.run(_rows, shared, pieces, workers, progress=progress)
    return Ensemble.joined(parts, **({} if keep == "impacts" else {"impacts": None, "contacts": None}))

"""Attractors: what the motions of a scene settle on, found from many starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import Scene
from vibroimpact._validation import shown
from vibroimpact.results.attractors import Attractor, Attractors
from vibroimpact.run import pool

__all__ = ["find_attractors"]


def _settled(shared: tuple[Any, ...], starts: NDArray[np.float64], own: pool.Own) -> list[Any]:
    scene, sides, angles, options = shared
    return _core._settle_seeds(scene, sides, angles, starts, options, own)


def find_attractors(
    scene: Scene,
    box: ArrayLike,
    *,
    seeds: int | ArrayLike = 200,
    phase: float = 0.0,
    longest_period: int = 32,
    transient: int = 200,
    max_periods: int = 2000,
    rng: int | np.random.Generator = 0,
    wrap: Mapping[int, float] | None = None,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float | None = None,
    workers: pool.Workers = None,
    progress: bool = False,
) -> Attractors:
    """Find what the motions of a scene settle on, from many starts.

    Each start is followed until it repeats itself, looked at where no impact is near; its orbit is then closed by ``find_orbit``.
    What does not repeat itself in ``max_periods`` is told by its Lyapunov exponents. Two motions are on one attractor if their
    points are the same, or, of sets, if the neighbours of each point are of both motions (theory 15 and 17).

    Parameters
    ----------
    scene : Scene
        A scene whose forcing has a period.
    box : array_like, shape (2n, 2)
        Low and high of each position [m], then of each velocity [m/s].
    seeds : int or array_like, shape (k, 2n), default 200
        How many random states of the box are tried, or the states.
    phase : float, default 0.0
        The phase of the forcing [rad] at which motions begin and points are taken.
    longest_period : int, default 32
        The longest period that is looked for, in periods of the forcing, as far as ``max_periods`` goes.
    transient, max_periods : int, default 200 and 2000
        Periods that are left out, and after which a motion that has not settled is told by its exponents.
    rng : int or numpy.random.Generator, default 0
        What random states are drawn with.
    wrap : dict, optional
        Of positions that are angles the turn after which they are the same: ``{0: 2 * np.pi}``.
    method, rtol, atol
        As for ``simulate``.
    workers : int, Executor or callable, optional
        As for ``simulate_many``. The bits are the same with any.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    Attractors
        A sequence of ``Attractor``, the one that most starts led to first.

    Raises
    ------
    ValueError
        A box of another shape, upside down, not finite or without width; seeds of another shape or not finite; a scene without a
        forcing period; stops that relax (``release="force"`` with a dashpot), whose places states do not have; counts below what
        they must be.

    Notes
    -----
    A motion that repeats itself but for a constant advance drifts: it settles on nothing, and ``of_seed`` has -4.

    What is found depends on the starts: an attractor that none of them leads to is not. A motion that stays chaotic up to the end
    is called so; of one degree of freedom it may still come to rest on a stop later, and be periodic then. Without damping,
    motions that hit nothing are each an orbit of their own, which attracts nothing: starts on them are undecided.

    A scene that nothing drives is given a force of amplitude zero, whose period says when motions are looked at:
    ``vi.Harmonic([0.0], 1.0)``. What comes to rest is of the kind "rest".

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> found = vi.find_attractors(scene, [(-3, 1), (-5, 5)], seeds=40)
    >>> [(one.kind, one.n_periods) for one in found]
    [('periodic', 1), ('periodic', 3)]
    """
    sides = checked_box(scene, box)
    starts = _starts(scene, sides, seeds, rng)
    angles = turns(wrap)
    options: dict[str, Any] = {"phase": phase, "method": method, "rtol": rtol, "atol": atol}
    options |= {"longest_period": longest_period, "transient": transient, "max_periods": max_periods}
    pieces = [starts[i:j] for i, j in pool.cut(len(starts), workers)]
    parts = pool.run(_settled, (scene, sides, angles, options), pieces, workers, progress=progress)
    found = [one for part in parts for one in part]
    grouped = _core._group_attractors(scene, sides, angles, found, options)
    attractors = tuple(Attractor(**one) for one in grouped["all"])
    return Attractors(scene, attractors, starts, grouped["of_seed"], sides, float(phase), angles)


def turns(wrap: Mapping[int, float] | None) -> tuple[tuple[int, float], ...]:
    """Return the positions that are angles, and their turns."""
    if wrap is not None and not isinstance(wrap, Mapping):
        message = f"wrap is {shown(wrap)}, but a dict {{position: its turn}} is needed"
        raise TypeError(message)
    for position in wrap or {}:
        if isinstance(position, bool) or not isinstance(position, (int, np.integer)) or position < 0:
            message = f"wrap has the position {position!r}, but positions are counted from 0"
            raise ValueError(message)
    for position, turn in (wrap or {}).items():
        if not isinstance(turn, (int, float, np.integer, np.floating)):
            message = f"wrap[{position}] is {turn!r}, but a number is needed"
            raise TypeError(message)
    return tuple((int(position), float(turn)) for position, turn in (wrap or {}).items())


def _starts(
    scene: Scene, sides: NDArray[np.float64], seeds: int | ArrayLike, rng: int | np.random.Generator
) -> NDArray[np.float64]:
    """Return the states to begin from, drawn where a number is asked for."""
    if isinstance(seeds, bool) or not isinstance(seeds, (int, np.integer)):
        states = _core._numbers("seeds", seeds)
        if states.ndim != 2 or states.shape[1] != 2 * scene.n_dof:
            message = f"seeds has shape {states.shape}, but (k, {2 * scene.n_dof}) is needed, or a number of them"
            raise ValueError(message)
        return states
    if seeds < 0:
        message = f"seeds is {seeds}, but it must be at least 0, or states"
        raise ValueError(message)
    return drawn(scene, sides, int(seeds), rng)


def drawn(scene: Scene, sides: NDArray[np.float64], count: int, rng: int | np.random.Generator) -> NDArray[np.float64]:
    """Draw so many states of a box, one a row."""
    try:
        generator = np.random.default_rng(rng)
    except (TypeError, ValueError) as error:
        message = f"rng is {rng!r}, but it must be a number that is not negative, or a numpy.random.Generator: {error}"
        raise ValueError(message) from None
    parts = generator.random((count, len(sides)))
    return sides[:, 0] + parts * (sides[:, 1] - sides[:, 0])


def checked_box(scene: Scene, box: ArrayLike) -> NDArray[np.float64]:
    """Return a box of states as an array."""
    if not isinstance(scene, Scene):
        message = f"scene is {shown(scene)}, but a Scene is needed"
        raise TypeError(message)
    sides = _core._numbers("box", box)
    if sides.shape != (2 * scene.n_dof, 2):
        message = f"box has shape {sides.shape}, but ({2 * scene.n_dof}, 2) is needed"
        raise ValueError(message)
    widths = 0.5 * sides[:, 1] - 0.5 * sides[:, 0]
    if np.isfinite(sides).all() and (widths > 0.5 * np.finfo(np.float64).max).any():
        message = "box is wider than the largest number"
        raise ValueError(message)
    return sides

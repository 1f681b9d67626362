"""How large basins are in a box, by random states; along a number of the scene too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact._core import Scene
from vibroimpact._validation import shown
from vibroimpact.analysis import parameter_axis
from vibroimpact.analysis.attractor_labels import check_attractors, labelled, turns_of
from vibroimpact.analysis.find_attractors import checked_box, drawn, find_attractors
from vibroimpact.results.attractors import Attractor
from vibroimpact.results.basin_fractions import BasinFractions
from vibroimpact.results.basins import INSIDE, LOST, UNDECIDED
from vibroimpact.run import pool

__all__ = ["basin_fractions"]

#: Random states from which attractors are sought at each value.
_SEEDS = 200


def basin_fractions(
    scene: Scene,
    box: ArrayLike,
    *,
    samples: int = 10_000,
    axis: tuple[str, ArrayLike] | None = None,
    attractors: Sequence[Attractor] | None = None,
    phase: float = 0.0,
    max_periods: int = 2000,
    rng: int | np.random.Generator = 0,
    wrap: Mapping[int, float] | None = None,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float | None = None,
    workers: pool.Workers = None,
    progress: bool = False,
) -> BasinFractions:
    """Say how large basins are in a box, by random states.

    Parameters
    ----------
    scene : Scene
        A scene whose forcing has a period.
    box : array_like, shape (2n, 2)
        Low and high of each position [m], then of each velocity [m/s].
    samples : int, default 10000
        Random states; the same at every value.
    axis : (str, array_like), optional
        A name of ``Scene.replace`` and its m values. The attractors are found at each value, from random states of the box and
        from where those of the value before have their points, and matched to these: first by pattern and period, then by
        distance.
    attractors : sequence of Attractor, optional
        As ``find_attractors`` finds them; without, it is called first. Not with ``axis``.
    phase, max_periods, wrap, method, rtol, atol, workers, progress
        As for ``basins``.
    rng : int or numpy.random.Generator, default 0
        What random states are drawn with.

    Returns
    -------
    BasinFractions
        Fractions with their standard errors ``sqrt(f (1 - f) / samples)``.

    Raises
    ------
    ValueError
        As ``basins``; ``samples`` below 1; attractors together with an axis.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> vi.basin_fractions(scene, [(-3, 1), (-5, 5)], samples=400).fractions.sum().round(12)
    np.float64(1.0)
    """
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 1:
        message = f"samples is {shown(samples)}, but it must be at least 1"
        raise ValueError(message)
    sides = checked_box(scene, box)
    states = drawn(scene, sides, int(samples), rng)
    engine = {"workers": workers, "progress": progress}
    search = {"phase": phase, "wrap": wrap, "method": method, "rtol": rtol, "atol": atol, **engine}
    options = {"phase": float(phase), "max_periods": max_periods, "hits": None, "method": method, "rtol": rtol, "atol": atol}
    turns = turns_of(wrap, attractors)

    def measured(own: Scene, found: Sequence[Attractor]) -> NDArray[np.int16]:
        shared = (own, tuple(found), sides, turns, options)
        pieces = [(states[i:j], np.full(j - i, float(phase))) for i, j in pool.cut(samples, workers)]
        return np.concatenate([part["labels"] for part in pool.run(labelled, shared, pieces, workers, progress=progress)])

    if axis is None:
        if attractors is None:
            attractors = find_attractors(scene, sides, **search)  # type: ignore[arg-type]
        check_attractors(scene, attractors, phase)
        fractions, errors, undecided = _fractions(measured(scene, attractors), len(attractors))
        return BasinFractions(fractions, errors, np.array(undecided), tuple(attractors), None, None)
    if attractors is not None:
        message = "attractors are given with an axis, but along it they are found at each value"
        raise ValueError(message)
    name, values = parameter_axis.named(axis, "axis")
    columns: list[Attractor] = []
    rows = []
    scenes = [_replaced(scene, name, value) for value in values.tolist()]
    for own in scenes:
        before = [one.points[:1] for one in columns]
        seeds = np.vstack([*before, drawn(scene, sides, _SEEDS, rng)])
        found = find_attractors(own, sides, seeds=seeds, **search)  # type: ignore[arg-type]
        places = _matched(found, columns, sides)
        rows.append((_fractions(measured(own, found), len(found)), places, tuple(found)))
    width = len(columns)
    fractions, errors = np.zeros((len(values), width)), np.zeros((len(values), width))
    for i, ((own_fractions, own_errors, _), places, _) in enumerate(rows):
        fractions[i, places], errors[i, places] = own_fractions, own_errors
    undecided_rows = np.array([row[0][2] for row in rows])
    return BasinFractions(fractions, errors, undecided_rows, tuple(row[2] for row in rows), name, values)


def _replaced(scene: Scene, name: str, value: float) -> Scene:
    try:
        return scene.replace(**{name: value})
    except (TypeError, ValueError) as error:
        message = f"axis: {error}"
        raise ValueError(message) from None


def _fractions(labels: NDArray[np.int16], count: int) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the part of the states outside every stop of each label, its error, and the part of none."""
    outside = max(int((labels != INSIDE).sum()), 1)
    fractions = np.array([(labels == k + 1).sum() / outside for k in range(count)], dtype=np.float64)
    undecided = float(((labels == UNDECIDED) | (labels == LOST)).sum() / outside)
    return fractions, np.sqrt(fractions * (1.0 - fractions) / outside), undecided


def _matched(found: Sequence[Attractor], columns: list[Attractor], sides: NDArray[np.float64]) -> list[int]:
    """Return the column of each attractor: that of the last one like it, or a new one."""
    widths = np.where(sides[:, 1] > sides[:, 0], sides[:, 1] - sides[:, 0], 1.0)

    def distance(a: Attractor, b: Attractor) -> float:
        apart = np.abs(a.points[:, None, :] - b.points[None, :, :]) / widths
        return float(apart.max(axis=2).min())

    free = set(range(len(columns)))
    places: list[int] = []
    for one in found:
        like = [
            k
            for k in free
            if (columns[k].kind, columns[k].n_periods, columns[k].pattern) == (one.kind, one.n_periods, one.pattern)
        ]
        near = [k for k in free if distance(one, columns[k]) < 0.1]
        candidates = like or near
        if candidates:
            place = min(candidates, key=lambda k: distance(one, columns[k]))
            free.discard(place)
            columns[place] = one
        else:
            place = len(columns)
            columns.append(one)
        places.append(place)
    return places

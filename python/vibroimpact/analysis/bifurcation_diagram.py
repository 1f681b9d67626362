"""Poincare sections, and bifurcation diagrams: what a motion settles on, over the values of a number of its scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene, Trajectory
from vibroimpact._validation import shown
from vibroimpact.analysis import parameter_axis
from vibroimpact.results.diagram import BifurcationDiagram, PoincarePoints
from vibroimpact.run import pool

__all__ = ["bifurcation_diagram", "poincare_points"]

Pattern = list[int | tuple[int, ...]]


def poincare_points(
    motion: Trajectory | Orbit,
    *,
    phase: float | None = None,
    stops: int | Sequence[int] | None = None,
    plane: tuple[ArrayLike, float] | None = None,
) -> PoincarePoints:
    """Look at a motion at a phase of the forcing, after its impacts, or where it passes through a plane of its states.

    Parameters
    ----------
    motion : Trajectory or Orbit
        A trajectory that keeps its motion, or one period of an orbit.
    phase : float, optional
        The phase [rad].
    stops : int or sequence of int, optional
        Look after the impacts on these stops, of stops that give way where contacts begin; without ``phase``, ``stops`` and
        ``plane``, after all. Impacts that accumulate until a stop is at rest are one, at their end.
    plane : (array_like, float), shape (2n,) and a number, optional
        A row and a value: look where ``row @ (q, v)`` rises through the value, at an impact too. None is missed: on each arc of
        the motion the quantity is followed by polynomials to its rounding, which have all their roots found.

    Returns
    -------
    PoincarePoints
        Times, stops, speeds, phases and states.

    Raises
    ------
    ValueError
        Several of them; a stop that the scene does not have; a phase without a forcing period, or along ramps; a row of another
        length than 2n, or of zeros; a trajectory that does not keep its motion.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> orbit = vi.periodic_orbits(vi.paper_scene(kind=3), [1], n_periods=2)[0]
    >>> vi.poincare_points(orbit, phase=0.0)
    PoincarePoints(2 points of 2 coordinates, 0 of them after impacts)
    >>> vi.poincare_points(orbit, plane=([0, 0, 0, 1], 0.0))  # where the lower pendulum turns back
    PoincarePoints(3 points of 2 coordinates, 0 of them after impacts)
    """
    return PoincarePoints(**_core._poincare_points(motion, phase, stops, plane))


def _part(shared: tuple[Any, ...], piece: tuple[Any, str, NDArray[np.float64]], own: pool.Own) -> dict[str, Any]:
    scene, name, options = shared
    made, way, values = piece
    return _core._bifurcation_diagram(scene if made is None else made, name, values, options | {"direction": way}, own)


def bifurcation_diagram(
    scene: Scene | Callable[[float], Scene],
    axis: tuple[str, ArrayLike] | ArrayLike,
    *,
    direction: str = "up",
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    transient: int = 200,
    periods: int = 50,
    section: str = "phase",
    phase: float = 0.0,
    stops: int | Sequence[int] | None = None,
    carry: bool = True,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float | None = None,
    workers: pool.Workers = None,
    progress: bool = False,
) -> BifurcationDiagram:
    """Follow a motion over the values of a number of its scene, its transients left out.

    Parameters
    ----------
    scene : Scene or callable
        A scene, or ``value -> Scene``, called for all values before anything is simulated.
    axis : (str, array_like) or array_like, shape (m,)
        A name of ``Scene.replace`` as for ``existence_map`` and its values, in any order; for a callable the values alone.
    direction : {"up", "down", "both"}, default "up"
        From the smallest value up, from the largest down, or up and then down.
    q0, v0 : array_like, shape (n,), optional
        Where the first value begins, and without ``carry`` each: default at rest at zero. What lies behind a stop is put onto it.
    transient, periods : int, default 200 and 50
        Periods of the forcing that are left out at each value, and that are looked at; of a scene without such a period impacts
        on ``stops``. Where none comes for long (some thousand turns), there are fewer.
    section : {"phase", "impact"}, default "phase"
        Whether the motion is looked at once in each period, at ``phase``, or after the impacts on ``stops``, of stops that give
        way where contacts begin; "impact" alone where the forcing has no period.
    phase : float, default 0.0
        The phase of the forcing [rad].
    stops : int or sequence of int, optional
        Default all.
    carry : bool, default True
        Whether the motion goes on from value to value. A state behind a stop that has moved is put onto it.
    method, rtol, atol
        As for ``simulate``.
    workers : int, Executor or callable, optional
        As for ``simulate_many``: both directions side by side, without ``carry`` all values. The bits are the same with any.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    BifurcationDiagram
        The points, and of each value the period and the pattern.

    Raises
    ------
    ValueError
        No values, values that are not finite or may not be taken, a name that does not exist, ``section="phase"`` of a scene
        without a forcing period.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> vi.bifurcation_diagram(scene, ("forcing_scale", [3.0, 9.0]), transient=500, section="impact")
    BifurcationDiagram(forcing_scale, 2 values: 2 of period 1; 50 points)
    """
    if callable(scene):
        name, values = None, parameter_axis.grid(axis, "axis")  # type: ignore[arg-type]
    else:
        name, values = parameter_axis.named(axis, "axis")
    ways = {"up": ["up"], "down": ["down"], "both": ["up", "down"]}.get(direction, [direction])
    options = {"q0": q0, "v0": v0, "transient": transient, "periods": periods, "section": section, "phase": phase}
    options |= {"stops": stops, "carry": carry, "method": method, "rtol": rtol, "atol": atol}

    def made(own: NDArray[np.float64]) -> Any:
        return [_scene(scene, float(value)) for value in own] if callable(scene) else None

    cuts = [(direction, values)]
    if pool.is_elsewhere(workers):
        ordered = np.sort(values)
        bounds = [(0, values.size)] if carry else pool.cut(values.size, workers)
        cuts = [(way, ordered[i:j]) for way in ways for i, j in (bounds if way == "up" else bounds[::-1])]
    pieces = [(made(own), way, own) for way, own in cuts]
    shared = (None if callable(scene) else scene, name, options)
    parts = pool.run(_part, shared, pieces, workers, progress=progress)
    before = np.cumsum([0] + [len(part["parameter"]) for part in parts])
    for part, first in zip(parts, before[:-1].tolist(), strict=True):
        part["index"] += first
    return BifurcationDiagram.joined(parts, name=name)


def _scene(make: Callable[[float], Scene], value: float) -> Scene:
    scene = make(value)
    if not isinstance(scene, Scene):
        message = f"scene({shown(value)}) is {shown(scene)}, but a Scene is needed"
        raise TypeError(message)
    return scene

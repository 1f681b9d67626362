"""Basins: which states of a scene lead to which of its attractors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact._core import Scene
from vibroimpact.analysis import state_plane
from vibroimpact.analysis.attractor_labels import check_attractors, labelled, turns_of
from vibroimpact.analysis.find_attractors import checked_box, find_attractors
from vibroimpact.analysis.state_plane import Plane
from vibroimpact.analysis.stored_attractors import with_scene, without_scene
from vibroimpact.results.attractors import Attractor, Attractors
from vibroimpact.results.basins import OPEN, Basins
from vibroimpact.run import pool
from vibroimpact.run.store import STORED_RESULTS, Restored, Store, check_axes, check_options
from vibroimpact.run.stored_arguments import decode
from vibroimpact.run.tiled_work import Columns, worked_out
from vibroimpact.run.tiles import Tile

__all__ = ["basins"]

COLUMNS: Columns = {"iterations": ("i4", 0), "labels": ("i2", OPEN)}


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
    wrap: Mapping[int, float] | None = None,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float | None = None,
    workers: pool.Workers = None,
    store: Any = None,
    overwrite: bool = False,
    key: str | None = None,
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
        Of each coordinate an axis or a number: a tuple of low, high and the number of cells between, of which the midpoints are
        taken, or a list of values: ``q={0: (-1, 1, 200), 1: 0.2}``; of one degree of freedom the axis alone. Two vary, the
        first is x.
    phase : float, default 0.0
        The phase of the forcing [rad] at which the motions begin.
    impact : dict, optional
        In place of q and v, of one degree of freedom: states right after an impact, ``{"stop": 0, "phase": axis, "speed":
        axis}``, with speeds of 0 or more; of a stop that gives way at the beginning of a contact.
    attractors : sequence of Attractor, optional
        As ``find_attractors`` finds them at this phase; without, it is called with the box first.
    box : array_like, shape (2n, 2), optional
        Low and high of each coordinate, by which distances are measured and attractors are sought; default that of the
        attractors, or of the plane.
    hits : int, optional
        Periods for which a motion must follow an attractor; default three of an orbit's own, 20 of a set.
    max_periods : int, default 2000
        Periods after which a state is left undecided.
    wrap : dict, optional
        Of positions that are angles the turn after which they are the same: ``{0: 2 * np.pi}``; default that of the attractors.
    method, rtol, atol
        As for ``simulate``.
    workers : int, Executor or callable, optional
        As for ``simulate_many``. The bits are the same with any.
    store, overwrite, key
        As for ``existence_map``; functions of the scene are told from others as the callable is there.
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
        one degree of freedom; a scene without a forcing period; stops that relax (``release="force"`` with a dashpot), whose
        places no plane of states has; attractors of another scene; a store that is a file, has
        something else in it, or was made with other arguments or other code, or, without a key, a function with a part that
        cannot be looked through.
    OSError
        A store that cannot be written. What it had before is kept.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> found = vi.basins(scene, q=(-3, 1, 20), v=(-5, 5, 20))
    >>> found.labels.shape, [one.n_periods for one in found.attractors]
    ((20, 20), [3, 1])
    """
    check_options(overwrite, key)
    if hits is not None and (isinstance(hits, bool) or not isinstance(hits, (int, np.integer))):
        message = f"hits is {hits!r}, but a whole number is needed"
        raise TypeError(message)
    if impact is not None and (q is not None or v is not None):
        message = "impact is given with q or v, but states are given by one of them"
        raise ValueError(message)
    plane = (
        state_plane.after_impact(scene, impact) if impact is not None else state_plane.of_coordinates(scene, q, v, float(phase))
    )
    around = _box(scene, box, attractors, plane if impact is None else None)
    options = {"phase": float(phase), "max_periods": max_periods, "hits": hits, "method": method, "rtol": rtol, "atol": atol}
    if attractors is not None:
        check_attractors(scene, attractors, phase)
    angles = turns_of(wrap, attractors)
    nothing = np.empty((0, 2 * scene.n_dof)), np.empty(0)
    labelled((scene, tuple(attractors or ()), around, angles, options), nothing, (1, False, None))  # refuses what may not be
    kept = None
    if store is not None:
        arguments = {
            "scene": scene,
            "plane": [getattr(plane, own.name) for own in fields(plane)],
            "phase": float(phase),
            "attractors": None if attractors is None else without_scene(attractors),
            "box": around,
            "hits": hits,
            "wrap": angles,
            "max_periods": max_periods,
            "method": method,
            "rtol": float(rtol),
            "atol": None if atol is None else float(atol),
        }
        kept = Store(store, "Basins", arguments, {"x": plane.x, "y": plane.y}, COLUMNS, overwrite=overwrite, key=key)
    if attractors is None and kept is not None and (known := kept.kept("attractors")) is not None:
        attractors = with_scene(known, scene)
    if attractors is None:
        engine = {"workers": workers, "progress": progress}
        search = {"phase": phase, "wrap": wrap, "method": method, "rtol": rtol, "atol": atol, **engine}
        attractors = find_attractors(scene, around, **search)  # type: ignore[arg-type]
        if kept is not None:
            kept.keep("attractors", without_scene(attractors))
    shared = (plane, scene, tuple(attractors), around, angles, options)
    shape, pieces = (plane.y.size, plane.x.size), pool.count(workers)
    found = worked_out(_tile, shared, shape, COLUMNS, pieces, workers, progress, kept)
    own = attractors if isinstance(attractors, Attractors) else tuple(attractors)
    return Basins(found["labels"], found["iterations"], plane.x, plane.y, plane.x_name, plane.y_name, own)


def _tile(shared: tuple[Any, ...], tile: Tile, own: pool.Own) -> dict[str, NDArray[Any]]:
    plane, *rest = shared
    return labelled(tuple(rest), plane.starts(tile), own)


def _box(scene: Scene, box: ArrayLike | None, attractors: Sequence[Attractor] | None, plane: Plane | None) -> NDArray[np.float64]:
    """Return the box by which distances are measured."""
    if box is not None:
        return checked_box(scene, box)
    if isinstance(attractors, Attractors):
        return attractors.box
    if plane is None:
        message = (
            "box is not given, but with impact= it, or attractors of find_attractors, must say by what distances are measured"
        )
        raise ValueError(message)
    return plane.box


def from_store(contents: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Basins:
    """Return the basins that a store holds, finished or not."""
    arguments = contents["arguments"]
    known = decode(contents["attractors"] if "attractors" in contents else arguments["attractors"])
    attractors = () if known is None else with_scene(known, decode(arguments["scene"]))
    x_name, y_name, x, y = decode(arguments["plane"])[:4]
    check_axes(arrays, x, y)
    return Basins(x_name=x_name, y_name=y_name, attractors=attractors, **arrays)


STORED_RESULTS["Basins"] = Restored(COLUMNS, from_store)

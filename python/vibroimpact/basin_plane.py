"""Basins: which states of a scene lead to which of its attractors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _boundary, _html, _plane, _workers
from vibroimpact._boundary import Fit
from vibroimpact._cells import Columns, worked_out
from vibroimpact._core import Scene
from vibroimpact._kept import with_scene, without_scene
from vibroimpact._labels import INSIDE, LOST, OPEN, UNDECIDED, check_attractors, labelled, seen, turns_of
from vibroimpact._plane import Plane
from vibroimpact._results import ArrayResult
from vibroimpact._store import Store, check_axes, check_options
from vibroimpact._tiles import Tile
from vibroimpact._told import untold
from vibroimpact.attractors import Attractor, Attractors, check_all, checked_box, find_attractors

__all__ = ["Basins", "Fit", "basins"]

COLUMNS: Columns = {"iterations": ("i4", 0), "labels": ("i2", OPEN)}


_LEFT = {"lost": LOST, "inside a stop": INSIDE, "not worked out yet": OPEN}


@dataclass(frozen=True, eq=False)
class Basins(ArrayResult):
    """Which states of a plane lead to which attractor: ny x nx cells.

    Attributes
    ----------
    labels : ndarray of int16, shape (ny, nx)
        k + 1 where a state leads to ``attractors[k]``; 0 undecided, -1 lost, -2 inside a stop, -3 not worked out yet.
    iterations : ndarray of int32, shape (ny, nx)
        Periods of the forcing until it was decided.
    x, y : ndarray, shape (nx,) and (ny,)
        The states: values of ``x_name`` and ``y_name`` [m, m/s or rad].
    x_name, y_name : str
        What they are, such as "q[0]", "v[0]", "phase", "speed".
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
        """The part of the cells worked out, outside every stop, that leads to each attractor [-], shape (k,)."""
        outside = max(int(((self.labels != INSIDE) & (self.labels != OPEN)).sum()), 1)
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

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        return _html.basins(self)

    def __repr__(self) -> str:
        """Say how large the basins are, and what to do about states that were not decided."""
        parts = [f"{fraction:.3g}" for fraction in self.fractions]
        left = [(name, int((self.labels == label).sum())) for name, label in _LEFT.items()]
        others = "".join(f", {count} {name}" for name, count in left if count)
        undecided = int((self.labels == UNDECIDED).sum())
        remedy = ""
        if undecided:
            remedy = f", {undecided} undecided: more max_periods, or find_attractors with these states as seeds"
        plane = f"{self.x_name} x {self.y_name}, {self.labels.shape[1]} x {self.labels.shape[0]}"
        return f"Basins({plane}: fractions [{', '.join(parts)}]{others}{remedy})"


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
    workers: _workers.Workers = None,
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
        axis}``, with speeds of 0 or more.
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
    store : str, path-like or store of zarr, optional
        A folder (needs zarr) into which cells are written while they are worked out. The same call goes on where one was broken
        off, with the same bits; ``load`` opens what is there. Functions of the scene are told from others by their code, values
        and attributes, and by those of all that they read and call outside of libraries; objects by what pickle keeps of them,
        so that what a call changes in them can be left out by ``__getstate__``.
    overwrite : bool, default False
        Whether a store that other arguments have made is replaced; one that the same have made is gone on with.
    key : str, optional
        A text that stands for code that a store cannot look through, as functions compiled from C: another code, another key.
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
        one degree of freedom; a scene without a forcing period; attractors of another scene; a store that is a file, has
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
    plane = _plane.after_impact(scene, impact) if impact is not None else _plane.of_coordinates(scene, q, v, float(phase))
    around = _box(scene, box, attractors, plane if impact is None else None)
    options = (float(phase), max_periods, hits, method, rtol, atol)
    if attractors is not None:
        check_attractors(scene, attractors, phase)
    angles = turns_of(wrap, attractors)
    nothing = np.empty((0, 2 * scene.n_dof)), np.empty(0)
    labelled((scene, seen(attractors or ()), around, angles, options), nothing, (1, False, None))  # refuses what may not be
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
    shared = (plane, scene, seen(attractors), around, angles, options)
    shape, pieces = (plane.y.size, plane.x.size), _workers.count(workers)
    found = worked_out(_tile, shared, shape, COLUMNS, pieces, workers, progress, kept)
    own = attractors if isinstance(attractors, Attractors) else tuple(attractors)
    return Basins(found["labels"], found["iterations"], plane.x, plane.y, plane.x_name, plane.y_name, own)


def _tile(shared: tuple[Any, ...], tile: Tile, own: _workers.Own) -> tuple[NDArray[np.int32], NDArray[np.int16]]:
    plane, *rest = shared
    labels, iterations = labelled(tuple(rest), plane.starts(tile), own)
    return iterations, labels


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
    known = untold(contents["attractors"] if "attractors" in contents else arguments["attractors"])
    attractors = () if known is None else with_scene(known, untold(arguments["scene"]))
    x_name, y_name, x, y = untold(arguments["plane"])[:4]
    check_axes(arrays, x, y)
    return Basins(x_name=x_name, y_name=y_name, attractors=attractors, **arrays)

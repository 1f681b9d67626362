"""Attractors: what the motions of a scene settle on, found from many starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core, _workers
from vibroimpact._core import Orbit, Scene
from vibroimpact._numbers import shown
from vibroimpact._results import ArrayResult, ItemsResult
from vibroimpact.diagram import Pattern

__all__ = ["Attractor", "Attractors", "find_attractors"]


@dataclass(frozen=True, eq=False)
class Attractor(ArrayResult):
    """An attractor of a scene of n degrees of freedom.

    Attributes
    ----------
    kind : {"periodic", "torus", "chaotic", "rest"}
        What it is.
    orbit : Orbit or None
        The orbit; None of what does not repeat itself, and of what Newton's method does not close.
    n_periods : int
        Periods of the forcing in one of its own; 0 of what does not repeat itself.
    points : ndarray, shape (p, 2n)
        Its states (q, v) [m, m/s] at the phase, one after the other; of what does not repeat itself a thousand. A thousand, or
        one less, too of what comes to rest on a stop once in a period so long that rounding decides where it is in between.
    exponents : ndarray, shape (2n,)
        Its Lyapunov exponents [1/s]; empty where an orbit has no multipliers.
    pattern : list
        The stops hit in one of its periods, a tuple at one instant; empty where it has none.
    reason : str
        Why it has no orbit; empty where it has.
    fraction : float
        The part of the starts outside every stop that led to it [-].
    """

    kind: str
    orbit: Orbit | None
    n_periods: int
    points: NDArray[np.float64]
    exponents: NDArray[np.float64]
    pattern: Pattern
    reason: str
    fraction: float

    def __post_init__(self) -> None:
        """Refuse arrays that are none of an attractor."""
        self._check_types(
            {"kind": str, "orbit": (Orbit, type(None)), "n_periods": int, "pattern": list, "reason": str, "fraction": float}
        )
        self._check({"points": ("f", np.shape(self.points)[:2]), "exponents": ("f", np.shape(self.exponents)[:1])})

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its arrays, for ``numpy.savez``."""
        return {"points": self.points, "exponents": self.exponents}

    def __repr__(self) -> str:
        """Say what it is."""
        period = f", {self.n_periods} periods" if self.n_periods else ""
        hits = f", pattern {self.pattern}" if self.pattern else ""
        return f"Attractor({self.kind}{period}{hits}, {self.fraction:.3g} of the seeds)"


@dataclass(frozen=True, eq=False)
class Attractors(ItemsResult[Attractor]):
    """The attractors of a scene that were found, the one that most starts led to first: a sequence of them.

    Attributes
    ----------
    all : tuple of Attractor
        The attractors.
    seeds : ndarray, shape (k, 2n)
        The starts (q, v) [m, m/s].
    of_seed : ndarray of int, shape (k,)
        Of each start the place of its attractor; -1: undecided, -2: lost, -3: inside a stop, -4: drifting, which is to repeat
        itself but for a constant advance.
    box : ndarray, shape (2n, 2)
        Low and high of each position [m], then of each velocity [m/s].
    phase : float
        The phase of the forcing [rad] at which motions began and points were taken.
    wrap : tuple of (int, float)
        The positions that are angles, and the turn of each.
    scene : Scene
        The scene.
    """

    scene: Scene
    all: tuple[Attractor, ...]
    seeds: NDArray[np.float64]
    of_seed: NDArray[np.int64]
    box: NDArray[np.float64]
    phase: float
    wrap: tuple[tuple[int, float], ...] = ()

    def __post_init__(self) -> None:
        """Refuse arrays that are none of one search; a list of attractors becomes a tuple."""
        object.__setattr__(self, "all", tuple(self.all))
        object.__setattr__(self, "wrap", tuple((int(position), float(turn)) for position, turn in self.wrap))
        self._check_types({"scene": Scene, "phase": float})
        check_all(self.all)
        k, width = np.shape(self.seeds)[:1], (2 * self.scene.n_dof,)
        self._check({"seeds": ("f", k + width), "of_seed": ("i", k), "box": ("f", (*width, 2))})

    def _items(self) -> tuple[Attractor, ...]:
        return self.all

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the search, for ``numpy.savez``."""
        return {"seeds": self.seeds, "of_seed": self.of_seed, "box": self.box}

    def __repr__(self) -> str:
        """List the attractors, and the starts that led to none."""
        left = [(name, int((self.of_seed == code).sum())) for name, code in _LEFT.items()]
        others = "".join(f", {count} {name}" for name, count in left if count)
        return f"Attractors({len(self.seeds)} seeds{others}: [{', '.join(map(repr, self.all))}])"


def check_all(attractors: Sequence[Any]) -> None:
    """Refuse what is no attractor among others."""
    for k, one in enumerate(attractors):
        if not isinstance(one, Attractor):
            message = f"attractors[{k}] is {shown(one)}, but an Attractor is needed"
            raise TypeError(message)


#: Starts that led to no attractor, as `of_seed` has them.
_LEFT = {"undecided": -1, "lost": -2, "inside": -3, "drifting": -4}


def _settled(shared: tuple[Any, ...], starts: NDArray[np.float64], own: _workers.Own) -> list[Any]:
    scene, sides, angles, *rest = shared
    arguments: tuple[Any, ...] = (scene, sides, angles, starts, *rest, *own)
    return _core._settle_seeds(*arguments)


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
    workers: _workers.Workers = None,
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
        forcing period; counts below what they must be.

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
    rest = (phase, longest_period, transient, max_periods, method, rtol, atol)
    pieces = [starts[i:j] for i, j in _workers.cut(len(starts), workers)]
    parts = _workers.run(_settled, (scene, sides, angles, *rest), pieces, workers, progress=progress)
    found = [one for part in parts for one in part]
    places, attractors = _core._group_attractors(scene, sides, angles, found, *rest)
    of_seed = np.array(places, dtype=np.int64)
    outside = max(int((of_seed != _LEFT["inside"]).sum()), 1)
    all_found = tuple(_attractor(one, float((of_seed == k).sum() / outside)) for k, one in enumerate(attractors))
    return Attractors(scene, all_found, starts, of_seed, sides, float(phase), angles)


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


def _attractor(parts: tuple[Any, ...], fraction: float) -> Attractor:
    kind, orbit, n_periods, points, exponents, pattern, reason = parts
    return Attractor(kind, orbit, n_periods, points, exponents, pattern, reason, fraction)


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

"""Attractors: what the motions of a scene settle on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import shown
from vibroimpact.results.diagram import Pattern
from vibroimpact.results.labelled import Parts
from vibroimpact.results.record import ItemsRecord, Record, array

#: Starts that led to no attractor, as `of_seed` has them.
LEFT = {"undecided": -1, "lost": -2, "inside": -3, "drifting": -4}


class Attractor(Record):
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
        Its states (q, v) [m, m/s] at the phase, one after the other; of what does not repeat itself a thousand. Of what
        repeats itself because it comes to rest on a stop, while rounding decides where it is in between, a thousand too, or one
        less if that is its period.
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
    points: NDArray[np.float64] = array("point state")
    exponents: NDArray[np.float64] = array("exponent", unit="1/s")
    pattern: Pattern
    reason: str
    fraction: float

    def __repr__(self) -> str:
        """Say what it is."""
        period = f", {self.n_periods} periods" if self.n_periods else ""
        hits = f", pattern {self.pattern}" if self.pattern else ""
        return f"Attractor({self.kind}{period}{hits}, {self.fraction:.3g} of the seeds)"


class Attractors(ItemsRecord[Attractor]):
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
    seeds: NDArray[np.float64] = array("seed state")
    of_seed: NDArray[np.int64] = array("seed")
    box: NDArray[np.float64] = array("state side")
    phase: float
    wrap: tuple[tuple[int, float], ...] = ()

    def _prepare(self) -> None:
        self._set("all", tuple(self.all))
        self._set("wrap", tuple((int(position), float(turn)) for position, turn in self.wrap))
        check_all(self.all)

    def _sizes(self) -> dict[str, int]:
        return {"state": 2 * self.scene.n_dof, "side": 2}

    def _items(self) -> tuple[Attractor, ...]:
        return self.all

    def _labelled(self) -> Parts:
        variables, coordinates, attributes = super()._labelled()
        columns = {name: ("attractor", [getattr(one, name) for one in self]) for name in ("kind", "n_periods", "fraction")}
        columns["pattern"] = ("attractor", [str(one.pattern) for one in self])
        return variables | columns, coordinates, attributes

    def __repr__(self) -> str:
        """List the attractors, and the starts that led to none."""
        left = [(name, int((self.of_seed == code).sum())) for name, code in LEFT.items()]
        others = "".join(f", {count} {name}" for name, count in left if count)
        return f"Attractors({len(self.seeds)} seeds{others}: [{', '.join(map(repr, self.all))}])"


def check_all(attractors: Sequence[Any]) -> None:
    """Refuse what is no attractor among others."""
    for k, one in enumerate(attractors):
        if not isinstance(one, Attractor):
            message = f"attractors[{k}] is {shown(one)}, but an Attractor is needed"
            raise TypeError(message)

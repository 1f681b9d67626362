"""Contacts in many digits: the search of the references, for any flow that knows its states.

A flow makes pieces: spans of time on which states are known, in doubles for the search and in many digits for the result. On
each piece every gap is sampled finely; a change of sign, or a sampled minimum that falls below zero between its neighbours,
brackets a contact, which is then found in many digits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from mpmath import mp

from .equations import Equations, equations
from .problems import Problem

DIGITS = 80
SOON = 1e-4  # of the quickest time of a piece: a return to the stop within that is found by Newton's method from the parabola
CLOSE_END = 1e-2  # time until which a return to the stop is looked for in many digits, short for every oscillation here
CLOSE = 1.3  # ratio of the times at which a return to the stop is looked for in many digits


class Piece(Protocol):
    """A span of a flight, from its start in time; `quickest` is the shortest time in which its motion changes."""

    start: Any
    length: Any
    quickest: float

    def grid(self) -> np.ndarray:
        """Times at which the gaps are sampled."""
        ...

    def positions(self, s: np.ndarray) -> np.ndarray:
        """Positions in doubles, (m, n)."""
        ...

    def state(self, s: Any) -> list[Any]:
        """Positions and velocities in many digits."""
        ...


#: Makes the pieces of the flight from (t, x), one after another, each from the end of the one before.
Flow = Callable[[Any, list[Any]], Iterator[Piece]]


@dataclass(frozen=True)
class Flight:
    """A flight that ends on a stop, or at the end of the motion (stop -1); or a span in which the stop `held` is in contact.

    Of a scene whose stops give way some may be pressed along it; it ends where one is met or, of these, left.
    """

    start: Any
    state: list[Any]
    end: Any
    before: list[Any]
    stop: int
    held: int = -1
    pressed: tuple[int, ...] = ()

    @property
    def is_hit(self) -> bool:
        """Whether a stop is met at its end."""
        return self.stop >= 0 and self.stop not in self.pressed


@dataclass(frozen=True)
class Functions:
    """The formulas of a scene as functions of doubles, of arrays and of many digits."""

    n: int
    acceleration: Callable[..., Any]
    gaps: list[Callable[..., Any]]
    arrays: list[Callable[..., Any]]
    impacts: list[Callable[..., Any]]

    @classmethod
    def of(cls, problem: Problem, pressed: tuple[int, ...] = ()) -> Functions:
        """Those of a problem, with the stops that are pressed."""
        space = {"sin": mp.sin, "cos": mp.cos, "mpf": mp.mpf}
        exact: Equations = equations(problem.scene, mp.mpf, pressed)
        double = equations(problem.scene, pressed=pressed)
        return cls(
            exact.n_dof,
            exact.acceleration.function(space),
            [each.function(space) for each in exact.gaps],
            [each.function({"sin": np.sin, "cos": np.cos}) for each in double.gaps],
            [each.function(space) for each in exact.impacts],
        )


def bracketed(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Root between two points of opposite sign, to all digits: false position, Illinois."""
    f_low, f_high = function(low), function(high)
    while abs(high - low) > mp.mpf(10) ** (5 - mp.dps):
        middle = (low * f_high - high * f_low) / (f_high - f_low)
        value = function(middle)
        if abs(value) < mp.mpf(10) ** (5 - mp.dps):
            return middle
        if (value > 0) != (f_high > 0):
            low, f_low = high, f_high
        else:
            f_low /= 2
        high, f_high = middle, value
    return high


def lowest(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Where a function of one minimum is lowest, to ten digits: golden section, stopped as soon as it is negative."""
    golden = (mp.sqrt(5) - 1) / 2
    while high - low > mp.mpf("1e-10"):
        left, right = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, right) if function(left) < function(right) else (left, high)
        if function((low + high) / 2) < 0:
            break
    return (low + high) / 2


def gap_along(piece: Piece, functions: Functions, stop: int) -> Callable[[Any], Any]:
    """A gap in many digits, of the time on a piece."""
    return lambda s: functions.gaps[stop](piece.start + s, *piece.state(s)[: functions.n])[0]


def first_contact(piece: Piece, functions: Functions, calm: float) -> tuple[Any, int] | None:
    """First time on a piece, a calm one at its start left out, at which a gap falls through zero, and whose it is."""
    s = piece.grid()
    s = s[s >= calm]
    times, columns = float(piece.start) + s, piece.positions(s).T
    found = []
    for stop, gap in enumerate(functions.arrays):
        h = np.asarray(gap(times, *columns)[0])
        exact = gap_along(piece, functions, stop)
        crossing = np.flatnonzero((h[:-1] > 0) & (h[1:] <= 0))
        size = np.ptp(h) + 1e-300
        dips = np.flatnonzero((h[1:-1] < h[:-2]) & (h[1:-1] <= h[2:]) & (h[1:-1] > 0) & (h[1:-1] < 1e-2 * size)) + 1
        for k in sorted([*crossing, *dips]):
            low, high = mp.mpf(float(s[k])), mp.mpf(float(s[k + 1]))
            if k in dips:
                low = mp.mpf(float(s[k - 1]))
                high = lowest(exact, low, high)
                if exact(high) >= 0:
                    continue
            found.append((bracketed(exact, low, high), stop))
            break
    return min(found, default=None)


def soon_back(piece: Piece, functions: Functions, stop: int, guess: Any) -> Any:
    """Time of return to a stop just left, by Newton's method from the parabola's."""
    gap, s = gap_along(piece, functions, stop), guess
    for _ in range(6):
        step = s * mp.mpf("1e-8")
        s -= gap(s) * 2 * step / (gap(s + step) - gap(s - step))
    return s


def close_back(piece: Piece, functions: Functions, stop: int) -> Any | None:
    """Time of return to a stop just left while the gap is too small for doubles: samples in many digits, then a root."""
    gap, low = gap_along(piece, functions, stop), SOON * mp.mpf(piece.quickest)
    while low < CLOSE_END:
        high = low * mp.mpf(CLOSE)
        if high > piece.length:
            return None
        if gap(high) <= 0:
            return bracketed(gap, low, high)
        low = high
    return None

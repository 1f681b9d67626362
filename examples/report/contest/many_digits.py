"""Motions in many digits: the event loop of the references, for any flow that knows its states.

A flow makes pieces: spans of time on which states are known, in doubles for the search and in many digits for the result. On
each piece every gap is sampled finely; a change of sign, or a sampled minimum that falls below zero between its neighbours,
brackets a contact, which is then found in many digits. Impacts that accumulate are followed one by one down to speeds of
1e-25, where the contact lasts (one degree of freedom).
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
AT_REST = 1e-25  # speed below which a bouncing contact has ended
CALM = 0.02  # time after a release in which the motion leaves its stop, by less than doubles tell at first
RELEASED = -2  # in place of the stop that was hit last
SOON = 1e-4  # a return to the stop within that time is found by Newton's method from the parabola


class Piece(Protocol):
    """A span of a flight."""

    length: Any

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
    """A flight that ends on a stop, or at the end of the motion (stop -1)."""

    start: Any
    state: list[Any]
    end: Any
    before: list[Any]
    stop: int


@dataclass(frozen=True)
class Functions:
    """The formulas of a scene as functions of doubles, of arrays and of many digits."""

    n: int
    acceleration: Callable[..., Any]
    gaps: list[Callable[..., Any]]
    arrays: list[Callable[..., Any]]
    impacts: list[Callable[..., Any]]

    @classmethod
    def of(cls, problem: Problem) -> Functions:
        """Those of a problem."""
        space = {"sin": mp.sin, "cos": mp.cos, "mpf": mp.mpf}
        exact: Equations = equations(problem.scene, mp.mpf)
        double = equations(problem.scene)
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


def first_contact(piece: Piece, functions: Functions, calm: float) -> tuple[Any, int] | None:
    """First time on a piece, a calm one at its start left out, at which a gap falls through zero, and whose it is."""
    s = piece.grid()
    s = s[s >= calm]
    columns = piece.positions(s).T
    found = []
    for stop, gap in enumerate(functions.arrays):
        h = np.asarray(gap(*columns)[0])
        exact = lambda u, stop=stop: functions.gaps[stop](*piece.state(u)[: functions.n])[0]  # noqa: E731
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


def soon_back(piece: Piece, functions: Functions, stop: int, speed: Any, acceleration: Any) -> Any:
    """Time of return to a stop just left, by Newton's method from the parabola."""
    s = -2 * speed / acceleration
    gap = lambda u: functions.gaps[stop](*piece.state(u)[: functions.n])[0]  # noqa: E731
    for _ in range(6):
        step = s * mp.mpf("1e-8")
        s -= gap(s) * 2 * step / (gap(s + step) - gap(s - step))
    return s


def gap_rates(functions: Functions, stop: int, t: Any, x: list[Any]) -> tuple[Any, Any]:
    """First and second derivative of a linear gap."""
    n = functions.n
    at_zero = functions.gaps[stop](*([mp.mpf(0)] * n))[0]
    direction = [functions.gaps[stop](*[mp.mpf(i == j) for j in range(n)])[0] - at_zero for i in range(n)]
    a = functions.acceleration(t, *x)
    return sum(d * u for d, u in zip(direction, x[n:], strict=True)), sum(d * u for d, u in zip(direction, a, strict=True))


def released(functions: Functions, t: Any, x: list[Any], stop: int, end: Any) -> Any:
    """When a lasting contact of one degree of freedom is let go: its acceleration turns away from the stop."""
    pull = lambda u: gap_rates(functions, stop, u, [x[0], mp.mpf(0)])[1]  # noqa: E731
    low = t
    while low < end:
        high = min(low + mp.mpf("0.01"), end)
        if pull(high) > 0:
            return bracketed(pull, low, high)
        low = high
    return end


def motion(problem: Problem, flow: Flow) -> list[Flight]:
    """All flights of a problem, in order; the last one ends with the motion."""
    functions = Functions.of(problem)
    n, end = functions.n, mp.mpf(problem.end)
    t, x = mp.mpf(0), [mp.mpf(float(each)) for each in problem.start]
    flights: list[Flight] = []
    hit = -1
    while t < end:
        soon = None
        if hit >= 0 and problem.first is not None:
            speed, acceleration = gap_rates(functions, hit, t, x)
            if acceleration < 0 and speed < AT_REST:
                t, x = released(functions, t, x, hit, end), [*x[:n], *[mp.mpf(0)] * n]
                hit = RELEASED
                if t >= end:
                    flights.append(Flight(t, x, t, x, -1))
                continue
            soon = (speed, acceleration) if acceleration < 0 and -2 * speed / acceleration < SOON else None
        flight = one_flight(flow, functions, t, x, end, hit, soon)
        flights.append(flight)
        t, x, hit = flight.end, flight.before, flight.stop
        if hit >= 0:
            x = [*x[:n], *functions.impacts[hit](*x)]
    return flights


def one_flight(
    flow: Flow, functions: Functions, t: Any, x: list[Any], end: Any, hit: int, soon: tuple[Any, Any] | None
) -> Flight:
    """The flight from a state to the next contact or the end."""
    at, state = t, x
    for piece in flow(t, x):
        if soon is not None:
            s = soon_back(piece, functions, hit, *soon)
            return Flight(t, x, at + s, piece.state(s), hit)
        contact = first_contact(piece, functions, CALM if hit == RELEASED else 0.0)
        if contact is not None and at + contact[0] < end:
            return Flight(t, x, at + contact[0], piece.state(contact[0]), contact[1])
        if at + piece.length >= end:
            return Flight(t, x, end, piece.state(end - at), -1)
        at, state = at + piece.length, piece.state(piece.length)
    raise AssertionError(state)

"""The second way to nonlinear flights: midpoint steps, extrapolated (Gragg 1965; Bulirsch and Stoer 1966), in mpmath's digits."""

from __future__ import annotations

from typing import Any

from mpmath import mp

from .many_digits import Flight, Functions
from .problems import Problem

COLUMNS = 12  # of the extrapolation: order 24
STEP = 0.02  # longest step, in units of the problem's time


def midpoint(functions: Functions, t: Any, x: list[Any], length: Any, count: int) -> list[Any]:
    """Midpoint rule over a span in an even number of parts: an error in even powers of the part."""
    n, h = functions.n, length / count

    def rate(u: Any, z: list[Any]) -> list[Any]:
        return [*z[n:], *functions.acceleration(u, *z)]

    before, now = x, [a + h * b for a, b in zip(x, rate(t, x), strict=True)]
    for k in range(1, count):
        before, now = now, [a + 2 * h * b for a, b in zip(before, rate(t + k * h, now), strict=True)]
    return now


def step(functions: Functions, t: Any, x: list[Any], length: Any) -> list[Any]:
    """One extrapolated step (Aitken and Neville)."""
    row: list[list[Any]] = []
    for k in range(1, COLUMNS + 1):
        new = [midpoint(functions, t, x, length, 2 * k)]
        for j, old in enumerate(row):
            factor = (mp.mpf(k) / (k - 1 - j)) ** 2 - 1
            new.append([a + (a - b) / factor for a, b in zip(new[-1], old, strict=True)])
        row = new
    return row[-1]


def by_extrapolation(problem: Problem, flights: list[Flight]) -> Any:
    """Largest difference of any flight's end from that of extrapolated steps."""
    functions, worst = Functions.of(problem), mp.mpf(0)
    longest = mp.mpf(STEP)
    for flight in flights:
        t, x = flight.start, flight.state
        count = max(1, int(mp.ceil((flight.end - t) / longest)))
        length = (flight.end - t) / count
        for _ in range(count):
            t, x = t + length, step(functions, t, x, length)
        worst = max(worst, *(abs(a - b) for a, b in zip(x, flight.before, strict=True)))
    return worst

"""Any smooth motion in many digits: modified midpoint steps, extrapolated to none (Gragg, Bulirsch and Stoer)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mpmath import mpf

State = list[mpf]
Rate = Callable[[State], State]


def midpoint(rate: Rate, state: State, time: mpf, pieces: int) -> State:
    """Modified midpoint steps, smoothed at the end."""
    h = time / pieces
    old, new = state, [x + h * f for x, f in zip(state, rate(state), strict=True)]
    for _ in range(1, pieces):
        old, new = new, [x + 2 * h * f for x, f in zip(old, rate(new), strict=True)]
    return [(x + y + h * f) / 2 for x, y, f in zip(old, new, rate(new), strict=True)]


def step(rate: Rate, state: State, time: mpf, columns: int) -> State:
    """One step of order 2 x columns: Neville's scheme in the square of the length of the pieces."""
    row: list[State] = []
    for column in range(1, columns + 1):
        fresh = [midpoint(rate, state, time, 2 * column)]
        for back, before in enumerate(row, 1):
            ratio = (mpf(column) / (column - back)) ** 2 - 1
            fresh.append([x + (x - y) / ratio for x, y in zip(fresh[-1], before, strict=True)])
        row = fresh
    return row[-1]


def extrapolated(rate: Rate, state: Sequence[mpf], time: mpf, steps: int, columns: int = 14) -> State:
    """The state after some time."""
    found = list(state)
    for _ in range(steps):
        found = step(rate, found, time / steps, columns)
    return found

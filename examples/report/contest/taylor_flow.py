"""Nonlinear flights in many digits: Taylor series of the traced equations, in integers of fixed point.

Each line of the accelerations gives a recurrence of Taylor coefficients; `extrapolation.py` is the second way that checks them.
"""

from __future__ import annotations

from collections.abc import Iterator
from operator import mul
from typing import Any

import numpy as np
from mpmath import mp

from .equations import equations
from .formulas import Line
from .problems import Problem

BITS = 300  # of the fixed point, 90 digits
ORDER = 44
ACCURACY = 45  # digits of a step
SAMPLES = 400  # in a step, which is at most 2 long: stops that move do so slowly beside that


def fixed(value: Any) -> int:
    """A number in fixed point."""
    return int(mp.floor(mp.ldexp(mp.mpf(value), BITS)))


def product(a: list[int], b: list[int], k: int) -> int:
    """Coefficient k of a product of series."""
    return sum(map(mul, a[: k + 1], b[k::-1])) >> BITS


class Recurrence:
    """Coefficients of every line of the accelerations, one order after another."""

    def __init__(self, problem: Problem) -> None:
        """Trace the accelerations with constants of many digits."""
        self.n = problem.scene.n_dof
        self.formula = equations(problem.scene, mp.mpf).acceleration

    def series(self, t: Any, x: list[Any]) -> list[list[int]]:
        """Taylor coefficients of the positions and velocities at (t, x)."""
        n = self.n
        table: dict[Any, list[int]] = {"t": [fixed(t), 1 << BITS]}
        for name, value in zip(self.formula.arguments[1:], x, strict=True):
            table[name] = [fixed(value)]
        for line in self.formula.lines:
            table[line.name] = []
            table["partner of " + line.name] = []
        for k in range(ORDER):
            if k > 1:
                table["t"].append(0)
            for line in self.formula.lines:
                self.extend(table, line, k)
            for i in range(n):
                table[f"q{i}"].append(table[f"v{i}"][k] // (k + 1))
                result = self.formula.results[i]
                rate = table[result][k] if isinstance(result, str) else (fixed(result) if k == 0 else 0)
                table[f"v{i}"].append(rate // (k + 1))
        return [table[name] for name in self.formula.arguments[1:]]

    def extend(self, table: dict[Any, list[int]], line: Line, k: int) -> None:
        """Coefficient k of one line."""
        made = table[line.name]
        a, *rest = [self.operand(table, each, k) for each in line.operands]
        if line.operation in "+-":
            made.append(a[k] + rest[0][k] if line.operation == "+" else a[k] - rest[0][k])
        elif line.operation == "*":
            made.append(product(a, rest[0], k))
        elif line.operation == "/":
            b = rest[0]
            known = sum(map(mul, made[:k], b[k:0:-1])) if k else 0
            made.append(((a[k] << BITS) - known) // b[0])
        else:
            self.turn(table, line, a, k)

    def turn(self, table: dict[Any, list[int]], line: Line, a: list[int], k: int) -> None:
        """Coefficient k of a sine or cosine, and of its partner: `s' = a' c`, `c' = -a' s`."""
        made, partner = table[line.name], table["partner of " + line.name]
        if k == 0:
            angle = mp.ldexp(mp.mpf(a[0]), -BITS)
            first, second = (mp.sin, mp.cos) if line.operation == "sin" else (mp.cos, mp.sin)
            made.append(fixed(first(angle)))
            partner.append(fixed(second(angle)))
            return
        slopes = [j * a[j] for j in range(1, k + 1)]
        sign = 1 if line.operation == "sin" else -1
        by_partner = sum(map(mul, slopes, partner[k - 1 :: -1])) >> BITS
        by_made = sum(map(mul, slopes, made[k - 1 :: -1])) >> BITS
        made.append(sign * by_partner // k)
        partner.append(-sign * by_made // k)

    def operand(self, table: dict[Any, list[int]], operand: Any, k: int) -> list[int]:
        """Coefficients of a name, or of a number."""
        if isinstance(operand, str):
            return table[operand]
        key = ("number", operand)
        if key not in table:
            table[key] = [fixed(operand)]
        while len(table[key]) <= k:
            table[key].append(0)
        return table[key]


class TaylorPiece:
    """One step."""

    def __init__(self, start: Any, series: list[list[int]], after_impact: bool) -> None:
        """Choose the step from the last coefficients."""
        self.start, self.after_impact = start, after_impact
        self.series = [[mp.ldexp(mp.mpf(each), -BITS) for each in row] for row in series]
        self.n = len(series) // 2
        last = max(max(abs(row[-1]), abs(row[-2]) ** (mp.mpf(ORDER) / (ORDER - 1)), mp.mpf("1e-60")) for row in self.series)
        self.length = min((mp.mpf(10) ** -ACCURACY / last) ** (mp.mpf(1) / ORDER), mp.mpf(2))
        self.doubles = np.array([[float(each) for each in row] for row in self.series[: self.n]])
        self.quickest = 1.0

    def grid(self) -> np.ndarray:
        """Points of the step; close to the start first."""
        step = float(self.length) / SAMPLES
        near = np.geomspace(1e-5, 1.0, 100)[:-1] * step if self.after_impact else np.zeros(1)
        return np.concatenate([near, np.arange(1, SAMPLES + 1) * step])

    def positions(self, s: np.ndarray) -> np.ndarray:
        """Positions in doubles, (m, n)."""
        return np.array([np.polyval(row[::-1], s) for row in self.doubles]).T

    def state(self, s: Any) -> list[Any]:
        """Positions and velocities in many digits."""
        return [mp.polyval(row[::-1], s) for row in self.series]


class TaylorFlow:
    """Makes the flights of any scene of the traced equations."""

    def __init__(self, problem: Problem) -> None:
        """Trace the equations once."""
        self.recurrence = Recurrence(problem)

    def __call__(self, t: Any, x: list[Any]) -> Iterator[TaylorPiece]:
        """Step after step, without end."""
        after_impact = True
        while True:
            piece = TaylorPiece(t, self.recurrence.series(t, x), after_impact)
            yield piece
            t, x, after_impact = t + piece.length, piece.state(piece.length), False

"""References with their condition numbers, by differences of high-precision arithmetic.

The condition number of an output is what relative changes of the inputs, each as large as one unit, can change it by at
most, in units of its size: ``sum_i |x_i df/dx_i| / |f|`` (Gohberg and Koltracht 1993, SIAM J. Matrix Anal. Appl. 14,
componentwise). Outputs of one kind, say the positions of a state, form a part and are measured by its largest entry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mpmath import mpf

STEP = mpf(10) ** -22  # relative; with 50 digits a difference keeps 28

Parts = list[list[mpf]]
Function = Callable[..., Parts]


@dataclass(frozen=True)
class Truth:
    """Reference values in parts, and the condition number of each part."""

    parts: Parts
    conditions: list[float]

    def part(self, index: int) -> Truth:
        """One part by itself."""
        return Truth([self.parts[index]], [self.conditions[index]])


def truth(function: Function, *inputs: float) -> Truth:
    """Values of a function at doubles taken as exact, with their condition numbers."""
    at = [mpf(x) for x in inputs]
    parts = function(*at)
    sums = [[mpf(0)] * len(part) for part in parts]
    for i, x in enumerate(at):
        if x:
            moved = function(*at[:i], x * (1 + STEP), *at[i + 1 :])
            for total, part, other in zip(sums, parts, moved, strict=True):
                for k, (old, new) in enumerate(zip(part, other, strict=True)):
                    total[k] += abs(new - old) / STEP
    return Truth(parts, [float(max(total) / (max(map(abs, part)) or 1)) for total, part in zip(sums, parts, strict=True)])


def known(*parts: Sequence[float | mpf], condition: float = 1.0) -> Truth:
    """Values known exactly, with the condition number that theory gives them."""
    return Truth([[mpf(x) for x in part] for part in parts], [condition] * len(parts))

"""Fitted laws of growth and the rule by which they are judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

# A fitted exponent may exceed the stated one by so much: instructions have no noise, times have.
SLACK_OF_COUNTS, SLACK_OF_TIMES = 0.1, 0.2
# The part of the sizes, from the largest down, where the leading term of a law is looked for; at least three of them.
PART = 0.5
RULE = (
    f"an exponent is fitted by least squares to the logarithms over the larger half of the sizes (three at least). A law holds "
    f"if the exponent exceeds the stated one by no more than {SLACK_OF_COUNTS} where instructions are counted, by no more than "
    f"{SLACK_OF_TIMES} where times alone are known. A stated law is a bound: smaller exponents hold too."
)


@dataclass(frozen=True)
class Fit:
    """`cost = scale * size**power`, over the sizes from `first` on."""

    power: float
    scale: float
    first: float

    def at(self, size: float) -> float:
        """The fitted cost of a size."""
        return float(self.scale * size**self.power)


def fitted(costs: Mapping[int, float]) -> Fit:
    """Least squares in logarithms over the larger sizes."""
    sizes = sorted(costs)
    kept = sizes[-max(3, round(PART * len(sizes))) :]
    power, shift = np.polyfit(np.log(kept), np.log([costs[size] for size in kept]), 1)
    return Fit(float(power), float(np.exp(shift)), float(kept[0]))


def verdict(fit: Fit, stated: float, slack: float) -> str:
    """Whether the cost grows no faster than stated."""
    return "holds" if fit.power <= stated + slack else "grows faster"


def law(power: float, size: str) -> str:
    """`O(n)` in words of the size."""
    if power == 0:
        return "O(1)"
    return f"O({size})" if power == 1 else f"O({size}^{power:g})"

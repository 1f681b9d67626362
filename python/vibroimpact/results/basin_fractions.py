"""How large basins are in a box."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array


class BasinFractions(Record):
    """How large basins are in a box, by random states: k attractors, over m values of a number where one varies.

    Attributes
    ----------
    fractions, errors : ndarray, shape (k,) or (m, k)
        The part [-] of the states outside every stop that leads to each attractor, and its standard error.
    undecided : ndarray, shape () or (m,)
        The part that leads to none of them [-].
    attractors : tuple of Attractor, or of tuples of them
        The attractors, of each value those that it has; along the values each keeps its column.
    name : str or None
        What varies.
    values : ndarray, shape (m,), or None
        Its values.
    """

    fractions: NDArray[np.float64] = array("attractor", "value attractor")
    errors: NDArray[np.float64] = array("attractor", "value attractor")
    undecided: NDArray[np.float64] = array("", "value")
    attractors: tuple[Any, ...]
    name: str | None
    values: NDArray[np.float64] | None = array("value", coordinate="parameter")

    def __repr__(self) -> str:
        """Say how large the basins are."""
        if self.fractions.ndim == 1:
            each = ", ".join(f"{x:.3g} +- {s:.1g}" for x, s in zip(self.fractions, self.errors, strict=True))
            return f"BasinFractions([{each}], {float(self.undecided):.3g} to none)"
        return f"BasinFractions({self.name}, {len(self.fractions)} values of {self.fractions.shape[1]} attractors)"

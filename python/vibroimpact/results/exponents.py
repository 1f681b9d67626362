"""Lyapunov exponents of a motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array


class LyapunovExponents(Record):
    """How fast small deviations from a motion grow, in k directions.

    Attributes
    ----------
    exponents : ndarray, shape (k,)
        Growth per unit time [1/s], the largest first; -inf where contact takes a direction away, nan where the run ends before
        any time counts, and where deviations have no derivative that is known.
    errors : ndarray, shape (k,)
        Standard errors [1/s], from the means of batches; nan where time is too short for two of them, 0 of -inf.
    sum, expected_sum : float
        The sum of all 2n exponents [1/s], nan where fewer are asked for; and as damping and restitution make it, of linear
        scenes while nothing sticks, else nan.
    history : ndarray, shape (b, k)
        Growth per unit time [1/s] in batches of equal length, at most 20, each with at least 50 returns: periods of the forcing;
        without one impacts, or turns of its slowest tone, whichever are more. One batch where there are fewer than 100 returns.
    n_impacts, n_landings, n_grazes : int
        In the time that counts: impacts; how often a stop came to be held; touches, and impacts too slow to have a derivative,
        which deviations pass by.
    n_clashes : int
        Instants at which several stops were hit and their order matters: deviations have no derivative there.
    verdict : {"periodic", "torus", "chaotic", "drift", "undecided"}
        What the exponents say within three errors and 1 / time, and where one is zero the motion; "drift": it repeats itself but
        for a constant advance. "undecided" too after clashes, and where the run ended early.
    status : str
        How the run ended, as of a trajectory.
    message : str
        Why there are no exponents, or the verdict is what it is; empty where the exponents say all.
    """

    exponents: NDArray[np.float64] = array("exponent", unit="1/s")
    errors: NDArray[np.float64] = array("exponent", unit="1/s")
    sum: float
    expected_sum: float
    history: NDArray[np.float64] = array("batch exponent", unit="1/s")
    n_impacts: int
    n_landings: int
    n_grazes: int
    n_clashes: int
    verdict: str
    status: str
    message: str = ""

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the result as arrays, for ``numpy.savez``."""
        return {name: np.asarray(getattr(self, name)) for name in self._fields}

    def __repr__(self) -> str:
        """Say the exponents with their errors and what they mean."""
        each = ", ".join(
            f"{x:.4g} +- {s:.1g}" if np.isfinite(x) else f"{x}" for x, s in zip(self.exponents, self.errors, strict=True)
        )
        why = f"; {self.message}" if self.message else ""
        return f"LyapunovExponents({self.verdict}: {each}; {self.n_impacts} impacts, {self.n_landings} landings{why})"

"""Lyapunov exponents: how fast small deviations from a motion grow."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import Scene
from vibroimpact._results import ArrayResult

__all__ = ["LyapunovExponents", "lyapunov_exponents"]


@dataclass(frozen=True, eq=False)
class LyapunovExponents(ArrayResult):
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

    exponents: NDArray[np.float64]
    errors: NDArray[np.float64]
    sum: float
    expected_sum: float
    history: NDArray[np.float64]
    n_impacts: int
    n_landings: int
    n_grazes: int
    n_clashes: int
    verdict: str
    status: str
    message: str = ""

    def __post_init__(self) -> None:
        """Refuse arrays that are none of one motion."""
        k = np.shape(self.exponents)[:1]
        self._check({"exponents": ("f", k), "errors": ("f", k), "history": ("f", np.shape(self.history)[:1] + k)})

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the result as arrays, for ``numpy.savez``."""
        return {own.name: np.asarray(getattr(self, own.name)) for own in fields(self)}

    def __repr__(self) -> str:
        """Say the exponents with their errors and what they mean."""
        each = ", ".join(
            f"{x:.4g} +- {s:.1g}" if np.isfinite(x) else f"{x}" for x, s in zip(self.exponents, self.errors, strict=True)
        )
        why = f"; {self.message}" if self.message else ""
        return f"LyapunovExponents({self.verdict}: {each}; {self.n_impacts} impacts, {self.n_landings} landings{why})"


def lyapunov_exponents(
    scene: Scene,
    q0: ArrayLike,
    v0: ArrayLike,
    t_span: tuple[float, float],
    *,
    skip: float = 0.0,
    n_exponents: int | None = None,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float | None = None,
    progress: bool = False,
) -> LyapunovExponents:
    """Return how fast small deviations from a motion grow.

    Deviations fly with the motion, cross impacts by saltation matrices, the end of accumulating impacts by the derivative of its
    map, and lose what contact takes away where a stop comes to be held; they are made orthonormal again at every instant (theory
    16).

    Parameters
    ----------
    scene : Scene
        What moves: linear or not.
    q0, v0 : array_like, shape (n,)
        Position and velocity at the start.
    t_span : (float, float)
        Start and end [s].
    skip : float, default 0.0
        Time at the start that does not count [s].
    n_exponents : int, optional
        How many are wanted, the largest; default all 2n.
    method, rtol, atol
        As for ``simulate``; deviations from a motion that is integrated have the same tolerances.
    progress : bool, default False
        Show a progress bar (needs tqdm).

    Returns
    -------
    LyapunovExponents
        Exponents with errors, counts and a verdict.

    Raises
    ------
    ValueError
        As ``simulate``; a ``skip`` below zero or not shorter than the span, ``n_exponents`` that is none of 1 to 2n.

    References
    ----------
    .. [1] G. Benettin, L. Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9-20.
    .. [2] P. Mueller, Chaos, Solitons and Fractals 5 (1995) 1671-1681.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([5.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> found = vi.lyapunov_exponents(scene, [0.0], [0.0], (0, 6000), skip=500)
    >>> found.verdict
    'chaotic'
    >>> abs(found.sum - found.expected_sum) < 1e-6
    True
    """
    arguments = (scene, q0, v0, t_span, skip, n_exponents, method, rtol, atol, progress)
    return LyapunovExponents(*_core._lyapunov_exponents(*arguments))

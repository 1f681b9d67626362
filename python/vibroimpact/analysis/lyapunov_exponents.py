"""Lyapunov exponents: how fast small deviations from a motion grow."""

from __future__ import annotations

from numpy.typing import ArrayLike

from vibroimpact import _core
from vibroimpact._core import Scene
from vibroimpact.results.exponents import LyapunovExponents

__all__ = ["lyapunov_exponents"]


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
    16). Beside them goes the place of a stop that relaxes, as long as it does (theory 22).

    Parameters
    ----------
    scene : Scene
        What moves: linear or not; with stops that give way by exact flights alone.
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
    options = {"skip": skip, "n_exponents": n_exponents, "method": method, "rtol": rtol, "atol": atol, "progress": progress}
    return LyapunovExponents(**_core._lyapunov_exponents(scene, q0, v0, t_span, options))

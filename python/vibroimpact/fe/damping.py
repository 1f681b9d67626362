"""Rayleigh damping of dense and sparse matrices (theory 13)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vibroimpact import _core
from vibroimpact._validation import shown
from vibroimpact.fe import matrices

__all__ = ["rayleigh_damping"]


def rayleigh_damping(
    mass: ArrayLike | Any,
    stiffness: ArrayLike | Any,
    *,
    alpha: float | None = None,
    beta: float | None = None,
    ratios: Mapping[float, float] | None = None,
) -> Any:
    """Rayleigh damping ``C = alpha M + beta K``, by its coefficients or by the damping ratios at two frequencies.

    Parameters
    ----------
    mass : array_like or sparse array, shape (n, n) or (n,)
        Mass matrix M; ``(n,)`` is a diagonal.
    stiffness : array_like or sparse array, shape (n, n) or (n,)
        Stiffness matrix K.
    alpha : float, optional
        Coefficient of the mass [1/s], not negative; 0 where only beta is given.
    beta : float, optional
        Coefficient of the stiffness [s], not negative; 0 where only alpha is given.
    ratios : dict, optional
        In place of both, the damping ratios [-] at two frequencies [rad/s]: ``{w1: zeta1, w2: zeta2}``.

    Returns
    -------
    ndarray or sparse array, shape (n, n) or (n,)
        The damping matrix C: sparse if one of the matrices is, a diagonal if both are.

    Raises
    ------
    ValueError
        Both or neither of coefficients and ratios; numbers that are negative or not finite; frequencies that are zero or
        equal; ratios so unlike that alpha or beta would be negative; matrices that do not fit together.

    Notes
    -----
    A mode of frequency w gets the damping ratio ``alpha/(2 w) + beta w/2`` [1]_: less than given between the two frequencies,
    more outside of them; a rigid-body mode has the damping alpha.

    References
    ----------
    .. [1] M. Geradin, D. J. Rixen, Mechanical Vibrations, 3rd ed., Wiley 2015, ch. 3.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> mass, stiffness = [1.0, 1.0], [4.0, 9.0]
    >>> damping = vi.rayleigh_damping(mass, stiffness, ratios={2.0: 0.02, 3.0: 0.02})
    >>> vi.modes(vi.LinearSystem(mass, damping, stiffness)).damping_ratios.round(12)
    array([0.02, 0.02])
    """
    alpha, beta = _coefficients(alpha, beta, ratios)
    if matrices.is_sparse(mass) or matrices.is_sparse(stiffness):
        m = matrices.square("mass", mass)
        return alpha * m + beta * matrices.square("stiffness", stiffness, m.shape[0])
    m = _dense("mass", mass)
    k = _dense("stiffness", stiffness)
    if len(m) != len(k):
        message = f"stiffness has shape {k.shape}, but that of the mass, {m.shape}, is needed, or a diagonal of this length"
        raise ValueError(message)
    if m.ndim != k.ndim:
        m, k = (np.diag(x) if x.ndim == 1 else x for x in (m, k))
    return alpha * m + beta * k


def _coefficients(alpha: float | None, beta: float | None, ratios: Mapping[float, float] | None) -> tuple[float, float]:
    """Return alpha and beta as given, or from damping ratios at two frequencies."""
    is_given = alpha is not None or beta is not None
    if is_given == (ratios is not None):
        message = f"alpha is {alpha}, beta is {beta} and ratios is {ratios}, but either coefficients or ratios are needed"
        raise ValueError(message)
    if ratios is None:
        return _coefficient("alpha", alpha), _coefficient("beta", beta)
    try:
        first, second = ((float(w), float(zeta)) for w, zeta in ratios.items())
    except (AttributeError, TypeError, ValueError):
        message = f"ratios is {shown(ratios)}, but damping ratios at two frequencies, {{w1: zeta1, w2: zeta2}}, are needed"
        raise ValueError(message) from None
    return _core._rayleigh_coefficients(first, second)


def _coefficient(argument: str, value: float | None) -> float:
    number = 0.0 if value is None else matrices.number(argument, value)
    if number < 0.0:
        message = f"{argument} is {number}, but it must not be below zero: modes would grow"
        raise ValueError(message)
    return number


def _dense(argument: str, value: ArrayLike) -> Any:
    matrix = np.atleast_1d(matrices.finite(argument, value))
    if matrix.ndim > 2 or len(set(matrix.shape)) != 1:
        message = f"{argument} has shape {matrix.shape}, but (n, n) is needed, or (n,) for a diagonal"
        raise ValueError(message)
    return matrix

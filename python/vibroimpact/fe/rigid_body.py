"""Rigid-body modes of large structures: motions without strain, found by subspace iteration (theory 13)."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from vibroimpact.errors import ConvergenceError
from vibroimpact.fe import sparse_modes

_Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
#: A mode is a rigid-body mode if its squared frequency is within so many times what random rounding of the entries of K makes
#: of it. Of structures that nothing holds it is within 2, of held ones beyond 1e4 but for meshes so fine that doubles hardly
#: hold them.
_ROUNDINGS = 8.0
#: The same where entries have lost digits, as those of element codes have: rounding of 1e-12 makes up to 1e4. Such modes are
#: rigid-body modes if the next one is far beyond.
_LOST_ROUNDINGS = 2e4
#: How far, in squared frequencies. Of a structure that is held the second mode is never so far: of a beam a factor of 39.
_FAR = 1e3
#: Shifts that are tried, each a hundred times the one before, until rounding leaves ``K + s M`` positive definite.
_SHIFT_STEP = 100.0
#: The last of them relative to the rounding of the fastest coordinate: what is negative beyond it is negative.
_LAST_SHIFT = 1e4
#: Vectors that are iterated to find the rigid-body modes, at first.
_BLOCK = 8
#: Steps of their iteration at the most; a few do but where no shift is small beside the first squared frequency.
_ITERATIONS = 100


def _rounding(stiffness: Any, shapes: _Array) -> _Array:
    """Return what random rounding of the entries of K makes of the squared frequency of each shape (the root of squares)."""
    squares = shapes**2
    return np.asarray(_EPS * np.sqrt(np.einsum("ij,ij->j", squares, stiffness.power(2) @ squares)))


def _shifted_factor(stiffness: Any, mass: Any, may_be_indefinite: bool) -> Any:
    """Factor ``K + s M`` with the least shift tried with which rounding leaves it positive definite, if it has to be."""
    ratios = np.abs(stiffness.diagonal()) / mass.diagonal()
    if not ratios.any():
        shift, last = 1.0, 1.0
    else:
        shift, last = _ROUNDINGS * _EPS * ratios[ratios > 0.0].min(), _LAST_SHIFT * _EPS * ratios.max()
    negative = 0
    while shift <= last:
        factor = sparse_modes.symmetric_factor(stiffness + shift * mass)
        if factor is not None:
            negative = sparse_modes.negative_pivots(factor)
            if negative == 0 or may_be_indefinite:
                return factor
        shift = last if shift < last < shift * _SHIFT_STEP else shift * _SHIFT_STEP
    raise ValueError(sparse_modes.indefinite(negative))


def rigid_body_modes(stiffness: Any, mass: Any, most: int, given: int | None = None) -> _Array:
    """M-orthonormal rigid-body modes, shape (n, r): motions without strain, with frequency zero to the rounding of K.

    Their number r may be given.

    Subspace iteration with ``K + s M``, s a small shift: what has no stiffness is ahead of all else by the ratio of the first
    elastic squared frequency to s, and a block misses no mode of a multiple frequency. If there are more than ``most``, some
    of them.
    """
    n = mass.shape[0]
    factor = _shifted_factor(stiffness, mass, given is not None)
    size = min(n, max(_BLOCK, 0 if given is None else given + 2))
    while True:
        values, shapes = _subspace_iteration(stiffness, mass, factor, size)
        rounding = _rounding(stiffness, shapes)
        order = np.argsort(np.abs(values))
        values, shapes, rounding = values[order], shapes[:, order], rounding[order]
        n_rigid = _n_rigid(values, rounding) if given is None else given
        if given is not None:
            _check_given(values, rounding, given)
        if np.any(values[n_rigid:] < -_ROUNDINGS * rounding[n_rigid:]):
            raise ValueError(sparse_modes.indefinite(int(np.count_nonzero(values < -_ROUNDINGS * rounding))))
        if size == n or size > most or n_rigid < size:
            return _in_order(shapes[:, :n_rigid], mass)
        size = min(n, 4 * size)


def _n_rigid(values: _Array, rounding: _Array) -> int:
    """Return how many of the lowest squared frequencies, in the order of their sizes, are zero but for rounding.

    Those within the rounding of doubles are; those that a rounding of 1e-12 of the entries may have made, if the next is far.
    """
    within = np.abs(values) <= _ROUNDINGS * rounding
    certain = int(np.argmin(within)) if not within.all() else len(values)
    for count in range(len(values) - 1, certain, -1):
        is_lost = np.abs(values[:count]) <= _LOST_ROUNDINGS * rounding[:count]
        if is_lost.all() and values[count] > _FAR * np.abs(values[:count]).max():
            return count
    return certain


def _check_given(values: _Array, rounding: _Array, given: int) -> None:
    """Refuse a number of rigid-body modes that are more, or fewer, than there may be."""
    least = int(np.count_nonzero(np.abs(values) <= _ROUNDINGS * rounding))
    if given < least:
        message = f"rigid_modes is {given}, but {least} or more modes have no stiffness"
        raise ValueError(message)
    if 0 < given < len(values) and not np.abs(values[given - 1]) * _FAR < abs(values[given]) and given > least:
        ratio = abs(values[given] / values[given - 1])
        message = (
            f"rigid_modes is {given}, but the squared frequency of the last of them is only {ratio:.3g} times below that of the "
            f"next: of rigid-body modes it is less than 1/{_FAR:g} of that"
        )
        raise ValueError(message)


def _subspace_iteration(stiffness: Any, mass: Any, factor: Any, size: int) -> tuple[_Array, _Array]:
    """Iterate a block until all its squared frequencies but the last have settled to a tenth, or are rounding."""
    none = np.zeros((mass.shape[0], 0))
    random = np.random.default_rng(0)
    shapes = random.standard_normal((mass.shape[0], size))
    n_settled = max(1, size - 1)
    before = np.full(n_settled, np.inf)
    for _ in range(_ITERATIONS):
        shapes = sparse_modes.orthonormalise(factor.solve(mass @ shapes), mass, none)
        # Beside what has no stiffness, columns may be left without a digit of anything else.
        fresh = random.standard_normal((mass.shape[0], size - shapes.shape[1]))
        shapes = np.hstack([shapes, sparse_modes.orthonormalise(fresh, mass, shapes)])
        if shapes.shape[1] < size:
            message = "rigid-body modes could not be looked for: in doubles the mass does not tell the coordinates apart"
            raise ConvergenceError(message)
        values, shapes = sparse_modes.ritz(stiffness, shapes)
        now = values[:n_settled]
        if np.all(np.abs(now - before) <= 0.1 * np.abs(now) + _ROUNDINGS * _rounding(stiffness, shapes[:, :n_settled])):
            break
        before = now
    return values, shapes


def _in_order(rigid: _Array, mass: Any) -> _Array:
    """Turn rigid-body modes, of which any rotation is as good, to where each has no part at the coordinates of those before."""
    n_rigid = rigid.shape[1]
    if n_rigid == 0:
        return rigid
    turn, _ = scipy.linalg.qr(rigid[sparse_modes.pivots(rigid, mass)[:n_rigid]].T)
    return np.asarray(rigid @ turn)

"""Coordinates without mass, as rotations of lumped models: they follow the others by ``x_s = -K_ss^-1 K_sm x_m`` (theory 13)."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from vibroimpact.fe import sparse_modes

_Array = NDArray[np.float64]

#: Coordinates with mass up to which those without are condensed: what is left of K has no zeros.
_MOST = 6000
#: Entries of the condensed K below this, relative to the terms they are left of, are rounding.
_ROUNDING = 1e-15


class Condensation:
    """A model in its coordinates with mass.

    Attributes
    ----------
    mass, stiffness : sparse array
        Those of the model: the same where each coordinate has mass.

    Raises
    ------
    ValueError
        Coordinates without mass that nothing holds, or so many with mass that a full matrix of theirs takes too much memory.
    """

    def __init__(self, mass: Any, stiffness: Any) -> None:
        self.mass, self.stiffness = mass, stiffness
        self._n = mass.shape[0]
        is_massless = _is_empty(mass)
        self._kept, self._massless = np.flatnonzero(~is_massless), np.flatnonzero(is_massless)
        self._follow = np.zeros((0, self._n))
        if not self._massless.size:
            return
        loose = np.flatnonzero(is_massless & _is_empty(stiffness))
        if loose.size:
            message = f"unknown {_listed(loose)} has neither mass nor stiffness: leave its rows and columns out of the matrices"
            raise ValueError(message)
        if not 0 < self._kept.size <= _MOST:
            message = (
                f"mass has {self._massless.size} rows of zeros beside {self._kept.size} others, but coordinates without mass are "
                f"condensed, by -K_ss^-1 K_sm, only beside 1 to {_MOST} with mass: condense them first, or give them their mass"
            )
            raise ValueError(message)
        inner = stiffness[self._massless][:, self._massless]
        factor = sparse_modes.positive_factor(inner)
        if factor is None:
            message = (
                f"unknowns without mass, as {_listed(self._massless)}, are not all held by the stiffness: they are condensed by "
                "-K_ss^-1 K_sm, for which K_ss must be positive definite"
            )
            raise ValueError(message)
        beside = stiffness[self._massless][:, self._kept].toarray(order="F")
        self._follow = -factor.solve(beside)
        self._follow -= factor.solve(np.asfortranarray(inner @ self._follow + beside))
        own = stiffness[self._kept][:, self._kept].toarray()
        left = own + beside.T @ self._follow
        sizes = np.sqrt(np.outer(own.diagonal(), own.diagonal()))
        left[np.abs(left) <= _ROUNDING * np.abs(sizes)] = 0.0
        self.mass = mass[self._kept][:, self._kept]
        self.stiffness = scipy.sparse.csc_array((left + left.T) * 0.5)

    @property
    def n(self) -> int:
        """The number of coordinates with mass."""
        return len(self._kept)

    def forces(self, argument: str, vectors: _Array) -> _Array:
        """Return the part of forces, shape (n,) or (n, k), at the coordinates with mass: elsewhere there may be none."""
        if self._massless.size:
            for place in np.argwhere(vectors[self._massless] != 0.0)[:1]:
                i = int(self._massless[place[0]])
                name = f"{argument}[{int(place[1])}]" if vectors.ndim == 2 else argument
                message = f"{name} has a part at unknown {i}, which has no mass: such coordinates carry no stop or force"
                raise ValueError(message)
        return vectors[self._kept]

    def whole(self, shapes: _Array) -> _Array:
        """Return shapes of all coordinates."""
        if not self._massless.size:
            return shapes
        full = np.zeros((self._n, shapes.shape[1]))
        full[self._kept], full[self._massless] = shapes, self._follow @ shapes
        return full


def _is_empty(matrix: Any) -> NDArray[np.bool_]:
    """Whether each row of a symmetric matrix has zeros alone."""
    return np.asarray(np.asarray(abs(matrix).sum(axis=0)).ravel() == 0.0)


def _listed(unknowns: NDArray[np.int64]) -> str:
    return ", ".join(map(str, unknowns[:3])) + (f" and {unknowns.size - 3} more" if unknowns.size > 3 else "")

"""A map of where in a plane of two parameters a pattern has periodic orbits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array


class ExistenceMap(Record):
    """Where in a plane of two parameters a pattern has periodic orbits.

    Attributes
    ----------
    x, y : ndarray, shape (nx,) and (ny,)
        Values of the parameters [its own unit].
    x_name, y_name : str or None
        What they are, None for a map made by a callable.
    n_orbits : ndarray of int, shape (ny, nx)
        Number of orbits, admissible or not; -1 in a store where it has not been worked out yet.
    is_admissible, is_stable : ndarray of bool, shape (ny, nx)
        Whether one of them is admissible; admissible and stable.
    multiplier : ndarray, shape (ny, nx)
        Largest modulus of the multipliers of the first orbit [-], nan where there is none.
    """

    x: NDArray[np.float64] = array("x", coordinate="x")
    y: NDArray[np.float64] = array("y", coordinate="y")
    x_name: str | None
    y_name: str | None
    n_orbits: NDArray[np.int64] = array("y x")
    is_admissible: NDArray[np.bool_] = array("y x")
    is_stable: NDArray[np.bool_] = array("y x")
    multiplier: NDArray[np.float64] = array("y x")

    def __repr__(self) -> str:
        """Say what the map is over and what it found."""
        cells = self.n_orbits.size
        found = (
            f"{np.count_nonzero(self.n_orbits > 0)} with an orbit, {np.count_nonzero(self.is_admissible)} with an admissible "
            f"one, {np.count_nonzero(self.is_stable)} with a stable admissible one"
        )
        return f"ExistenceMap({self.x_name or 'x'} x {self.y_name or 'y'}, {cells} cells: {found})"

"""How intricate the boundary of basins is: entropy, dimension, uncertainty."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array


class Fit(Record):
    """A power law fitted to counts over sizes.

    Attributes
    ----------
    value, error : float
        The exponent [-], and its standard error by the regression; nan of fewer than three sizes with counts.
    sizes, counts : ndarray, shape (m,)
        Sizes [cells], and what was counted at each [-].
    """

    value: float
    error: float
    sizes: NDArray[np.int64] = array("size", coordinate="size")
    counts: NDArray[np.float64] = array("size")

"""Cells around values on an axis."""

import numpy as np

from vibroimpact.plot._data import FloatArray

LONE_HALF_WIDTH = 0.05  # of a cell without neighbours, in its value (in 1 where that is zero)


def edges(values: FloatArray, is_logarithmic: bool) -> FloatArray:
    """Return the bounds of cells around ascending values: half-way between neighbours, the outer cells symmetric."""
    if is_logarithmic and np.all(values > 0.0):
        return np.exp(edges(np.log(values), False))
    if len(values) == 1:
        half = LONE_HALF_WIDTH * (abs(values[0]) or 1.0)
        return np.array([values[0] - half, values[0] + half])
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]])

"""How intricate the boundary of basins is: entropy, dimension, uncertainty."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array

#: Boxes of the largest size along the shorter side.
_LEAST_BOXES = 4


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


def _is_basin(labels: NDArray[np.int16]) -> NDArray[np.bool_]:
    return np.asarray((labels > 0) | (labels == -1))


def _boxes(labels: NDArray[np.int16], side: int) -> NDArray[np.int16]:
    """Return the whole boxes of so many cells a side, one a row."""
    ny, nx = (length // side for length in labels.shape)
    cut = labels[: ny * side, : nx * side].reshape(ny, side, nx, side)
    return cut.transpose(0, 2, 1, 3).reshape(ny * nx, side * side)


def entropy(labels: NDArray[np.int16], cells: int) -> tuple[float, float]:
    """Return the entropy of all boxes and of those with more than one basin, each the mean."""
    if isinstance(cells, bool) or not isinstance(cells, (int, np.integer)) or not 1 <= cells <= min(labels.shape):
        message = f"cells is {cells!r}, but it must be at least 1 and at most {min(labels.shape)}, the shorter side"
        raise ValueError(message)
    each, mixed = [], []
    for box in _boxes(labels, int(cells)):
        _, counts = np.unique(box[_is_basin(box)], return_counts=True)
        if counts.size == 0:
            continue
        parts = counts / counts.sum()
        each.append(float(-(parts * np.log(parts)).sum()))
        if counts.size > 1:
            mixed.append(each[-1])
    return (float(np.mean(each)) if each else np.nan, float(np.mean(mixed)) if mixed else np.nan)


def _sizes(labels: NDArray[np.int16]) -> list[int]:
    """Return sizes from one cell up, each twice the one before, of which a side has four."""
    return [2**k for k in range(31) if 2**k * _LEAST_BOXES <= min(labels.shape)]


def dimension(labels: NDArray[np.int16]) -> Fit:
    """Count boxes with more than one basin: ``size ** -d`` of them."""
    sizes, counts = [], []
    for side in _sizes(labels)[1:]:
        boxes = _boxes(labels, side)
        kept = np.where(_is_basin(boxes), boxes, 0).astype(np.int32)
        largest = kept.max(axis=1)
        smallest = np.where(kept != 0, kept, np.iinfo(np.int32).max).min(axis=1)
        sizes.append(side)
        counts.append(float(((largest != smallest) & (kept != 0).any(axis=1)).sum()))
    return _fit(sizes, counts, sign=-1.0)


def uncertainty(labels: NDArray[np.int16]) -> Fit:
    """Count the part of the cells with another basin at a distance to either side: ``distance ** alpha`` of them.

    The cells are those as far from the edges as the largest distance, for all of them the same.
    """
    sizes, counts = [], []
    all_sizes = [size for size in _sizes(labels) if 8 * size <= min(labels.shape)]
    rim = all_sizes[-1] if all_sizes else 0
    for distance in all_sizes:
        uncertain = known = 0
        for own in (labels, labels.T):
            end = own.shape[1] - rim
            here, before, after = (own[:, rim + shift : end + shift] for shift in (0, -distance, distance))
            whole = _is_basin(here) & _is_basin(before) & _is_basin(after)
            uncertain += int((whole & ((here != before) | (here != after))).sum())
            known += int(whole.sum())
        sizes.append(distance)
        counts.append(uncertain / known if known else np.nan)
    return _fit(sizes, counts, sign=1.0)


def _fit(sizes: list[int], counts: list[float], sign: float) -> Fit:
    """Fit a power by least squares of the logarithms."""
    size, count = np.array(sizes, dtype=np.int64), np.array(counts, dtype=np.float64)
    usable = np.isfinite(count) & (count > 0)
    m = int(usable.sum())
    if m < 3:
        return Fit(np.nan, np.nan, size, count)
    x, y = np.log(size[usable]), np.log(count[usable])
    spread = ((x - x.mean()) ** 2).sum()
    slope = float(((x - x.mean()) * y).sum() / spread)
    rest = y - y.mean() - slope * (x - x.mean())
    error = float(np.sqrt((rest**2).sum() / (m - 2) / spread))
    return Fit(sign * slope, error, size, count)

"""Mode shapes over the coordinates; modes ascend in frequency, shapes are as the modes have them (mass-normalised)."""

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from vibroimpact.plot._axes import (
    MARKERS,
    ZERO_LABEL,
    axes_or_new,
    draw_legend,
    label_axis,
    next_line_style,
    with_defaults,
)
from vibroimpact.plot._data import Modes, require

FEW_MODES = 6  # drawn unless others are asked for: more lines cannot be told apart
FEW_COORDINATES = 40  # more are drawn without markers


def mode_shapes(
    modes: Modes,
    ax: Axes | None = None,
    *,
    indices: Sequence[int] | None = None,
    **line: Any,
) -> Axes:
    """Draw mode shapes over the coordinates, with frequencies and damping ratios in the legend.

    Parameters
    ----------
    modes : Modes
        Natural frequencies (n,), shapes (n, n) with one mode a column, damping ratios (n,).
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    indices : sequence of int, optional
        Modes to draw, each from 0 to n - 1; default: the lowest six, or all of fewer.
    **line
        Options of every line (`matplotlib.lines.Line2D`); a ``label`` is put before the name of each mode.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If an index is not one of a mode, `modes` are not modes, or `ax` is not an Axes.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> ax = vi.plot.mode_shapes(vi.modes(vi.LinearSystem([1, 1], [0, 0], [[2, -1], [-1, 2]])))
    >>> [text.get_text().split(":")[0] for text in ax.get_legend().get_texts()]
    ['mode 0', 'mode 1']
    """
    require(modes, "shapes", "modes must be the modes of a system")
    shapes = np.asarray(modes.shapes, dtype=float)
    n_coordinates, n_modes = shapes.shape
    chosen = list(range(min(n_modes, FEW_MODES))) if indices is None else [_mode(j, n_modes) for j in indices]
    is_new = ax is None
    ax = axes_or_new(ax)
    label_axis(ax, "x", "coordinate")
    label_axis(ax, "y", "mode shape")
    if not any(drawn.get_label() == ZERO_LABEL for drawn in ax.lines):
        ax.axhline(0.0, color="0.6", linewidth=0.8, linestyle="-", zorder=1.0, label=ZERO_LABEL)
    prefix = f"{line.pop('label')}, " if line.get("label") else ""
    for j in chosen:
        name = _mode_name(j, float(modes.natural_frequencies[j]), float(modes.damping_ratios[j]))
        marker = MARKERS[j % len(MARKERS)] if n_coordinates <= FEW_COORDINATES else "none"
        options = with_defaults(line, linestyle=next_line_style(ax), marker=marker)
        ax.plot(np.arange(n_coordinates), shapes[:, j], label=prefix + name, **options)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    draw_legend(ax, beside=is_new)
    return ax


def _mode(index: int, n_modes: int) -> int:
    """Return the index of a mode, or say what is wrong with it."""
    try:
        checked = operator.index(index)
    except TypeError:
        checked = -1
    if not 0 <= checked < n_modes:
        raise ValueError(f"indices must be from 0 to {n_modes - 1}, got {index!r}")
    return checked


def _mode_name(index: int, frequency: float, damping_ratio: float) -> str:
    """Name a mode by its frequency and, where it has one, its damping ratio (a rigid body has none)."""
    name = f"mode {index}: frequency {frequency:.4g}"
    return f"{name},\ndamping {damping_ratio:.3g}" if np.isfinite(damping_ratio) else name

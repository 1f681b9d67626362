"""Lyapunov exponents: of one motion, batch by batch, or of many over a number, with bars of their standard errors."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from vibroimpact.plot._axes import LINE_STYLES, MARKERS, ZERO_LABEL, axes_or_new, label_axis, with_defaults, with_unit
from vibroimpact.plot._data import FloatArray, LyapunovExponents, require

COLOURS = ("#1d3a66", "#d1603d", "#6fae8b", "#8d4a63")


def lyapunov(
    exponents: LyapunovExponents | tuple[ArrayLike, Sequence[LyapunovExponents]],
    ax: Axes | None = None,
    *,
    name: str = "parameter",
    **line: Any,
) -> Axes:
    """Draw Lyapunov exponents: of one motion over its batches, or of many over a number.

    Parameters
    ----------
    exponents : LyapunovExponents, or (values, sequence of LyapunovExponents)
        The result of ``vibroimpact.lyapunov_exponents``; or values of a number and a result for each. Those that are -inf, where
        contact takes directions away, are not drawn.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    name : str, default "parameter"
        What the values are those of.
    **line
        Options of the lines (`matplotlib.lines.Line2D`), such as ``color`` or ``linewidth``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If there is not one result for each value, or these have different numbers of exponents.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> forces = [5.0, 8.0, 9.0]
    >>> found = [vi.lyapunov_exponents(scene.replace(forcing_scale=f), [0], [0], (0, 900), skip=300) for f in forces]
    >>> vi.plot.lyapunov((forces, found), name="force").get_ylabel()
    'Lyapunov exponents'
    """
    if isinstance(exponents, tuple):
        x, rows, errors = _over_values(*exponents)
    else:
        require(exponents, "history", "exponents must be a result of vibroimpact.lyapunov_exponents, or (values, results)")
        name, rows = "batch", np.asarray(exponents.history, dtype=float)
        x, errors = np.arange(1.0, len(rows) + 1.0), None
    ax = axes_or_new(ax)
    label_axis(ax, "x", with_unit(name))
    label_axis(ax, "y", "Lyapunov exponents")
    if not any(drawn.get_label() == ZERO_LABEL for drawn in ax.lines):
        ax.add_line(
            Line2D([0.0, 1.0], [0.0, 0.0], transform=ax.get_yaxis_transform(), color="0.7", linewidth=0.8, label=ZERO_LABEL)
        )
    shown = np.where(np.isfinite(rows), rows, np.nan)
    for k in range(shown.shape[1]):
        usual: dict[str, Any] = {
            "color": COLOURS[k % len(COLOURS)],
            "linestyle": LINE_STYLES[k % len(LINE_STYLES)],
            "marker": MARKERS[k % len(MARKERS)],
            "markersize": 3.0,
            "label": f"$\\lambda_{{{k + 1}}}$",
        }
        options = with_defaults(line, **usual)
        ax.errorbar(x, shown[:, k], None if errors is None else errors[:, k], elinewidth=1.0, capsize=1.5, **options)
    ax.legend(fontsize="small")
    return ax


def _over_values(values: ArrayLike, results: Sequence[LyapunovExponents]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return values, exponents and errors in the order of the values."""
    x = np.asarray(values, dtype=float)
    if x.shape != (len(results),) or not len(results):
        raise ValueError(
            f"exponents must be (values, results), one result for each value, got {x.shape} values and {len(results)} results"
        )
    counts = {len(result.exponents) for result in results}
    if len(counts) != 1:
        raise ValueError(f"all results must have as many exponents, got {sorted(counts)}")
    order = np.argsort(x, kind="stable")
    rows, errors = (np.array([getattr(results[i], name) for i in order], dtype=float) for name in ("exponents", "errors"))
    return x[order], rows, np.where(np.isfinite(errors), errors, 0.0)

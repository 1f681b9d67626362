"""Basins: which states of a plane lead to which attractor, with the attractors where they lie in it."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from vibroimpact.plot._axes import MARKERS, axes_or_new, label_axis, with_unit
from vibroimpact.plot._data import Basins, require
from vibroimpact.plot._edges import edges

#: Of attractors, from dark to light and back, so that neighbours differ in grey too.
COLOURS = ("#1d3a66", "#f0c36b", "#b8503f", "#8ec6e6", "#5b3a6e", "#e8e0b0", "#3f6f2f", "#cf86c4")
#: What leads to none, by label.
OTHERS = {
    0: ("undecided", "#ffffff"),
    -1: ("lost", "#a9a9a9"),
    -2: ("inside a stop", "#565656"),
    -3: ("not worked out yet", "#eef1f4"),
}


def basins(basins: Basins, ax: Axes | None = None, *, legend: bool = True, **options: Any) -> Axes:
    """Draw which states lead to which attractor.

    Parameters
    ----------
    basins : Basins
        The result of ``vibroimpact.basins``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    legend : bool, default True
        Name the colours beside the plane: attractors by kind, period and the stops that they hit.
    **options
        Options of the cells (`matplotlib.axes.Axes.pcolormesh`), such as ``alpha``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If `basins` is no result of ``vibroimpact.basins``.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> ax = vi.plot.basins(vi.basins(scene, q=(-3, 1, 20), v=(-5, 5, 20)))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('q[0]', 'v[0]')
    """
    require(basins, "labels", "basins must be the result of vibroimpact.basins")
    x, y = np.asarray(basins.x, dtype=float), np.asarray(basins.y, dtype=float)
    labels = np.asarray(basins.labels)
    count = len(basins.attractors)
    ax = axes_or_new(ax)
    label_axis(ax, "x", with_unit(basins.x_name))
    label_axis(ax, "y", with_unit(basins.y_name))
    present = [label for label in (*range(1, count + 1), *OTHERS) if np.any(labels == label)]
    place = {label: k for k, label in enumerate(present)}
    codes = np.vectorize(place.__getitem__, otypes=[int])(labels)
    colours: dict[str, Any] = {
        "cmap": ListedColormap([_colour(label) for label in present]),
        "norm": BoundaryNorm(np.arange(len(present) + 1) - 0.5, len(present)),
        "rasterized": True,
    }
    columns, rows = np.argsort(x, kind="stable"), np.argsort(y, kind="stable")
    ax.pcolormesh(edges(x[columns], False), edges(y[rows], False), codes[np.ix_(rows, columns)], **(colours | options))
    limits = ax.axis()
    for k in range(count):
        _mark(ax, basins, k)
    ax.axis(limits)
    if legend:
        handles = [Patch(facecolor=_colour(label), edgecolor="0.3", label=_name(basins, label)) for label in present]
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, fontsize="small")
    return ax


def _colour(label: int) -> str:
    return COLOURS[(label - 1) % len(COLOURS)] if label > 0 else OTHERS[label][1]


def _name(basins: Basins, label: int) -> str:
    """Name what a label means: the kind of an attractor, its period, what it hits."""
    if label <= 0:
        return OTHERS[label][0]
    one = basins.attractors[label - 1]
    period = f" {one.n_periods}" if one.n_periods else ""
    hits = f", hits {', '.join(map(str, one.pattern))}" if one.pattern else ""
    return f"{one.kind}{period}{hits}"


def _mark(ax: Axes, basins: Basins, k: int) -> None:
    """Mark the points of an attractor where both axes are coordinates of the state."""
    names = (basins.x_name, basins.y_name)
    if any("[" not in name for name in names):
        return
    points = np.asarray(basins.attractors[k].points, dtype=float)
    n = points.shape[1] // 2
    x, y = (points[:, int(name[2:-1]) + (n if name[0] == "v" else 0)] for name in names)
    is_set = basins.attractors[k].n_periods == 0
    size = 2.0 if is_set else 7.0
    marker = "." if is_set else MARKERS[k % len(MARKERS)]
    ax.plot(
        x,
        y,
        linestyle="none",
        marker=marker,
        markersize=size,
        color=_colour(k + 1),
        markeredgecolor="white",
        label=f"_attractor {k}",
    )

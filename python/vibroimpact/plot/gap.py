"""The gap of a stop over time, the solid below zero."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import (
    WALL_COLOUR,
    WALL_WIDTH,
    ZERO_LABEL,
    axes_or_new,
    label_axis,
    label_once,
    next_line_style,
    solid_side,
    with_defaults,
)
from vibroimpact.plot._contact import draw_impacts
from vibroimpact.plot._data import Orbit, Trajectory
from vibroimpact.plot._impacts import impacts_of
from vibroimpact.plot._timeline import check_stop, timeline


def gap(
    motion: Orbit | Trajectory,
    stop: int,
    ax: Axes | None = None,
    *,
    t_span: tuple[float, float] | None = None,
    impacts: bool = True,
    **line: Any,
) -> Axes:
    """Draw the gap of a stop over time: how far a damper's ball is from its wall.

    Parameters
    ----------
    motion : Orbit or Trajectory
        An orbit, or a trajectory that kept its motion.
    stop : int
        Index of the stop, from 0.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    t_span : (float, float), optional
        First and last time drawn; default: one period of an orbit, the whole of a trajectory.
    impacts : bool, default True
        Mark the impacts on the stop by dots.
    **line
        Options of the line (`matplotlib.lines.Line2D`), such as ``color`` or ``label``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If an argument is outside the values above, or the motion was not kept.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> orbit = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
    >>> ax = vi.plot.gap(orbit, 1)
    >>> bool(min(ax.lines[0].get_ydata()) > -1e-9)
    True
    """
    index = check_stop(motion, stop)
    t, values = timeline(motion, lambda times: motion.gap(index, times), t_span)
    t, values = t[np.isfinite(values)], values[np.isfinite(values)]  # a gap does not jump
    ax = axes_or_new(ax)
    label_axis(ax, "x", "time t")
    label_axis(ax, "y", f"gap h[{index}]")
    drawn = ax.plot(t, values, **with_defaults(line, linestyle=next_line_style(ax), label=f"h[{index}]"))[0]
    if impacts:
        times, stops = impacts_of(motion, float(t[0]), float(t[-1]))
        hits = times[(stops == index) & (times >= t[0]) & (times <= t[-1])]
        draw_impacts(ax, drawn, hits, np.zeros_like(hits))
    if label_once(ax, ZERO_LABEL) == ZERO_LABEL:
        effects = solid_side(left=False)
        ax.axhline(0.0, color=WALL_COLOUR, linewidth=WALL_WIDTH, label=ZERO_LABEL, zorder=1.5, path_effects=effects)
    return ax

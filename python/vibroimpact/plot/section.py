"""Stroboscopic sections of forced motions.

The points are the states at whole forcing periods, t = 0, T0, 2 T0, ... with T0 = 2 pi / frequency; one that falls on
an impact is taken right after it.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from vibroimpact.plot._axes import (
    SECTION_LABEL,
    axes_or_new,
    label_axis,
    next_section_marker,
    with_defaults,
)
from vibroimpact.plot._data import Orbit, Trajectory, is_orbit
from vibroimpact.plot._direction import check_direction
from vibroimpact.plot._sampling import not_a_motion, poincare_states, window
from vibroimpact.plot._walls import draw_walls

MANY_POINTS = 100  # more are drawn small
WALL_TIMES = 1000  # at which it is asked where a stop that moves is


def poincare_section(
    motion: Orbit | Trajectory,
    ax: Axes | None = None,
    *,
    along: ArrayLike = 0,
    t_span: tuple[float, float] | None = None,
    walls: bool = False,
    **line: Any,
) -> Axes:
    """Draw the states of one coordinate, or along a direction, at whole forcing periods.

    Parameters
    ----------
    motion : Orbit or Trajectory
        A forced motion: an orbit gives `n_periods` points; a trajectory one for each whole forcing period in its times
        (under a ramp of the frequency or phase: each whole turn of the angle),
        or, where its motion was not kept, those among its rows (``t_eval=scene.period * np.arange(k)``).
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    along : int or array_like, shape (n_dof,), default 0
        What is drawn: a coordinate by its index, from 0 to n_dof - 1, or the motion along a direction n, ``n.q``.
    t_span : (float, float), optional
        Times of a trajectory between which points are taken, to leave out a transient; default: all.
    walls : bool, default False
        Draw the stops whose normal `along` is as vertical lines.
    **line
        Options of the markers (`matplotlib.lines.Line2D`), such as ``marker`` or ``markersize``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If the motion is not forced or has no such points, or an argument is outside the values above.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> orbits = vi.periodic_orbits(scene, pattern=[1], n_periods=2)
    >>> ax = vi.plot.poincare_section(orbits[0], along=1)
    >>> len(ax.lines[0].get_xdata())
    2
    """
    if not hasattr(motion, "scene"):
        raise not_a_motion(motion)
    direction = check_direction(along, motion.scene.n_dof)
    q, v = poincare_states(motion, direction, t_span)
    if len(q) == 0:
        raise ValueError(
            "trajectory must have states at whole forcing periods, got none: "
            "simulate with keep='motion', for longer, or with t_eval=scene.period * np.arange(k)"
        )
    ax = axes_or_new(ax)
    label_axis(ax, "x", direction.position_label)
    label_axis(ax, "y", direction.velocity_label)
    options = with_defaults(
        line,
        linestyle="none",
        marker=next_section_marker(ax),
        markersize=6.0 if len(q) <= MANY_POINTS else 2.0,
        label=SECTION_LABEL,
    )
    ax.plot(q, v, **options)
    if walls:
        span = window(motion, None if is_orbit(motion) else t_span)
        draw_walls(ax, motion, direction, np.linspace(*span, WALL_TIMES), along="x")
    return ax

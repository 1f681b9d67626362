"""The force of a stop in lasting contact over time."""

from typing import Any

from matplotlib.axes import Axes

from vibroimpact.plot._axes import axes_or_new, label_axis, next_line_style, with_defaults
from vibroimpact.plot._data import Orbit, Trajectory
from vibroimpact.plot._timeline import check_stop, timeline


def contact_force(
    motion: Orbit | Trajectory,
    stop: int,
    ax: Axes | None = None,
    *,
    t_span: tuple[float, float] | None = None,
    **line: Any,
) -> Axes:
    """Draw the force of a stop in lasting contact over time; it is zero elsewhere, impacts have impulses.

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
    >>> ball = vi.LinearSystem(1.0, 0.0, 0.0, load=[-1.0])            # held by a shaken table for a part of each period
    >>> scene = vi.Scene(ball, vi.Harmonic(1.3, 1.0), vi.Stop(0, 0.0, 0.5, side="lower"))
    >>> ax = vi.plot.contact_force(vi.simulate(scene, 0.3, 0.0, (0, 40)), 0)
    >>> ax.get_ylabel()
    'contact force L[0]'
    """
    index = check_stop(motion, stop)
    t, values = timeline(motion, lambda times: motion.contact_force(index, times), t_span)
    ax = axes_or_new(ax)
    label_axis(ax, "x", "time t")
    label_axis(ax, "y", f"contact force L[{index}]")
    ax.plot(t, values, **with_defaults(line, linestyle=next_line_style(ax), label=f"L[{index}]"))
    return ax

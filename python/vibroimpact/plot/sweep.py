"""Responses along a ramp: how far a motion swings in each forcing period, over the number that drifts.

The periods are the whole turns of the forcing's angle, also where its frequency drifts; the swing is half of the distance
between the highest and the lowest of samples at equal steps in one. Up and down, drawn on one Axes, show where the motion jumps.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from vibroimpact.plot._axes import axes_or_new, label_axis, next_line_style, with_defaults, with_unit
from vibroimpact.plot._data import Ramped, is_trajectory
from vibroimpact.plot._direction import check_direction
from vibroimpact.plot._sampling import forcing_turns, ramps_of, window

PER_PERIOD = 48  # samples in a forcing period: the highest of a sine is off by 0.2 % at most
MOST_PERIODS = 1 << 11  # of which a swing is drawn


def sweep(trajectory: Ramped, along: ArrayLike = 0, ax: Axes | None = None, *, parameter: str | None = None, **line: Any) -> Axes:
    """Draw how far a trajectory under a ramp swings in each forcing period, over the number that drifts.

    Parameters
    ----------
    trajectory : Trajectory
        A trajectory with a ramp, of a scene with a forcing period, that kept its motion.
    along : int or array_like, shape (n_dof,), default 0
        What is drawn: a coordinate by its index, from 0 to n_dof - 1, or the motion along a direction n, ``n.q``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    parameter : str, optional
        The number over which it is drawn, where several drift; default: the first.
    **line
        Options of the line (`matplotlib.lines.Line2D`), such as ``color`` or ``label``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If the trajectory has no ramp, no forcing period, less than a period, or did not keep its motion.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.04, 1.0), vi.Harmonic([0.1], 0.8), vi.Stop(0, 0.8, 0.9))
    >>> up = vi.simulate(scene, 0.0, 0.0, (0, 1500), ramp=vi.Ramp("frequency", 1.3, rate=4e-4))
    >>> w, swing = vi.plot.sweep(up).lines[0].get_data()
    >>> bool(w[swing.argmax()] > 1.0)                              # it climbs beyond the free resonance, and falls
    True
    """
    if not is_trajectory(trajectory):
        raise ValueError(f"trajectory must be one trajectory, got {type(trajectory).__name__}")
    direction = check_direction(along, trajectory.scene.n_dof)
    ramps = ramps_of(trajectory)
    if not ramps:
        raise ValueError("trajectory must have a ramp: simulate with ramp=Ramp(...)")
    if trajectory.scene.period is None:
        raise ValueError("trajectory must be of a scene with a forcing period")
    name = ramps[0].parameter if parameter is None else parameter
    turns = forcing_turns(trajectory, *window(trajectory, None))
    if len(turns) < 2:
        raise ValueError("trajectory must last for a forcing period")
    drawn = np.unique(np.linspace(0, len(turns) - 2, MOST_PERIODS).astype(int))
    starts, periods = turns[drawn], turns[drawn + 1] - turns[drawn]
    times = starts[:, None] + periods[:, None] * np.linspace(0.0, 1.0, PER_PERIOD)
    rows = direction.of(trajectory.position(times.ravel())).reshape(times.shape)
    values = trajectory.parameter(starts + 0.5 * periods, name)
    ax = axes_or_new(ax)
    label_axis(ax, "x", with_unit(name))
    label_axis(ax, "y", f"swing of {direction.position_label}")
    label = f"{direction.position}, {'up' if values[-1] >= values[0] else 'down'}"
    ax.plot(values, 0.5 * np.ptp(rows, axis=1), **with_defaults(line, linestyle=next_line_style(ax), label=label))
    return ax

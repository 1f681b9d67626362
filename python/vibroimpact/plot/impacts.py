"""Speeds of impacts over time, stop by stop."""

from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import MARKERS, STOP_LABEL, axes_or_new, draw_legend, label_axis, with_defaults
from vibroimpact.plot._data import FloatArray, Orbit, Trajectory, is_orbit

STEMS_LABEL = "_stems"
MANY_IMPACTS = 300  # more are drawn as dots, without stems
FEW_SIZE = 5.0  # of their markers [points]
CROWD = 3000  # more are drawn as the smallest dots


def impact_speeds(
    data: Orbit | Trajectory,
    ax: Axes | None = None,
    *,
    side: Literal["before", "after"] = "before",
    **line: Any,
) -> Axes:
    """Draw the normal speed of every impact over its time, each stop with its own marker.

    Up to 300 impacts stand on stems; more are dots. The time is that of the whole run.

    Parameters
    ----------
    data : Orbit or Trajectory
        An orbit, whose impacts of one period are drawn, or a trajectory that kept its impacts.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    side : {"before", "after"}, default "before"
        The speed towards the stop before each impact, or the one away from it after.
    **line
        Options of the markers (`matplotlib.lines.Line2D`); a ``label`` is put before the name of each stop.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If `data` are neither an orbit nor a trajectory or have not kept their impacts, or `side` is another word.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> orbit = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
    >>> ax = vi.plot.impact_speeds(vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 20.5 * orbit.period)))
    >>> len(ax.lines[0].get_xdata())
    20
    """
    impacts = getattr(data, "impacts", None)
    if impacts is None:
        raise ValueError(f"data must be an orbit or a trajectory, got {type(data).__name__}")
    if side not in ("before", "after"):
        raise ValueError(f"side must be 'before' or 'after', got {side!r}")
    n_counted = getattr(getattr(data, "stats", None), "n_impacts", 0)
    if len(impacts) == 0 < n_counted:
        raise ValueError(
            f"trajectory must have kept its impacts, got none of {n_counted}: simulate with keep='motion' or keep='impacts'"
        )
    is_new = ax is None
    ax = axes_or_new(ax)
    label_axis(ax, "x", "time t")
    label_axis(ax, "y", f"normal speed {side} impact")
    prefix = f"{line.pop('label')}, " if line.get("label") else ""
    for index in np.unique(impacts["stop"]):
        of_stop = impacts[impacts["stop"] == index]
        label = f"{prefix}{STOP_LABEL}{index}"
        _draw(
            ax, of_stop["time"], of_stop[f"speed_{side}"], len(impacts), {**line, "label": label}, MARKERS[index % len(MARKERS)]
        )
    if len(impacts):
        ax.update_datalim([(t, 0.0) for t in _span(data)])
        ax.autoscale_view()
        ax.set_ylim(bottom=0.0, auto=None)  # more data may still move the top
        draw_legend(ax, beside=is_new, markerscale=FEW_SIZE / _marker_size(len(impacts)))
    else:
        ax.text(0.5, 0.5, "no impacts", transform=ax.transAxes, ha="center", va="center")
    return ax


def _span(data: Orbit | Trajectory) -> tuple[float, float]:
    """Return the time that a motion takes: one period of an orbit, the whole of a run as far as that is known."""
    if is_orbit(data):
        return 0.0, float(data.period)
    first: Any = data
    try:
        start = float(first.segments["start"][0])
    except (AttributeError, ValueError, IndexError):  # not kept
        start = float(data.impacts["time"][0])
    return start, float(getattr(data, "t_end", start))


def _marker_size(n_drawn: int) -> float:
    """Choose the size of the markers by their number [points]."""
    if n_drawn <= MANY_IMPACTS:
        return FEW_SIZE
    return 2.5 if n_drawn <= CROWD else 2.0


def _draw(ax: Axes, t: FloatArray, speed: FloatArray, n_drawn: int, line: dict[str, Any], marker: str) -> None:
    """Draw the impacts of one stop: markers, and stems where they can be told apart."""
    size = _marker_size(n_drawn)
    edge = 1.0 if n_drawn <= CROWD else 0.0
    options = with_defaults(line, linestyle="none", marker=marker, markersize=size, markeredgewidth=edge)
    markers = ax.plot(t, speed, **options)[0]
    if n_drawn <= MANY_IMPACTS:
        gap = np.full(len(t), np.nan)
        ax.plot(
            np.column_stack([t, t, gap]).ravel(),
            np.column_stack([np.zeros(len(t)), speed, gap]).ravel(),
            color=markers.get_color(),
            linewidth=1.0,
            linestyle="-",
            label=STEMS_LABEL,
            zorder=markers.get_zorder() - 0.1,
        )

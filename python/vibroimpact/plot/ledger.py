"""The energy ledger of a motion over time: what is stored, what the forcing brought, what dampers and impacts took."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import axes_or_new, draw_legend, label_axis, next_line_style, with_defaults
from vibroimpact.plot._data import FloatArray, Orbit, Trajectory
from vibroimpact.plot._sampling import unseen_jumps

#: Attribute of the ledger, its name in the legend, whether an impact makes it jump.
CURVES = (
    ("kinetic", "kinetic", True),
    ("potential", "potential", False),
    ("stored", "kinetic + potential", True),
    ("forcing_work", "work of the forcing", False),
    ("damping_loss", "lost in dampers", False),
    ("impact_loss", "lost at impacts", True),
)


def energy(data: Trajectory | Orbit, ax: Axes | None = None, **line: Any) -> Axes:
    """Draw the energy ledger of a trajectory, or of one period of an orbit, over time.

    What is stored, kinetic + potential, is what was stored at the start, and the work of the forcing, less what was lost in
    dampers and at impacts. Where the trajectory has both sides of an impact the lines step down or up at its time; where
    it has not (rows at ``t_eval``), the lines that jump are broken there.

    Parameters
    ----------
    data : Trajectory or Orbit
        A trajectory with ``keep="motion"``, its ledger at its times ``t``; or an orbit, from right after its first impact on.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    **line
        Options of every line (`matplotlib.lines.Line2D`); a ``label`` is put before the name of each.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If `data` is no trajectory and no orbit, has not kept its motion, or has no ledger (a system given by functions).

    Notes
    -----
    Without ``t_eval`` a flight has at most 200 rows: for a smooth line over a flight of many waves give ``t_eval``.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> run = vi.simulate(vi.paper_scene(kind=3, linear=False), [0, 0], [0.2, 0.1], (0, 50))
    >>> ax = vi.plot.energy(run)
    >>> [line.get_label() for line in ax.lines][:3]
    ['kinetic', 'potential', 'kinetic + potential']
    """
    ledger = getattr(data, "energy", None)
    if ledger is None:
        raise ValueError(f"data must be a trajectory, with keep='motion', or an orbit, got {type(data).__name__}")
    t = np.asarray(data.t if hasattr(data, "t") else ledger.t, dtype=float)
    breaks = unseen_jumps(t, np.unique(data.impacts["time"]))
    is_new = ax is None
    ax = axes_or_new(ax)
    label_axis(ax, "x", "time t")
    label_axis(ax, "y", "energy")
    prefix = f"{line.pop('label')}, " if line.get("label") else ""
    for attribute, name, jumps in CURVES:
        values = ledger.kinetic + ledger.potential if attribute == "stored" else getattr(ledger, attribute)
        _draw(ax, t, np.asarray(values, dtype=float), breaks if jumps else breaks[:0], {**line, "label": prefix + name})
    draw_legend(ax, beside=is_new)
    return ax


def _draw(ax: Axes, t: FloatArray, values: FloatArray, breaks: np.ndarray[Any, Any], line: dict[str, Any]) -> None:
    """Draw one line, broken before the rows `breaks`; a row with a break on either side is a dot."""
    edges = np.concatenate([[0], breaks, [len(t)]])
    alone = (edges[:-1] + np.arange(len(edges) - 1))[np.diff(edges) == 1]
    options = with_defaults(line, linestyle=next_line_style(ax))
    if len(alone):
        options = with_defaults(options, marker=".", markevery=alone.tolist())
    ax.plot(np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan), **options)

"""The energy ledger of a motion over time: what is stored, what the forcing brought, what dampers and impacts took."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import axes_or_new, label_axis, next_line_style, with_defaults
from vibroimpact.plot._data import FloatArray, Orbit, Trajectory
from vibroimpact.plot._sampling import unseen_jumps

#: Attribute of the ledger, its name in the legend, whether an impact makes it jump: what is stored, and what came and went.
STORED = (("kinetic", "kinetic", True), ("potential", "potential", False), ("stored", "kinetic + potential", True))
EXCHANGED = (
    ("forcing_work", "work of the forcing", False),
    ("damping_loss", "lost in dampers", False),
    ("impact_loss", "lost at impacts", True),
)
#: By what the lower of two panels is known again.
LOWER = "energy exchanged"


def energy(data: Trajectory | Orbit, ax: Axes | None = None, **line: Any) -> Axes:
    """Draw the energy ledger of a trajectory, or of one period of an orbit, over time, in two panels.

    What is stored, kinetic + potential, is in the upper one; in the lower one what the forcing brought and what was lost in
    dampers and at impacts, which together say how far what is stored is from what it was at the start. Where the trajectory
    has both sides of an impact the lines step down or up at its time; where it has not (rows at ``t_eval``), the lines that
    jump are broken there.

    Parameters
    ----------
    data : Trajectory or Orbit
        A trajectory with ``keep="motion"``, its ledger at its times ``t``; or an orbit, from right after its first impact on.
    ax : matplotlib.axes.Axes, optional
        Where to draw, the lower half of which becomes the lower panel; default: a new figure.
    **line
        Options of every line (`matplotlib.lines.Line2D`); a ``label`` is put before the name of each.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure, the upper panel; the lower one is the next of its figure's ``axes``.

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
    ax = axes_or_new(ax)
    lower = _lower(ax)
    for panel in (ax, lower):
        label_axis(panel, "x", "time t")
    ax.xaxis.label.set_visible(False)
    label_axis(ax, "y", "energy")
    label_axis(lower, "y", "energy exchanged")
    prefix = f"{line.pop('label')}, " if line.get("label") else ""
    for panel, curves in ((ax, STORED), (lower, EXCHANGED)):
        for attribute, name, jumps in curves:
            values = ledger.kinetic + ledger.potential if attribute == "stored" else getattr(ledger, attribute)
            _draw(panel, t, np.asarray(values, dtype=float), breaks if jumps else breaks[:0], {**line, "label": prefix + name})
        panel.legend(fontsize="small", loc="upper left", framealpha=0.8)
    return ax


def _lower(ax: Axes) -> Axes:
    """Return the panel below `ax` that shares its time: one that was made before, or the lower half of its room."""
    siblings: list[Axes] = ax.get_shared_x_axes().get_siblings(ax)
    for other in siblings:
        if other.get_gid() == LOWER:
            return other
    assert ax.figure is not None  # axes_or_new refuses Axes without a figure
    spec = ax.get_subplotspec()
    if spec is None:
        box = ax.get_position()
        lower: Axes = ax.figure.add_axes((box.x0, box.y0, box.width, 0.47 * box.height), sharex=ax)
        ax.set_position((box.x0, box.y0 + 0.53 * box.height, box.width, 0.47 * box.height))
    else:
        halves = spec.subgridspec(2, 1)
        ax.set_subplotspec(halves[0])
        lower = ax.figure.add_subplot(halves[1], sharex=ax)
    lower.set_gid(LOWER)
    ax.tick_params(labelbottom=False)
    return lower


def _draw(ax: Axes, t: FloatArray, values: FloatArray, breaks: np.ndarray[Any, Any], line: dict[str, Any]) -> None:
    """Draw one line, broken before the rows `breaks`; a row with a break on either side is a dot."""
    edges = np.concatenate([[0], breaks, [len(t)]])
    alone = (edges[:-1] + np.arange(len(edges) - 1))[np.diff(edges) == 1]
    options = with_defaults(line, linestyle=next_line_style(ax))
    if len(alone):
        options = with_defaults(options, marker=".", markevery=alone.tolist())
    ax.plot(np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan), **options)

"""Bifurcation diagrams: what a motion settles on, over the values of a number of its scene; up and down differ in mark."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from vibroimpact.plot._axes import axes_or_new, label_axis, with_defaults, with_unit
from vibroimpact.plot._data import BifurcationDiagram, require
from vibroimpact.plot._direction import check_direction

#: Of each way its name, colour and mark: a dot on an open ring where both agree.
WAYS = {1: ("up", "#1d3a66", "."), -1: ("down", "#d1603d", "o")}
MARK = 2.0  # of a dot [points]


def bifurcation_diagram(diagram: BifurcationDiagram, ax: Axes | None = None, *, along: ArrayLike = 0, **marks: Any) -> Axes:
    """Draw what a motion settles on over the values of a number.

    Parameters
    ----------
    diagram : BifurcationDiagram
        The result of ``vibroimpact.bifurcation_diagram``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    along : int, array_like of shape (n_dof,), or "speed_before", default 0
        What is drawn: a coordinate by its index, the position along a direction, or the speed of impacts.
    **marks
        Options of the marks (`matplotlib.lines.Line2D`), such as ``markersize`` or ``color``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If `diagram` is none, or `along` is no direction of it.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> diagram = vi.bifurcation_diagram(scene, ("forcing_scale", np.linspace(4, 9, 11)), transient=50, periods=20)
    >>> vi.plot.bifurcation_diagram(diagram).get_xlabel()
    'forcing_scale [-]'
    """
    require(diagram, "speed_before", "diagram must be the result of vibroimpact.bifurcation_diagram")
    require(diagram, "n_periods", "diagram must be the result of vibroimpact.bifurcation_diagram")
    if isinstance(along, str):
        if along != "speed_before":
            raise ValueError(f'along must be an index, a direction or "speed_before", got {along!r}')
        values, label = diagram.speed_before, "speed before impact"
    else:
        direction = check_direction(along, diagram.q.shape[1])
        values, label = direction.of(diagram.q), direction.position_label
    ax = axes_or_new(ax)
    label_axis(ax, "x", with_unit(getattr(diagram, "name", None) or "parameter"))
    label_axis(ax, "y", label)
    ways = np.unique(diagram.direction)
    for way in sorted(ways):  # downwards first: its rings do not hide dots
        name, colour, marker = WAYS[int(way)]
        mine = diagram.direction[diagram.index] == way
        is_ring = marker == "o"
        usual: dict[str, Any] = {
            "linestyle": "none",
            "marker": marker,
            "color": colour,
            "markersize": 1.5 * MARK if is_ring else MARK,
            "markeredgewidth": 0.5,
            "label": name if len(ways) > 1 else "_points",
        } | ({"markerfacecolor": "none"} if is_ring else {})
        ax.plot(diagram.parameter[diagram.index][mine], values[mine], **with_defaults(marks, **usual))
    if len(ways) > 1:
        ax.legend(fontsize="small", markerscale=2.0)
    return ax

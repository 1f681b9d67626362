"""Curves in two numbers: where special points of branches lie."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import axes_or_new, label_axis, label_once, with_defaults, with_unit
from vibroimpact.plot._data import Curve, require
from vibroimpact.plot.branch import MARKS

#: Of each kind of curve its colour, its line and its name.
LINES: dict[str, tuple[str, Any, str]] = {
    "fold": ("#0072b2", "-", "fold"),
    "period_doubling": ("#d55e00", "--", "period doubling"),
    "torus": ("#565656", (0.0, (7.0, 1.5, 1.0, 1.5, 1.0, 1.5)), "torus"),
    "pitchfork": ("#8d4a63", (0.0, (3.0, 1.0)), "pitchfork"),
    "touch": ("#009e73", (0.0, (5.0, 1.5)), "touch"),
    "border_collision": ("#009e73", (0.0, (1.5, 1.0)), "border collision"),
    "graze": ("#009e73", "-", "graze"),
    "lost_impact": ("#8a1f5c", "--", "lost impact"),
    "corner": ("#c98600", "-.", "corner"),
    "together": ("#1d3a66", "-.", "stops hit together"),
}
#: Of each kind of point at which two things happen its mark.
TWO_AT_ONCE = {
    "cusp": "*",
    "strong_1_1": "$1$",
    "strong_1_2": "$2$",
    "strong_1_3": "$3$",
    "strong_1_4": "$4$",
    "fold_flip": "s",
    "resonant_graze": "o",
    "graze_fold": "<",
    "double_graze": ">",
    "degenerate_graze": "P",
    "graze_corner": "d",
}


def bifurcation_curves(curves: Curve | Iterable[Curve], ax: Axes | None = None, **line: Any) -> Axes:
    """Draw curves on which special points of branches lie, over both numbers.

    Parameters
    ----------
    curves : BifurcationCurve or iterable of BifurcationCurve
        Results of ``vibroimpact.bifurcation_curve`` over the same two numbers.
    ax : matplotlib.axes.Axes, optional
        Where to draw, such as on an existence map; default: a new figure.
    **line
        Options of the lines (`matplotlib.lines.Line2D`), such as ``color`` or ``linewidth``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure. Parts whose orbits break a rule of contact are dotted.

    Raises
    ------
    ValueError
        If `curves` has something else.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> branch = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.1, 1.5))
    >>> plane = ("frequency", "forcing_scale"), ((2.1, 3.0), (0.1, 2.0))
    >>> vi.plot.bifurcation_curves(vi.bifurcation_curve(branch.special[1], *plane)).get_xlabel()
    'frequency [rad/s]'
    """
    every: tuple[Any, ...] = (
        (curves,) if hasattr(curves, "parameter_names") else tuple(curves) if isinstance(curves, Iterable) else ()
    )
    if not every or not all(hasattr(own, "parameter_names") for own in every):
        require(curves, "parameter_names", "curves must be results of vibroimpact.bifurcation_curve, one at least")
    ax = axes_or_new(ax)
    for own in every:
        names = own.parameter_names or ("first parameter", "second parameter")
        label_axis(ax, "x", with_unit(names[0]))
        label_axis(ax, "y", with_unit(names[1]))
        colour, style, name = LINES[own.kind]
        for is_virtual, drawn in ((False, style), (True, ":")):
            mine = own.is_virtual == is_virtual
            if not mine.any():
                continue
            # A chord between two parts is drawn as the one that breaks a rule.
            ends = mine if not is_virtual else mine | np.append(mine[1:], False) | np.append(False, mine[:-1])
            x, y = np.where(ends, own.x, np.nan), np.where(ends, own.y, np.nan)
            label = label_once(ax, f"{name}, virtual" if is_virtual else name)
            usual: dict[str, Any] = {"color": colour, "linestyle": drawn, "linewidth": 1.4, "label": label}
            ax.plot(x, y, **with_defaults(line, **usual))
        for point in own.special:
            x, y = point.parameter
            mark = TWO_AT_ONCE.get(point.kind) or MARKS[point.kind][0]
            label = label_once(ax, point.kind.replace("_", " "))
            ax.plot(x, y, linestyle="none", marker=mark, color="black", markerfacecolor="white", label=label)
    ax.legend(fontsize="small")
    return ax

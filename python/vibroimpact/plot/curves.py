"""Curves in two numbers: where special points of branches lie."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import axes_or_new, label_axis, label_once, with_defaults
from vibroimpact.plot._data import Curve, require

#: Of each kind of curve its colour, its line and its name.
LINES = {
    "fold": ("C0", "-", "fold"),
    "period_doubling": ("C1", "-", "period doubling"),
    "torus": ("C7", "-", "torus"),
    "pitchfork": ("C4", "-", "pitchfork"),
    "graze": ("C2", "--", "graze"),
    "lost_impact": ("C3", "--", "lost impact"),
    "corner": ("C5", "-.", "corner"),
    "together": ("C6", "-.", "stops hit together"),
}
#: Of each kind of point at which two things happen its mark.
MARKS = {"fold_flip": "s", "resonant_graze": "o", "graze_fold": "^", "graze_corner": "D"}


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
    'frequency'
    """
    every: tuple[Any, ...] = (
        (curves,) if hasattr(curves, "parameter_names") else tuple(curves) if isinstance(curves, Iterable) else ()
    )
    if not every or not all(hasattr(own, "parameter_names") for own in every):
        require(curves, "parameter_names", "curves must be results of vibroimpact.bifurcation_curve, one at least")
    ax = axes_or_new(ax)
    for own in every:
        names = own.parameter_names or ("first parameter", "second parameter")
        label_axis(ax, "x", names[0])
        label_axis(ax, "y", names[1])
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
            label = label_once(ax, point.kind.replace("_", " "))
            ax.plot(x, y, linestyle="none", marker=MARKS[point.kind], color="black", markerfacecolor="white", label=label)
    ax.legend(fontsize="small")
    return ax

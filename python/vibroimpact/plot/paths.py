"""Multipliers along a branch: where they leave the unit circle."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection

from vibroimpact.plot._axes import axes_or_new, with_defaults
from vibroimpact.plot._data import Branch, require
from vibroimpact.plot.stability import draw_circle


def multiplier_paths(branch: Branch, ax: Axes | None = None, *, limit: float = 2.0, **options: Any) -> Axes:
    """Draw the multipliers of all orbits of a branch in the complex plane, coloured by the branch's number.

    Parameters
    ----------
    branch : Branch
        The result of ``vibroimpact.continuation``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    limit : float, default 2.0
        Half the width of the square that is drawn; next to a graze multipliers grow without bound.
    **options
        Options of the markers (`matplotlib.axes.Axes.scatter`), such as ``s`` or ``cmap``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure, which has a bar for the number; its two axes have one scale.

    Raises
    ------
    ValueError
        If `branch` is none, or has no multipliers, as one of many modes; if `limit` is not above 0 and finite.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> found = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.1, 1.5))
    >>> vi.plot.multiplier_paths(found).get_xlabel()
    'real part of multiplier'
    """
    require(branch, "arclength", "branch must be the result of vibroimpact.continuation")
    if not 0.0 < limit < np.inf:
        message = f"limit must be above 0 and finite, got {limit!r}"
        raise ValueError(message)
    if not np.isfinite(branch.multipliers).any():
        message = f"branch is {branch!r}, whose multipliers are only counted (many modes): draw those of its orbits"
        raise ValueError(message)
    is_new = ax is None
    ax = axes_or_new(ax)
    draw_circle(ax)
    found = np.asarray(branch.multipliers)
    number = np.repeat(branch.parameter[:, None], found.shape[1], axis=1)
    drawn = np.isfinite(found)
    usual: dict[str, Any] = {"s": 8.0, "cmap": "viridis"}
    points = found[drawn]
    markers = ax.scatter(points.real, points.imag, c=number[drawn], **with_defaults(options, PathCollection, **usual))
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit))
    ax.set_aspect("equal")
    if is_new and ax.figure is not None:
        ax.figure.colorbar(markers, ax=ax, label=branch.parameter_name or "parameter")
    return ax

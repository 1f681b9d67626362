"""Floquet multipliers of an orbit against the unit circle: inside it a small deviation dies out."""

from collections.abc import Hashable, Iterable
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.legend import Legend
from matplotlib.patches import Circle
from numpy.typing import NDArray

from vibroimpact.plot._axes import MARKERS, axes_or_new, draw_legend, label_axis, with_defaults
from vibroimpact.plot._data import FloatArray, StableOrbit, require

MARKER_AREA = 55.0  # [points^2]
TEXT_WIDTH = 34  # of the lines that say why there are none [characters]
MOST_LABELS = 10  # values that are written at their points
CLOSE = 0.04  # nearer to each other than this part of the width two are drawn again, larger
ROOM = 1.08  # width of the square drawn, in that of the circle and the points


def draw_circle(ax: Axes) -> None:
    """Draw the unit circle of the plane of multipliers, with its axes."""
    label_axis(ax, "x", "real part of multiplier")
    label_axis(ax, "y", "imaginary part of multiplier")
    ax.axhline(0.0, color="0.8", linewidth=0.8, zorder=0.5)
    ax.axvline(0.0, color="0.8", linewidth=0.8, zorder=0.5)
    ax.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor="0.35", linewidth=1.2, linestyle="--"))


def multipliers(orbit: StableOrbit, ax: Axes | None = None, **options: Any) -> Axes:
    """Draw the Floquet multipliers of an orbit in the complex plane, with the unit circle.

    Stops hit at one instant can be taken in several orders, and a deviation meets one or another: each order has its
    own marker and its own largest modulus in the legend. The values stand at their points, and two that are close are drawn
    again, larger, in a corner. Where the multipliers are undefined, the figure says so.

    Parameters
    ----------
    orbit : Orbit
        An orbit; its multipliers are computed when first asked for.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    **options
        Options of the markers (`matplotlib.axes.Axes.scatter`), such as ``s`` or ``marker``; a ``label`` is put before
        the name of each order.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure; its two axes have one scale.

    Raises
    ------
    ValueError
        If `orbit` is not one orbit, or `ax` is not an Axes.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> orbits = vi.periodic_orbits(scene, pattern=[1], n_periods=2)
    >>> ax = vi.plot.multipliers(orbits[0])
    >>> len(ax.collections[0].get_offsets())
    4
    """
    require(orbit, "floquet_multipliers", "orbit must be one orbit, such as orbits[0]")
    worst = orbit.floquet_multipliers
    is_new = ax is None
    ax = axes_or_new(ax)
    draw_circle(ax)
    corners = np.array([[-1.0, -1.0], [1.0, 1.0]])
    prefix = f"{options.pop('label')}, " if options.get("label") else ""
    for name, values in _named_multipliers(orbit):
        points = np.column_stack([values.real, values.imag])
        label = f"{prefix}{name}:\nlargest modulus {np.max(np.abs(values)):.4g}"
        ax.scatter(points[:, 0], points[:, 1], **_marker_options(ax, options, label))
        corners = np.vstack([corners, points])
    if worst is None:
        reason = getattr(orbit.stability, "reason", None)
        text = f"multipliers undefined: {reason}" if reason else "multipliers undefined"
        box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85}
        ax.text(0.5, 0.5, fill(text, TEXT_WIDTH), transform=ax.transAxes, ha="center", va="center", bbox=box)
    _frame_square(ax, corners)
    every = [values for _, values in _named_multipliers(orbit)]
    if every:
        values = np.concatenate(every)
        _label(ax, values)
        _zoom(ax, values)
    if ax.get_legend_handles_labels()[0]:
        legend = draw_legend(ax, beside=is_new)
        if not is_new:
            _move_above_circle(ax, legend)
    return ax


def _label(ax: Axes, values: NDArray[np.complex128]) -> None:
    """Write the values at their points, once for two that are conjugate, unless there are many."""
    upper = np.unique(np.round(values[values.imag >= 0.0], 9))
    if len(upper) > MOST_LABELS:
        return
    for value in upper:
        text = f"{value.real:.3g}" if value.imag == 0.0 else f"{value.real:.3g} ± {value.imag:.3g}i"
        place = (value.real, value.imag)
        ax.annotate(text, place, xytext=(0.0, 7.0), textcoords="offset points", ha="center", fontsize="x-small", zorder=3.0)


def _zoom(ax: Axes, values: NDArray[np.complex128]) -> None:
    """Draw the two that are nearest to each other again, larger, in a corner, where their marks hide each other."""
    apart = np.abs(values[:, None] - values[None, :])
    apart[np.tril_indices(len(values))] = np.inf
    one, other = np.unravel_index(np.argmin(apart), apart.shape)
    width = float(ax.get_xlim()[1] - ax.get_xlim()[0])
    if not 0.0 < apart[one, other] < CLOSE * width:
        return
    middle, half = 0.5 * (values[one] + values[other]), 1.5 * float(apart[one, other])
    x, y = (middle.real - half, middle.real + half), (middle.imag - half, middle.imag + half)
    right, low = middle.real < 0.0, middle.imag > 0.0
    inset = ax.inset_axes((0.68 if right else 0.02, 0.02 if low else 0.63, 0.3, 0.3), xlim=x, ylim=y, xticks=[], yticks=[])
    for drawn in ax.collections:
        points = np.asarray(drawn.get_offsets())
        face, edge = drawn.get_facecolor(), drawn.get_edgecolor()
        inset.scatter(points[:, 0], points[:, 1], s=MARKER_AREA, marker="o", facecolors=face, edgecolors=edge)
    inset.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor="0.35", linewidth=1.2, linestyle="--"))
    inset.set_title(f"{2.0 * half:.1g} wide", fontsize="x-small", pad=2.0)
    ax.indicate_inset_zoom(inset, edgecolor="0.3")


def _named_multipliers(orbit: StableOrbit) -> list[tuple[str, np.ndarray[Any, np.dtype[np.complex128]]]]:
    """Return the finite multipliers of each order of impacts, or of the orbit where no orders are told apart."""
    orders = getattr(orbit.stability, "orders", None) or {}
    named = [(_order_name(order, len(orders)), values) for order, values in orders.items()]
    if not named:
        named = [("multipliers", orbit.floquet_multipliers)]
    arrays = [(name, np.asarray(values, dtype=complex)) for name, values in named if values is not None]
    return [(name, values) for name, values in arrays if values.size and np.all(np.isfinite(values))]


def _order_name(order: Hashable, n_orders: int) -> str:
    """Name an order of impacts by its stops; a single one needs no name."""
    if n_orders == 1:
        return "multipliers"
    return f"stops {_arrows(order)}"


def _arrows(order: Hashable) -> str:
    """Write (0, 1) as 0 → 1, and instants within an order in brackets."""
    if not isinstance(order, Iterable) or isinstance(order, str):
        return str(order)
    return " → ".join(f"({_arrows(part)})" if isinstance(part, tuple) else str(part) for part in order)


def _marker_options(ax: Axes, options: dict[str, Any], label: str) -> dict[str, Any]:
    """Choose an open marker that differs from those on `ax` in form, size and colour."""
    n_drawn = len(ax.collections)
    defaults: dict[str, Any] = {
        "marker": MARKERS[n_drawn % len(MARKERS)],
        "s": MARKER_AREA * (1.0 + 0.5 * n_drawn),
        "linewidths": 1.4,
        "zorder": 2.5,
        "label": label,
    }
    if not {"c", "color"} & options.keys():
        defaults |= {"facecolors": "none", "edgecolors": f"C{n_drawn}"}
    return with_defaults(options, PathCollection, **defaults)


def _frame_square(ax: Axes, corners: FloatArray) -> None:
    """Let the limits hold a square around the circle and the points, both axes in one scale."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre, half = 0.5 * (low + high), 0.5 * ROOM * np.max(high - low)
    ax.update_datalim(np.array([centre - half, centre + half]))
    ax.set_aspect("equal", adjustable="box")
    ax.autoscale_view()


def _move_above_circle(ax: Axes, legend: Legend) -> None:
    """Put the legend in a strip of its own above what is drawn, shaded: its markers are no multipliers."""
    legend.set_loc("upper center")
    legend.get_frame().set(facecolor="0.9", alpha=1.0)
    legend.set(zorder=4.0)
    ax.apply_aspect()
    strip = min(legend.get_window_extent().height / ax.get_window_extent().height, 0.5)
    bottom, top = ax.get_ylim()
    ax.set_ylim(bottom, top + strip / (1.0 - strip) * (top - bottom), auto=None)  # more data may still widen the limits

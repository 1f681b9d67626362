"""Where in a plane of two parameters an orbit exists, is admissible and is stable.

Every cell is one pair of values; the colours darken from no orbit to an admissible and stable one, so that the map can
be read in grey.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from numpy.typing import NDArray

from vibroimpact.plot._axes import axes_or_new, label_axis, with_unit
from vibroimpact.plot._data import ExistenceMap, require
from vibroimpact.plot._edges import edges

# From light to dark; the lightness in L* falls from category to category.
CATEGORIES = (
    ("no orbit", "#f4f4f4"),
    ("inadmissible", "#f0c36b"),
    ("admissible,\nundecided", "#d99a78"),
    ("admissible,\nunstable", "#b8503f"),
    ("admissible,\nstable", "#1d3a66"),
)
NO_ORBIT, INADMISSIBLE, UNDECIDED, UNSTABLE, STABLE = range(len(CATEGORIES))


def existence_map(existence: ExistenceMap, ax: Axes | None = None, *, colourbar: bool = True, **options: Any) -> Axes:
    """Draw where an orbit exists, is admissible and is stable, over two parameters.

    Parameters
    ----------
    existence : ExistenceMap
        Values x, y with their names, and for each pair the number of orbits, admissible or not, stable or not.
        An admissible orbit that is not stable and whose multiplier is nan is shown as undecided.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure. On a logarithmic axis the cells are bounded by geometric means.
    colourbar : bool, default True
        Add a bar that names the colours, in room taken from `ax`.
    **options
        Options of the cells (`matplotlib.axes.Axes.pcolormesh`), such as ``cmap`` or ``edgecolors``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure; not those of the bar.

    Raises
    ------
    ValueError
        If the arrays of the map are not (len(y), len(x)), or `existence` is not a map, or `ax` not an Axes.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> frequency, clearance = ("frequency", np.linspace(1.4, 1.6, 9)), ("clearance[1]", np.linspace(0.1, 0.2, 5))
    >>> ax = vi.plot.existence_map(vi.existence_map(scene, [1], frequency, clearance, n_periods=2))
    >>> ax.get_ylabel()
    'clearance[1]'
    """
    require(existence, "n_orbits", "existence must be the result of vibroimpact.existence_map")
    x, y = np.asarray(existence.x, dtype=float), np.asarray(existence.y, dtype=float)
    categories = _categories(existence, (len(y), len(x)))
    ax = axes_or_new(ax)
    label_axis(ax, "x", with_unit(existence.x_name or "x"))
    label_axis(ax, "y", with_unit(existence.y_name or "y"))
    shown = np.unique(categories)
    place = np.zeros(len(CATEGORIES), dtype=int)
    place[shown] = np.arange(len(shown))
    colours: dict[str, Any] = {
        "cmap": ListedColormap([CATEGORIES[code][1] for code in shown]),
        "norm": BoundaryNorm(np.arange(len(shown) + 1) - 0.5, len(shown)),
    }
    columns, rows = np.argsort(x, kind="stable"), np.argsort(y, kind="stable")
    x_edges = edges(x[columns], ax.get_xscale() == "log")
    y_edges = edges(y[rows], ax.get_yscale() == "log")
    mesh = ax.pcolormesh(x_edges, y_edges, place[categories][np.ix_(rows, columns)], **(colours | options))
    if colourbar:
        assert ax.figure is not None  # axes_or_new refuses Axes without a figure
        bar = ax.figure.colorbar(mesh, ax=ax, ticks=np.arange(len(shown)))
        bar.ax.set_yticklabels([CATEGORIES[code][0] for code in shown])
        bar.ax.tick_params(which="both", length=0)
    return ax


def _categories(existence: ExistenceMap, shape: tuple[int, int]) -> NDArray[np.int_]:
    """Return the category of each cell, `shape` = (len(y), len(x))."""
    arrays = {}
    for name in ("n_orbits", "is_admissible", "is_stable", "multiplier"):
        arrays[name] = np.asarray(getattr(existence, name), dtype=float)  # None becomes nan
        if arrays[name].shape != shape:
            raise ValueError(f"{name} must have the shape (len(y), len(x)) = {shape}, got {arrays[name].shape}")
    stability = arrays["is_stable"]
    is_undecided = np.isnan(stability) | ((stability == 0.0) & np.isnan(arrays["multiplier"]))
    admissible = np.where(is_undecided, UNDECIDED, np.where(stability == 0.0, UNSTABLE, STABLE))
    found = np.where(arrays["is_admissible"] == 1.0, admissible, INADMISSIBLE)
    return np.where(arrays["n_orbits"] > 0.0, found, NO_ORBIT)

"""Branches of periodic orbits over a number: solid where stable, dashed where not, dotted where a rule of contact is broken."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vibroimpact.plot._axes import axes_or_new, label_axis, label_once, with_defaults, with_unit
from vibroimpact.plot._data import Branch, BranchTree, FloatArray, require

#: Of each part of a branch its name, its line and whether it is drawn thick.
PARTS = {"stable": ("-", 1.8), "unstable": ("--", 1.0), "virtual": (":", 1.0)}
COLOUR = "#1d3a66"
#: Of each kind of special point its mark and its name.
MARKS = {
    "fold": ("o", "fold"),
    "period_doubling": ("s", "period doubling"),
    "torus": ("P", "torus"),
    "pitchfork": ("p", "pitchfork"),
    "branch_point": ("*", "branch point"),
    "touch": ("2", "touch"),
    "border_collision": ("1", "border collision"),
    "graze": ("^", "graze"),
    "lost_impact": ("v", "lost impact"),
    "corner": ("D", "corner"),
    "landing_border": ("8", "landing border"),
    "rise": ("h", "rise"),
    "release_border": ("H", "release border"),
    "chatter_border": ("X", "chatter border"),
    "vanishing_impacts": ("$0$", "vanishing impacts"),
}


def branch(
    branch: Branch | BranchTree, ax: Axes | None = None, *, y: str | Callable[[Any], float] | None = None, **line: Any
) -> Axes:
    """Draw a branch of periodic orbits over its number, or all that meet.

    Parameters
    ----------
    branch : Branch or BranchTree
        The result of ``vibroimpact.continuation`` or ``vibroimpact.branch_tree``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    y : str or callable, optional
        What is drawn of each orbit: "speeds_before[k]", the speed of impact k, "phases[k]", "durations[k]" of contact k, the name
        of a monitor, or a function ``f(orbit) -> float``. Default the speed of the first impact; of orbits without one that come
        into contact the largest displacement, and of those that hit nothing the largest position at the beginning of a period;
        of a tree the speed of the fastest impact or contact, zero where nothing is hit.
    **line
        Options of the lines (`matplotlib.lines.Line2D`), such as ``color`` or ``linewidth``; the branches of a tree have a
        colour each.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If `branch` is none, or `y` is nothing of it.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> found = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.1, 1.5))
    >>> vi.plot.branch(found).get_ylabel()
    'speed before impact 0'
    """
    tree = getattr(branch, "branches", None)
    every: tuple[Any, ...] = tree if isinstance(tree, tuple) else (branch,)
    for own in every:
        require(own, "arclength", "branch must be the result of vibroimpact.continuation or vibroimpact.branch_tree")
    ax = axes_or_new(ax)
    for k, own in enumerate(every):
        is_one = own is branch
        usual = y if is_one or y is not None else _fastest
        _draw(ax, own, usual, COLOUR if is_one else f"C{k % 10}", line)
    ax.legend(fontsize="small")
    return ax


def _fastest(orbit: Any) -> float:
    """Return the speed of the fastest impact of an orbit, or with which a contact begins."""
    impacts = orbit.impacts["speed_before"].max(initial=0.0)
    if all(stop.restitution is not None for stop in orbit.scene.stops):
        return float(impacts)
    return float(np.fmax(impacts, orbit.contacts["speed_before"].max(initial=0.0)))


def _draw(ax: Axes, branch: Branch, y: str | Callable[[Any], float] | None, colour: str, line: dict[str, Any]) -> None:
    """Draw one branch with its special points."""
    values, label = _drawn(branch, y)
    label_axis(ax, "x", with_unit(branch.parameter_name or "parameter"))
    label_axis(ax, "y", label)
    part = _parts(branch)
    for name, (style, width) in PARTS.items():
        if not (part == name).any():
            continue
        # A chord between two parts is drawn as the less certain of them.
        x, drawn = branch.parameter.copy(), values.copy()
        mine = part == name
        beside = np.append(mine[1:], False) | np.append(False, mine[:-1])
        ends = mine if name == "stable" else mine | beside
        x[~ends], drawn[~ends] = np.nan, np.nan
        usual: dict[str, Any] = {"color": colour, "linestyle": style, "linewidth": width, "label": label_once(ax, name)}
        colour = str(ax.plot(x, drawn, **with_defaults(line, **usual))[0].get_color())
    for kind in sorted({own.kind for own in branch.special}):
        places = [own for own in branch.special if own.kind == kind]
        at = np.interp([own.arclength for own in places], branch.arclength, values)
        marker, name = MARKS.get(kind, ("d", kind.removeprefix("user:") + " = 0"))
        ax.plot(
            [own.parameter for own in places],
            at,
            linestyle="none",
            marker=marker,
            markersize=5.0,
            markerfacecolor="white",
            markeredgecolor=colour,
            label=label_once(ax, name),
        )


def _parts(branch: Branch) -> NDArray[Any]:
    """Return of each point what it is; one without a derivative, such as a touch, is what the point beside it is."""
    part = np.where(branch.is_virtual, "virtual", np.where(branch.is_stable, "stable", "unstable"))
    for k in np.flatnonzero((branch.n_unstable < 0) & ~branch.is_virtual):
        if len(part) > 1:
            part[k] = part[k - 1] if k else part[1]
    return part


def _drawn(branch: Branch, y: str | Callable[[Any], float] | None) -> tuple[FloatArray, str]:
    """Return what is drawn, and what it is called."""
    if callable(y):
        named = "speed of the fastest impact" if y is _fastest else getattr(y, "__name__", "value")
        return np.array([float(y(orbit)) for orbit in branch]), named
    if y is None and branch.speeds_before.shape[1] == 0:
        if branch.durations.shape[1]:
            return np.array([float(np.max(orbit.max_displacement)) for orbit in branch]), "largest displacement"
        return np.array([float(np.abs(orbit.position(0.0)).max()) for orbit in branch]), "position at t = 0"
    name = "speeds_before[0]" if y is None else y
    columns = {"speeds_before": "speed before impact", "phases": "phase of impact"}
    found = {f"{own}[{k}]": (getattr(branch, own)[:, k], f"{text} {k}") for own, text in columns.items() for k in _places(branch)}
    if name.startswith("durations["):
        own = branch.durations
        found |= {f"durations[{k}]": (own[:, k], f"duration of contact {k}") for k in range(own.shape[1])}
    found |= {own: (values, own) for own, values in branch.monitor.items()}
    if not found and name.startswith("speeds_before["):
        # A branch of a tree whose orbits hit nothing.
        return np.zeros(len(branch.parameter)), columns["speeds_before"]
    if name not in found:
        raise ValueError(f"y must be a function or one of {', '.join(found)}, got {y!r}")
    return found[name]


def _places(branch: Branch) -> range:
    return range(branch.speeds_before.shape[1])

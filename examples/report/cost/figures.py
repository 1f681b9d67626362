"""The figures: what features add, and how cost and memory grow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullFormatter

from report.cost.case import Group
from report.cost.judged import Judged
from report.cost.laws import Fit
from report.cost.measure import Row
from report.cost.memory import LEAST
from report.cost.tables import instructions

BASE, MORE, LESS = "0.75", "tab:blue", "tab:green"
# The panels of the growth figure: a title, and what the names of its series begin with.
PANELS = {
    "modes": ("modes", "bar", "held"),
    "stops": ("stops", "polygon"),
    "length of the run": ("length",),
    "trajectories at once": ("ensemble",),
    "links of a chain": ("chain",),
}
MARKERS = "os^D"


def save(fig: Any, directory: Path, name: str) -> list[str]:
    """Write a figure in both forms; their names."""
    names = [f"{name}.png", f"{name}.svg"]
    for each in names:
        fig.savefig(directory / each, dpi=110)
    plt.close(fig)
    return names


def bars(ax: Any, base: float, differences: Sequence[float], unit: str) -> None:
    """The cost of the first case in grey, and what each further one adds to it or saves of it."""
    more, places = np.array(differences), np.arange(len(differences))
    less = more < 0.0
    ax.barh(places, base + np.minimum(more, 0.0), color=BASE)
    ax.barh(places, np.maximum(more, 0.0), left=base, color=MORE)
    ax.barh(places[less], -more[less], left=base + more[less], color="white", edgecolor=LESS, hatch="///")
    for place, difference in zip(places, differences, strict=True):
        words = f" {base:,.0f}" if place == 0 else f" {100.0 * difference / base:+.1f} %"
        ax.text(base + max(difference, 0.0), place, words, va="center", fontsize=8)
    ax.set_xlim(0.0, 1.18 * (base + max(differences)))
    ax.set_xlabel(unit)
    ax.invert_yaxis()
    ax.spines[["top", "right"]].set_visible(False)


def features(measured: Mapping[str, tuple[Group, Sequence[Row]]], directory: Path) -> list[str]:
    """What features add to an impact of an exact flight, to a Runge-Kutta step and to a step along a Taylor series."""
    shown = [measured[key] for key in ("exact", "rk45", "taylor")]
    are_counted = all(row.counted for _, rows in shown for row in rows)
    columns = 2 if are_counted else 1
    heights = [len(rows) for _, rows in shown]
    fig, axes = plt.subplots(
        3,
        columns,
        figsize=(4.0 + 4.5 * columns, 1.5 + 0.3 * sum(heights)),
        layout="constrained",
        squeeze=False,
        gridspec_kw={"height_ratios": heights},
    )
    for line, (group, rows) in zip(axes, shown, strict=True):
        bars(line[0], rows[0].nanoseconds, [row.added for row in rows], f"one {group.unit} [ns]")
        line[0].set_yticks(np.arange(len(rows)), [row.name for row in rows], fontsize=8)
        line[0].set_title(group.title.replace("`", ""), loc="left", fontsize=10)
        for ax in line[1:]:
            counts = [instructions(row) or 0.0 for row in rows]
            bars(ax, counts[0], [count - counts[0] for count in counts], f"one {group.unit} [instructions]")
            ax.set_yticks([])
    return save(fig, directory, "scene_cost_features")


def with_law(
    ax: Any, sizes: Sequence[float], costs: Sequence[float], fit: Fit | None, scale: float, style: dict[str, Any]
) -> None:
    """Points, and the fitted law over the sizes it was fitted to."""
    ax.loglog(sizes, costs, linestyle="", **style)
    if fit is not None:
        ends = np.array([fit.first, max(sizes)])
        ax.loglog(ends, [scale * fit.at(end) for end in ends], color=style["color"], linewidth=1.0)


def widen(ax: Any, room: float) -> None:
    """Whole decades, and so many more above them for the legend; plain numbers."""
    low, high = np.log10(ax.get_ylim())
    ax.set_ylim(10.0 ** math.floor(low), 10.0 ** (math.ceil(high) + room))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_minor_formatter(NullFormatter())


def growth(judged: Sequence[Judged], directory: Path) -> list[str]:
    """Cost of a unit above, memory of the run below, against each size."""
    fig, axes = plt.subplots(2, len(PANELS), figsize=(4.0 * len(PANELS), 7.5), layout="constrained")
    for (above, below), (title, keys) in zip(axes.T, PANELS.items(), strict=True):
        of_panel = [one for one in judged if one.series.key.startswith(keys)]
        for k, one in enumerate(of_panel):
            style = {"marker": MARKERS[k], "color": f"C{k}", "markersize": 5}
            sizes = [point.size for point in one.points]
            label = one.series.label + ("" if one.times is None else f": exponent {one.times.power:.2f}")
            with_law(above, sizes, [p.nanoseconds / 1000.0 for p in one.points], one.times, 1e-3, {**style, "label": label})
            known = [(p.size, max(p.memory, LEAST)) for p in one.points if p.memory is not None]
            with_law(below, [s for s, _ in known], [m for _, m in known], one.memory, 1.0, style)
        units = dict.fromkeys(one.series.unit for one in of_panel)
        above.set(title=title, ylabel=f"one {' or '.join(units)} [us]")
        above.legend(fontsize=9, loc="upper left")
        widen(above, 1.0)
        below.axhline(LEAST, color="0.6", linewidth=0.8, linestyle=":")
        below.set(xlabel=of_panel[0].series.size, ylabel="memory that the run adds [MiB]")
        widen(below, 0.0)
    return save(fig, directory, "scene_cost_growth")

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
from matplotlib.ticker import NullFormatter, NullLocator

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
    "diagrams and basins": ("family",),
    "exponents": ("exponents",),
}
STYLES = [{"marker": marker, "color": f"C{k}", "markersize": 5} for k, marker in enumerate("os^D")]
# Panels beside each other.
ACROSS = 4
# A ratio of sizes below which each has its number on the axis.
FEW = 50


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


def widen(ax: Any, low: float, high: float) -> None:
    """Whole decades, from decade to decade, and plain numbers."""
    ax.set_ylim(10.0 ** math.floor(math.log10(low)), 10.0 ** math.ceil(math.log10(high)))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_minor_formatter(NullFormatter())


def name_sizes(ax: Any, sizes: Sequence[int]) -> None:
    """Each size by its number, where there are too few decades to tell."""
    if max(sizes) < FEW * min(sizes):
        ax.set_xticks(sizes, [f"{size}" for size in sizes])
        ax.xaxis.set_minor_locator(NullLocator())


def costs(ax: Any, judged: Sequence[Judged]) -> None:
    """Cost of a unit of each series, with room for the legend above."""
    for one, style in zip(judged, STYLES, strict=False):
        label = one.series.label + ("" if one.times is None else f": exponent {one.times.power:.2f}")
        sizes = [point.size for point in one.points]
        with_law(ax, sizes, [p.nanoseconds / 1000.0 for p in one.points], one.times, 1e-3, {**style, "label": label})
    ax.set_ylabel(f"one {' or '.join(dict.fromkeys(one.series.unit for one in judged))} [us]")
    ax.legend(fontsize=9, loc="upper left")
    low, high = ax.get_ylim()
    widen(ax, low, high * 10.0 * (high / low) ** 0.3)


def peaks(ax: Any, judged: Sequence[Judged], largest: float) -> None:
    """Memory of each series; what is not told from chance on the dotted line."""
    for one, style in zip(judged, STYLES, strict=False):
        known = [(p.size, max(p.memory, LEAST)) for p in one.points if p.memory is not None]
        with_law(ax, [size for size, _ in known], [peak for _, peak in known], one.memory, 1.0, style)
    ax.axhline(LEAST, color="0.6", linewidth=0.8, linestyle=":")
    ax.set(xlabel=judged[0].series.size, ylabel="memory that the run adds [MiB]")
    widen(ax, 0.5 * LEAST, largest)


def growth(judged: Sequence[Judged], directory: Path) -> list[str]:
    """Cost of a unit above, memory of the run below, against each size."""
    rows = 2 * math.ceil(len(PANELS) / ACROSS)
    fig, axes = plt.subplots(rows, ACROSS, figsize=(4.0 * ACROSS, 3.75 * rows), layout="constrained")
    pairs = [(axes[row, k], axes[row + 1, k]) for row in range(0, rows, 2) for k in range(ACROSS)]
    for unused in (ax for pair in pairs[len(PANELS) :] for ax in pair):
        unused.remove()
    largest = max((p.memory for one in judged for p in one.points if p.memory is not None), default=LEAST)
    for (above, below), (title, keys) in zip(pairs, PANELS.items(), strict=False):
        of_panel = [one for one in judged if one.series.key.startswith(keys)]
        costs(above, of_panel)
        peaks(below, of_panel, 2.0 * largest)
        above.set_title(title)
        for ax in (above, below):
            name_sizes(ax, sorted({point.size for one in of_panel for point in one.points}))
    return save(fig, directory, "scene_cost_growth")

"""Figures of the report: error against run time, one pair of axes for each problem, and all of them on one sheet.

Wrong answers have no place on an axis of errors: they are marks in the strip above it, each package in a row of its own. A
contestant that was stopped, or that raised an exception, is a mark at the right edge of the strip or its left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from .measure import Point, base_of

plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "error against run time"})

LOWEST, HIGHEST, STRIP = 1e-16, 1.0, 1e4  # errors drawn; wrong answers lie between HIGHEST and STRIP
COLOURS = {
    "own": "#c1272d",
    "scipy": "#3b6fb6",
    "heyoka": "#222222",
    "pydiffsol": "#2e8b57",
    "numbalsoda": "#c98a1b",
    "diffrax": "#7b4fa3",
    "sundae": "#0b8f9c",
    "siconos": "#d6559b",
}
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
OWN_MARKERS = {"exact": "o", "taylor": "D", "rk45": "s", "dop853": "P", "radau": "^", "auto": "o"}
WRONG = {"x": "wrong number of impacts", "1": "through the stop, or far off", ">": "stopped at the bound", "+": "failed"}


def draw(ax: plt.Axes, points: Sequence[Point], error: str) -> None:
    """Draw one error of one problem's points."""
    for package, colour in COLOURS.items():
        methods = dict.fromkeys(p.method for p in points if p.package == package)
        markers = OWN_MARKERS if package == "own" else dict(zip(methods, MARKERS, strict=False))
        for method in methods:
            mine = [p for p in points if (p.package, p.method) == (package, method)]
            draw_method(ax, mine, error, colour, markers[method])
    ax.axhspan(HIGHEST, STRIP, color="0.93", zorder=0)
    ax.set(xscale="log", yscale="log", xlim=times_shown(points), ylim=(LOWEST / 3, STRIP))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_yticks([10.0**k for k in range(-16, 1, 4)])
    ax.grid(alpha=0.3)


def times_shown(points: Sequence[Point]) -> tuple[float, float]:
    """Limits of the axis of times: what was measured and some room, two decades at least."""
    ratios = [p.ratio for p in points if p.ratio is not None] or [1.0]
    low, high = min(ratios) / 2.0, max(ratios) * 2.0
    more = max(1.0, math.sqrt(100.0 * low / high))
    return low / more, high * more


def draw_method(ax: plt.Axes, points: Sequence[Point], error: str, colour: str, marker: str) -> None:
    """Draw one method: its right answers joined in order of tolerance, its wrong ones and its stops in the strip."""
    is_own = points[0].package == "own"
    style = {"color": colour, "markersize": 6 if is_own else 4, "linewidth": 2.0 if is_own else 0.9, "zorder": 4 if is_own else 3}
    right = [p for p in points if p.verdict == "right" and getattr(p, error) is not None]
    name = f"this library, {points[0].method}" if is_own else points[0].name
    ax.plot(
        [p.ratio for p in right], [max(getattr(p, error), LOWEST) for p in right], marker=marker, label=name,
        markerfacecolor=colour if is_own else "white", **style,
    )  # fmt: skip
    for mark in WRONG:
        draw_wrong(ax, [p for p in points if wrong_mark(p) == mark], mark, colour)


def wrong_mark(point: Point) -> str | None:
    """Mark of an answer that is not right; None for a right one, and for a trial that was not made."""
    if point.verdict == "right" or point.verdict.startswith("not tried"):
        return None
    if point.verdict.startswith(("stopped", "killed")):
        return ">"
    if point.ratio is None:
        return "+"
    return "x" if "impacts" in point.verdict else "1"


def draw_wrong(ax: plt.Axes, points: Sequence[Point], mark: str, colour: str) -> None:
    """Marks in a package's row of the strip: at their time, or at an edge if they have none."""
    if not points:
        return
    row = (list(COLOURS).index(points[0].package) + 1) / (len(COLOURS) + 1)
    y = HIGHEST * (STRIP / HIGHEST) ** row
    if mark in ">+":
        ax.plot([0.985 if mark == ">" else 0.015], [y], mark, color=colour, markersize=5, transform=ax.get_yaxis_transform())
    else:
        ax.plot([p.ratio for p in points], [y] * len(points), mark, color=colour, markersize=5 if mark == "x" else 7)


def mark_legend() -> list[Line2D]:
    """What the marks of the strip mean."""
    return [Line2D([], [], linestyle="", marker=mark, color="0.4", label=text) for mark, text in WRONG.items()]


def save(fig: plt.Figure, stem: Path) -> None:
    """Write a figure as PNG and SVG, the latter without a date."""
    fig.savefig(stem.with_suffix(".png"), dpi=110)
    fig.savefig(stem.with_suffix(".svg"), metadata={"Date": None})
    plt.close(fig)


def of_problem(points: Sequence[Point], title: str, stem: Path) -> None:
    """Both errors of one problem; of many starts that of the final state alone."""
    names = {"state_error": "final state", "time_error": "times of impact"}
    errors = [error for error in names if any(getattr(p, error) is not None for p in points)]
    fig, axes = plt.subplots(1, len(errors), figsize=(2.5 + 5 * len(errors), 5), sharey=True, layout="constrained", squeeze=False)
    for ax, error in zip(axes[0], errors, strict=True):
        draw(ax, points, error)
        base = "SciPy RK45 at rtol 1e-6" if base_of(points) else "the bound"
        many = ", largest of the sample" if any(p.median_error is not None for p in points) else ""
        ax.set(xlabel=f"run time / {base} [-]", title=f"error of the {names[error]}{many}")
    axes[0, 0].set_ylabel("error, in the motion's own scale [-]")
    handles = [*axes[0, -1].get_legend_handles_labels()[0], *mark_legend()]
    axes[0, -1].legend(handles=handles, loc="center left", bbox_to_anchor=(1.02, 0.5), fontsize=8)
    fig.suptitle(title)
    save(fig, stem)


def sheet(points: Sequence[Point], titles: dict[str, str], stem: Path) -> None:
    """The error of the final state of every problem, on one sheet."""
    names = list(dict.fromkeys(p.problem for p in points))
    rows = math.ceil(len(names) / 3)
    fig, axes = plt.subplots(rows, 3, figsize=(14, 3.6 * rows), sharey=True, layout="constrained", squeeze=False)
    handles = {}
    for ax, name in zip(axes.flat, names, strict=False):
        mine = [p for p in points if p.problem == name]
        draw(ax, mine, "state_error")
        ax.set_title(titles[name] + ("" if base_of(mine) else " (run time / bound)"), fontsize=9)
        handles |= {label: handle for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    for ax in axes.flat[len(names) :]:
        ax.set_axis_off()
    for ax in axes[:, 0]:
        ax.set_ylabel("error of the final state [-]")
    for k, ax in enumerate(axes.flat[: len(names)]):
        if k + 3 >= len(names):
            ax.set_xlabel("run time / SciPy RK45 at rtol 1e-6, or / the bound [-]")
    fig.legend(handles=[*handles.values(), *mark_legend()], loc="outside lower center", ncols=6, fontsize=9)
    save(fig, stem)

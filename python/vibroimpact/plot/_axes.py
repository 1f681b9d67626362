"""Axes and options, the same for every figure.

Curves drawn after one another differ in line style as well as in colour, so that a grey print can be read; an axis
label that somebody has set is kept.
"""

from typing import Any, Literal

from matplotlib import patheffects
from matplotlib import pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cbook import normalize_kwargs
from matplotlib.legend import Legend
from matplotlib.lines import Line2D

from vibroimpact.plot._segments import CONTACT_KINDS

LINE_STYLES = ("-", "--", "-.", ":")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
WALL_COLOUR = "0.6"
WALL_WIDTH = 2.0  # [points]
TICK_SPACING = 6.0  # of the ticks on the solid side of a wall [points]
TICK_LENGTH = 0.9  # of a tick [spacings]

SECTION_LABEL = "Poincaré points"
JUMP_LABEL = "_jumps"
IMPACT_LABEL = "impacts"
STOP_LABEL = "stop "
ZERO_LABEL = "_zero"
#: Of the numbers of scenes that do not have the units of the model.
UNITS = {"frequency": "rad/s", "phase": "rad", "restitution": "-", "forcing_scale": "-", "damping_scale": "-"}


def axes_or_new(ax: Axes | None) -> Axes:
    """Return `ax`, or the Axes of a new figure whose layout clips nothing (axes of one scale included)."""
    if ax is None:
        return plt.subplots(layout="compressed")[1]
    if not isinstance(ax, Axes) or ax.figure is None:
        raise ValueError(f"ax must be the Axes of a figure or None, got {ax!r}; every other option is passed by its name")
    return ax


def with_defaults(options: dict[str, Any], artist: type[Artist] = Line2D, **defaults: Any) -> dict[str, Any]:
    """Put `defaults` under the options of the caller, whichever alias (lw, linewidth) either uses."""
    return normalize_kwargs(defaults, artist) | normalize_kwargs(options, artist)


def next_line_style(ax: Axes) -> str:
    """Choose a line style by the number of curves that `ax` has already."""
    names = (STOP_LABEL, SECTION_LABEL, IMPACT_LABEL, *CONTACT_KINDS)
    helpers = (JUMP_LABEL, ZERO_LABEL, *names, *(f"_{name}" for name in names))
    n_curves = sum(not str(line.get_label()).startswith(helpers) for line in ax.lines)
    return LINE_STYLES[n_curves % len(LINE_STYLES)]


def label_once(ax: Axes, name: str) -> str:
    """Hide a name from the legend where a line on `ax` has it already."""
    return f"_{name}" if any(drawn.get_label() == name for drawn in ax.lines) else name


def next_section_marker(ax: Axes) -> str:
    """Choose a marker by the number of sets of Poincare points that `ax` has already."""
    n_sections = sum(str(line.get_label()).lstrip("_").startswith(SECTION_LABEL) for line in ax.lines)
    return MARKERS[n_sections % len(MARKERS)]


def draw_legend_above(ax: Axes) -> None:
    """Draw a legend of what has a name in a line above `ax`, where it hides nothing."""
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, frameon=False, borderaxespad=0.2)


def draw_legend(ax: Axes, beside: bool, markerscale: float = 1.0) -> Legend:
    """Draw a legend beside `ax`, for figures whose layout makes room, or inside where it hides least."""
    if beside:
        return ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, markerscale=markerscale)
    return ax.legend(fontsize="small", markerscale=markerscale)


def with_unit(name: str) -> str:
    """Return the name of a number of scenes with its unit, where that is not the model's own."""
    return f"{name} [{UNITS[name]}]" if name in UNITS else name


def label_axis(ax: Axes, which: Literal["x", "y"], text: str) -> None:
    """Label an axis that has no label; where another coordinate's or direction's is there, leave out which."""
    read, write = (ax.get_xlabel, ax.set_xlabel) if which == "x" else (ax.get_ylabel, ax.set_ylabel)
    present = read()
    if not present:
        write(text)
    elif present != text and "[" in text and present.split("[")[0] == text.split("[")[0]:
        write(text.split("[")[0])
    elif present != text and present.split()[0] == text.split()[0]:
        write(text.split()[0])


def solid_side(left: bool) -> list[patheffects.AbstractPathEffect]:
    """Put ticks on one side of a line, seen in the direction in which it is drawn."""
    angle = 45.0 if left else -45.0
    return [patheffects.Normal(), patheffects.TickedStroke(spacing=TICK_SPACING, angle=angle, length=TICK_LENGTH)]

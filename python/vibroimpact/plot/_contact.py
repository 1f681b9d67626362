"""Marks of contact on a drawn motion: dots at impacts, broad lines where it chatters or sticks."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vibroimpact.plot._axes import IMPACT_LABEL, label_once
from vibroimpact.plot._data import FloatArray
from vibroimpact.plot._direction import Direction
from vibroimpact.plot._sampling import Curve
from vibroimpact.plot._segments import CONTACT_KINDS, contact_spans

MANY_IMPACTS = 200  # more are drawn small
MOST_IMPACTS = 1000  # of more some are drawn
CONTACT_COLOURS = {"chatter": "#c1272d", "stick": "#e8a33d"}
CONTACT_WIDTH = 8.0  # [points]


def draw_impacts(ax: Axes, drawn: Line2D, x: FloatArray, y: FloatArray) -> None:
    """Draw dots in the colour of a line that is there; of very many those at every so many."""
    if np.any(np.isfinite(x)):
        finite = np.isfinite(x)
        few = np.count_nonzero(finite) <= MANY_IMPACTS
        # Both sides of an impact, which gaps set apart from others, stay together.
        number = np.arange(len(x)) if finite.all() else np.cumsum(~finite)
        every = -(-(int(number[-1]) + 1) // MOST_IMPACTS)
        kept = number % every == 0
        x, y = x[kept], y[kept]
        name = IMPACT_LABEL if every == 1 else f"{IMPACT_LABEL} (one in {every})"
        ax.plot(
            x,
            y,
            color=drawn.get_color(),
            linestyle="none",
            marker="o",
            markersize=3.5 if few else 2.0,
            markerfacecolor="white" if few else drawn.get_color(),
            markeredgewidth=0.9 if few else 0.0,
            label=label_once(ax, name),
            zorder=drawn.get_zorder() + 0.1,
        )


def draw_contact(ax: Axes, motion: Any, direction: Direction, curve: Curve, x: FloatArray, y: FloatArray) -> None:
    """Draw the stretches of chatter and of stick as broad lines below the curve; one at a single point is a dot."""
    if len(curve.t) == 0:
        return
    spans = contact_spans(motion, direction, (float(curve.t[0]), float(curve.t[-1])))
    for kind in CONTACT_KINDS:
        of_kind = [span[1:] for span in spans if span[0] == kind]
        if of_kind:
            ax.plot(
                curve.within(x, of_kind),
                curve.within(y, of_kind),
                color=CONTACT_COLOURS[kind],
                linestyle="-",
                linewidth=CONTACT_WIDTH,
                solid_capstyle="round",
                label=label_once(ax, kind),
                zorder=1.9 if kind == "chatter" else 1.8,  # chatter is short, and ends where the stick begins
            )

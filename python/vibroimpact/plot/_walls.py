"""Stops as lines where their gap is zero, on axes that carry the position along their normal.

The ticks stand on the solid side. A stop that moves is where it is at each time; over other axes, the strip in which it moves.
"""

from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import STOP_LABEL, WALL_COLOUR, WALL_WIDTH, solid_side
from vibroimpact.plot._data import FloatArray, Scene
from vibroimpact.plot._direction import Direction, normal_of

PARALLEL = 1e-12  # of a normal: what of it may stand across the direction for rounding
STRIP_ALPHA = 0.3  # of the strip in which a stop moves


def draw_walls(ax: Axes, motion: Any, direction: Direction, t: FloatArray, along: Literal["x", "y"]) -> None:
    """Draw every stop whose normal a direction is; `along` is the axis that carries the position, `t` the times drawn.

    A stop without a normal, or with another one, has no place there and is left out; so is one that moves, of a motion that was
    not kept.
    """
    scene: Scene = motion.scene
    for index, stop in enumerate(scene.stops):
        component = _component(stop, direction)
        if component == 0.0:
            continue
        label = f"{STOP_LABEL}{index}"
        # A vertical line runs upwards and a horizontal one to the right: larger positions are right of the first and
        # left of the second.
        line: dict[str, Any] = {
            "color": WALL_COLOUR,
            "linewidth": WALL_WIDTH,
            "linestyle": "-",
            "label": label,
            "zorder": 1.5,
            "path_effects": solid_side(left=(component > 0.0) == (along == "y")),
        }
        if getattr(stop, "motion", None) is not None:
            try:
                places = direction.of(motion.position(t)) + motion.gap(index, t) / component
            except ValueError:
                continue
            if along == "y":
                ax.plot(t, places, **line)
            else:
                ax.axvspan(np.min(places), np.max(places), color=WALL_COLOUR, alpha=STRIP_ALPHA, label=label, zorder=0.9)
            continue
        place = float(stop.clearance / component)
        if not _is_drawn(ax, label, place, along):
            (ax.axvline if along == "x" else ax.axhline)(place, **line)


def _component(stop: Any, direction: Direction) -> float:
    """Return c of a stop whose gap is ``clearance - c n.q``; 0 where it is none of the direction n alone."""
    normal = normal_of(stop, len(direction.vector))
    if normal is None:
        return 0.0
    along = float(normal @ direction.vector / (direction.vector @ direction.vector))
    if np.max(np.abs(normal - along * direction.vector)) > PARALLEL * np.max(np.abs(normal)):
        return 0.0
    return -along if stop.side == "lower" else along


def _is_drawn(ax: Axes, label: str, place: float, along: Literal["x", "y"]) -> bool:
    """Say whether a motion of the same scene has left this wall on `ax`."""
    data = [(line.get_xdata() if along == "x" else line.get_ydata()) for line in ax.lines if line.get_label() == label]
    return any(np.allclose(np.asarray(values, dtype=float), place, rtol=1e-12, atol=0.0) for values in data)

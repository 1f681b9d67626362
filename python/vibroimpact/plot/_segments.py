"""Where a motion stays in contact: chatter and stick, as its segments have them.

A stop pushes along the directions that its normal has a part of; a wall along those of the links above its bob; a stop given by
functions may push along any.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact.plot._data import is_orbit
from vibroimpact.plot._direction import Direction, acts_along

CONTACT_KINDS = ("chatter", "stick")


def contact_spans(motion: Any, direction: Direction | None, t_span: tuple[float, float]) -> list[tuple[str, float, float]]:
    """Return (kind, start, end) of lasting contacts that act along a direction (None: any), cut to `t_span`.

    Those of an orbit come again in every period; of a motion that was not kept they are not known.
    """
    return [(kind, start, end) for kind, _, start, end in contacts(motion, direction, t_span)]


def contacts(motion: Any, direction: Direction | None, t_span: tuple[float, float]) -> list[tuple[str, int, float, float]]:
    """Return (kind, stop, start, end) of lasting contacts that act along a direction (None: any), cut to `t_span`."""
    held, (first, last) = held_segments(motion), t_span
    if len(held) == 0:
        return []
    stops = motion.scene.stops
    return [
        (str(row["kind"]), int(row["stop"]), max(float(row["start"]) + shift, first), min(float(row["end"]) + shift, last))
        for shift in _shifts(motion, t_span)
        for row in held[(held["start"] + shift <= last) & (held["end"] + shift >= first)]
        if direction is None or row["stop"] < 0 or acts_along(stops[row["stop"]], direction)
    ]


def held_segments(motion: Any) -> NDArray[Any]:
    """Return the segments of chatter and stick as the motion has them: of an orbit those of its first period."""
    try:
        segments = getattr(motion, "segments", None)
    except ValueError:  # the motion was not kept
        segments = None
    if segments is None:
        return np.empty(0)
    return np.asarray(segments[np.isin(segments["kind"], CONTACT_KINDS)])


def _shifts(motion: Any, t_span: tuple[float, float]) -> list[float]:
    """Return by how much the motion's own times are moved to cover `t_span`: whole periods of an orbit."""
    if not is_orbit(motion):
        return [0.0]
    first, last = (int(np.floor(t / motion.period)) for t in t_span)
    return [turn * float(motion.period) for turn in range(first, last + 1)]

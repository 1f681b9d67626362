"""Where a motion stays in contact: chatter and stick, as its segments have them.

A stop pushes on the coordinates that its normal has entries for; a wall on those of the links above its bob; a stop given by
functions may push on any.
"""

from typing import Any

import numpy as np

CONTACT_KINDS = ("chatter", "stick")


def acts_on(stop: Any, coordinate: int) -> bool:
    """Say whether a stop may change the velocity of a coordinate by a force of its own."""
    if hasattr(stop, "bob"):
        return bool(coordinate <= stop.bob)
    normal = getattr(stop, "normal", None)
    if normal is None:
        return True
    return bool(normal == coordinate if np.ndim(normal) == 0 else normal[coordinate] != 0.0)


def contact_spans(motion: Any, coordinate: int | None, t_span: tuple[float, float]) -> list[tuple[str, float, float]]:
    """Return (kind, start, end) of lasting contacts that act on a coordinate (None: on any), cut to `t_span`.

    An orbit has none, and of a motion that was not kept they are not known.
    """
    return [(kind, start, end) for kind, _, start, end in contacts(motion, coordinate, t_span)]


def contacts(motion: Any, coordinate: int | None, t_span: tuple[float, float]) -> list[tuple[str, int, float, float]]:
    """Return (kind, stop, start, end) of lasting contacts that act on a coordinate (None: on any), cut to `t_span`."""
    try:
        segments = getattr(motion, "segments", None)
    except ValueError:  # the motion was not kept
        segments = None
    if segments is None:
        return []
    held = segments[np.isin(segments["kind"], CONTACT_KINDS) & (segments["start"] <= t_span[1]) & (segments["end"] >= t_span[0])]
    stops = motion.scene.stops
    return [
        (str(row["kind"]), int(row["stop"]), max(float(row["start"]), t_span[0]), min(float(row["end"]), t_span[1]))
        for row in held
        if coordinate is None or row["stop"] < 0 or acts_on(stops[row["stop"]], coordinate)
    ]

"""From a function of time along a motion to rows that can be drawn: smooth between its events, at which it may jump."""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from vibroimpact.plot._data import FloatArray, is_orbit
from vibroimpact.plot._sampling import (
    MAX_ROWS,
    MIN_POINTS,
    POINTS,
    SAME_TIME,
    SMOOTH,
    checked_span,
    not_a_motion,
    refined,
    window,
)
from vibroimpact.plot._segments import held_segments

INSIDE = 1e-9  # of a piece between two events: how far from them its ends are asked for
NOT_AT_EVENT = 1e-14  # of the largest time, at the least: nearer, a motion may take a time for that of the event
SHORTEST = 1e-5  # of the time drawn: what happens in less is seen as a jump


def timeline(
    motion: Any, value: Callable[[FloatArray], FloatArray], t_span: tuple[float, float] | None
) -> tuple[FloatArray, FloatArray]:
    """Return times and values along a motion, with nan where they jump: at events alone, impacts and ends of contact.

    Of an orbit over one period, of a trajectory over all of it, or over `t_span`.
    """
    edges = _edges(motion, checked_span(t_span))
    pieces = np.diff(edges)
    wanted = np.full(len(pieces), MIN_POINTS)
    if is_orbit(motion):
        wanted = np.ceil(pieces / (motion.scene.period or motion.period) * POINTS).astype(int) + 1
    counts = np.clip(wanted, MIN_POINTS, max(MIN_POINTS, MAX_ROWS // len(pieces)))
    shortest = SHORTEST * (edges[-1] - edges[0])
    counts[pieces <= shortest] = 2
    inset = np.minimum(np.maximum(INSIDE * pieces, NOT_AT_EVENT * np.max(np.abs(edges))), 0.5 * pieces)
    t = np.concatenate([np.linspace(*ends) for ends in zip(edges[:-1] + inset, edges[1:] - inset, counts, strict=True)])
    piece = np.repeat(np.arange(len(counts), dtype=float), counts)
    t, (values, piece) = refined(
        lambda times: (value(times), (np.searchsorted(edges, times, side="right") - 1).astype(float)),
        t,
        (value(t), piece),
        np.flatnonzero(np.diff(piece) == 0.0),
        shortest,
    )
    is_jump = np.abs(np.diff(values)) > SMOOTH * np.ptp(values)
    breaks = np.flatnonzero((np.diff(piece) != 0.0) & is_jump) + 1
    return np.insert(t, breaks, t[breaks]), np.insert(values, breaks, np.nan)


def _edges(motion: Any, span: tuple[float, float] | None) -> FloatArray:
    """Return the ends of what is drawn and the events inside it: impacts, and ends of contact."""
    start, end = window(motion, span)
    shifts = np.zeros(1)
    if is_orbit(motion):
        shifts = float(motion.period) * np.arange(np.floor(start / motion.period), np.ceil(end / motion.period), dtype=float)
    held = held_segments(motion)
    ends_of_contact = [] if len(held) == 0 else [*held["start"], *held["end"]]
    events = np.unique(np.concatenate([motion.impacts["time"], ends_of_contact]) + shifts[:, None])
    margin = SAME_TIME * max(abs(start), abs(end))
    events = events[(events > start + margin) & (events < end - margin)]
    events = events[np.diff(events, prepend=-np.inf) > margin]
    return np.concatenate([[start], events, [end]])


def check_stop(motion: Any, stop: int) -> int:
    """Return a stop of a motion as a plain index from 0, or say what is wrong with it."""
    if not hasattr(motion, "scene"):
        raise not_a_motion(motion)
    count = len(motion.scene.stops)
    try:
        index = operator.index(stop)
    except TypeError:
        index = -1
    if not 0 <= index < count:
        rule = f"an index from 0 to {count - 1}" if count else "one of the scene's stops, which has none"
        raise ValueError(f"stop must be {rule}, got {stop!r}")
    return index

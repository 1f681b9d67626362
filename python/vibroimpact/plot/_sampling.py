"""From a motion to rows that can be drawn: one direction, flight by flight, both sides of every impact.

A flight begins with the velocity after an impact and ends with the velocity before the next; the rows on the two
sides have equal times.  A motion is drawn over the times (start, end]: the impact at its end is there, with both sides,
the one at its start is not.
"""

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import NDArray

from vibroimpact.plot._data import FloatArray, Orbit, Ramped, Trajectory, is_orbit, is_trajectory
from vibroimpact.plot._direction import Direction
from vibroimpact.plot._segments import contact_spans, held_segments

IntArray: TypeAlias = NDArray[np.intp]

POINTS = 400  # rows in a forcing period of an orbit: a flight of a few waves looks smooth at any usual size
MIN_POINTS = 24  # rows in a flight, however short
SMALL_JUMP = 1e-12  # of the largest velocity: below it the two sides differ by rounding
SAME_TIME = 1e-12  # of the largest time: rounding between the time of an impact and that of its rows
SMOOTH = 1e-3  # of the range drawn: by less than that a straight line between rows may miss the motion
ROUNDING = 1e-12  # of the largest value: a coordinate at rest is a straight line
SPLIT = 2.0**0.5 - 1.0  # of a step, where it is split: not the middle, lest steps of two whole periods look straight
MAX_ROWS = 100_000  # of a refined trajectory: more are not told apart at any usual size
PER_RADIAN = 2.0  # points in a radian of the fastest forcing, between which angles are told apart
POLISHES = 6  # steps of Newton's method
SAME_POINT = 1e-6  # of a forcing period: a Poincare point this near to an impact is taken right after it


@dataclass(frozen=True)
class Curve:
    """A motion along one direction; `starts` are the rows at which the velocity begins anew."""

    t: FloatArray
    q: FloatArray
    v: FloatArray
    starts: IntArray

    def broken(self, values: FloatArray) -> FloatArray:
        """Put nan between the two sides of every jump, so that no line joins them."""
        return np.insert(values, self.starts, np.nan)

    @property
    def impacts(self) -> IntArray:
        """The rows right after the jumps of which both sides are known."""
        is_seen = self.t[self.starts] == self.t[self.starts - 1]
        return self.starts[np.flatnonzero(is_seen)]

    def within(self, values: FloatArray, spans: list[tuple[float, float]]) -> FloatArray:
        """Keep what lies within some spans of time, with nan after each."""
        parts: list[FloatArray] = []
        for start, end in spans:
            margin = SAME_TIME * max(abs(start), abs(end))
            rows = slice(np.searchsorted(self.t, start - margin), np.searchsorted(self.t, end + margin, side="right"))
            parts += [values[rows], np.array([np.nan])]
        return np.concatenate(parts) if parts else np.empty(0)

    def jumps(self, values: FloatArray) -> FloatArray:
        """Return the two sides of every jump, with nan after each pair."""
        rows = self.impacts
        return np.column_stack([values[rows - 1], values[rows], np.full(len(rows), np.nan)]).ravel()


def sample(motion: Orbit | Trajectory, direction: Direction, t_span: tuple[float, float] | None, points: int = POINTS) -> Curve:
    """Return the rows of an orbit along a direction (over one period) or of a trajectory, or those in `t_span`."""
    t_span = checked_span(t_span)
    if is_orbit(motion):
        if operator.index(points) < 2:
            raise ValueError(f"points must be at least 2, got {points!r}")
        return _sample_orbit(motion, direction, window(motion, t_span), points)
    if is_trajectory(motion):
        return _sample_trajectory(motion, direction, t_span)
    raise not_a_motion(motion)


def checked_span(t_span: tuple[float, float] | None) -> tuple[float, float] | None:
    """Return a span of time as two numbers, or say what is wrong with it."""
    if t_span is None:
        return None
    try:
        start, end = (float(value) for value in t_span)
    except (TypeError, ValueError):
        start = end = np.nan
    if not (np.isfinite(start) and np.isfinite(end) and start < end):
        raise ValueError(f"t_span must be a finite (start, end) with start < end, got {t_span!r}")
    return start, end


def not_a_motion(motion: object) -> ValueError:
    """Make the error for data that are neither an orbit nor a trajectory."""
    return ValueError(
        f"motion must be an orbit or a trajectory, got {type(motion).__name__}; of several orbits pass one, orbits[0]"
    )


def poincare_states(
    motion: Orbit | Trajectory, direction: Direction, t_span: tuple[float, float] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return position and velocity at the whole forcing periods: of an orbit, of a trajectory in `t_span`.

    A trajectory that has not kept its motion gives the rows it has at these times, perhaps none.
    """
    forcing_period = motion.scene.period
    if forcing_period is None:
        raise ValueError("motion must be forced to have Poincare points, got scene.period = None")
    if is_orbit(motion):
        count = max(1, round(motion.period / forcing_period))
        times = forcing_period * np.arange(count, dtype=float)
    else:
        start, end = window(motion, t_span)
        if is_swept(motion):
            times = forcing_turns(motion, start, end)
        else:
            first = np.ceil(start / forcing_period - SAME_POINT)
            last = np.floor(end / forcing_period + SAME_POINT)
            times = np.clip(forcing_period * np.arange(first, last + 1.0), start, end)
    times = _snapped(times, np.unique(motion.impacts["time"]), SAME_POINT * forcing_period)
    try:
        return direction.of(motion.position(times)), direction.of(motion.velocity(times, side="after"))
    except ValueError:
        if not is_trajectory(motion):
            raise
    t = np.asarray(motion.t, dtype=float)
    phase = t / forcing_period
    rows = np.flatnonzero((np.abs(phase - np.round(phase)) <= SAME_POINT) & (t >= start) & (t <= end))
    rows = rows[np.append(t[rows][1:] != t[rows][:-1], True)] if len(rows) else rows  # of two sides the one after
    return direction.of(np.asarray(motion.q)[rows]), direction.of(np.asarray(motion.v)[rows])


def _sample_orbit(orbit: Orbit, direction: Direction, t_span: tuple[float, float], points: int) -> Curve:
    """Sample the flights of an orbit in its first period, and move them to where they are drawn."""
    start, end = t_span
    period = float(orbit.period)
    step = float(orbit.scene.period or period) / points
    held = held_segments(orbit)
    ends_of_contact = [] if len(held) == 0 else [*held["start"], *held["end"]]
    bounds = np.unique(np.concatenate([[0.0], orbit.impacts["time"], ends_of_contact, [period]]))
    local, shifts, ends = [], [], []
    for turn in range(int(np.floor(start / period)), int(np.ceil(end / period))):
        shift = turn * period
        for left, right in pairwise(bounds):
            low, high = max(left, start - shift), min(right, end - shift)
            if high - low > SAME_TIME * period:
                count = max(MIN_POINTS, int(np.ceil((high - low) / step)) + 1)
                local.append(np.linspace(low, high, count))
                shifts.append(np.full(count, shift))
                ends.append(right)
    times = np.concatenate(local)
    last_rows = np.cumsum([len(flight) for flight in local]) - 1
    q = direction.of(orbit.position(times))
    v = np.array(direction.of(orbit.velocity(times, side="after")), dtype=float)
    v[last_rows] = direction.of(orbit.velocity(times[last_rows], side="before"))
    t = times + np.concatenate(shifts)
    starts = last_rows[:-1] + 1
    if ends[-1] - times[-1] <= SAME_TIME * period:  # the drawing ends on an impact: its other side
        after = np.array([ends[-1] % period])
        t = np.append(t, t[-1])
        q = np.append(q, direction.of(orbit.position(after)))
        v = np.append(v, direction.of(orbit.velocity(after, side="after")))
        starts = last_rows + 1
    t[starts] = t[starts - 1]
    return _curve(t, q, v, starts)


def _sample_trajectory(trajectory: Trajectory, direction: Direction, t_span: tuple[float, float] | None) -> Curve:
    """Take the rows of a trajectory and add what they lack: sides of impacts, ends of the window, points of long flights."""
    start, end = window(trajectory, t_span)
    t = np.asarray(trajectory.t, dtype=float)
    inside = (t >= start) & (t <= end)
    t = t[inside]
    q = direction.of(np.asarray(trajectory.q, dtype=float)[inside])
    v = direction.of(np.asarray(trajectory.v, dtype=float)[inside])

    hits = np.unique(trajectory.impacts["time"])
    hits = hits[(hits > start) & (hits <= end)]
    margin = SAME_TIME * max(abs(start), abs(end))
    rows, n_sides = _sides(t, hits, margin)
    no_side, one_side = n_sides == 0, n_sides == 1

    # A single row at an impact is the side after.  Before each row: the sides that are missing, as (time, row, side).
    before = hits[no_side | one_side]
    before_rows = rows[no_side | one_side]
    before_t = before.copy()
    on_row = one_side[no_side | one_side]
    before_t[on_row] = t[before_rows[on_row]]
    wanted = np.concatenate([[start, end], *(span[1:] for span in contact_spans(trajectory, direction, (start, end)))])
    lone_ends = [value for value in np.unique(wanted) if not _is_near(value, t, margin) and not _is_near(value, hits, margin)]
    try:
        end_q, end_v = _states(trajectory, np.array(lone_ends), "after", direction)
        before_q, before_v = _states(trajectory, before, "before", direction)
        after_q, after_v = _states(trajectory, hits[no_side], "after", direction)
    except ValueError:  # the motion was not kept: break the line where a side is missing
        breaks = rows[no_side | one_side]
    else:
        breaks = np.array([], dtype=np.intp)
        where = np.concatenate([np.searchsorted(t, lone_ends), before_rows, rows[no_side]]).astype(np.intp)
        t_new = np.concatenate([lone_ends, before_t, hits[no_side]])
        order = np.lexsort((np.arange(len(where)), t_new, where))
        where = where[order]
        t = np.insert(t, where, t_new[order])
        q = np.insert(q, where, np.concatenate([end_q, before_q, after_q])[order])
        v = np.insert(v, where, np.concatenate([end_v, before_v, after_v])[order])
        steps = np.flatnonzero(np.diff(t) > 0.0)
        t, (q, v) = refined(lambda times: _states(trajectory, times, "after", direction), t, (q, v), steps)
    pairs = np.flatnonzero(np.diff(t) == 0.0) + 1
    breaks = breaks[(breaks > 0) & (breaks < len(t))]
    return _curve(t, q, v, np.union1d(pairs, breaks).astype(np.intp))


def unseen_jumps(t: FloatArray, hits: FloatArray) -> IntArray:
    """Return the rows between which and the row before an impact lies, where not both of its sides are rows."""
    if len(t) == 0:
        return np.array([], dtype=np.intp)
    rows, n_sides = _sides(t, hits, SAME_TIME * max(abs(t[0]), abs(t[-1])))
    breaks = rows[n_sides < 2]
    return np.unique(breaks[(breaks > 0) & (breaks < len(t))]).astype(np.intp)


def _sides(t: FloatArray, hits: FloatArray, margin: float) -> tuple[IntArray, IntArray]:
    """Return the first row at or after each impact, and how many rows are at it: 2 sides, 1 (the one after) or none."""
    rows = np.searchsorted(t, hits - margin, side="left")
    return rows, np.searchsorted(t, hits + margin, side="right") - rows


def _is_near(value: float, sorted_values: FloatArray, margin: float) -> bool:
    """Say whether one of the values, which ascend, lies within a margin of this one."""
    row = int(np.searchsorted(sorted_values, value - margin))
    return row < len(sorted_values) and bool(sorted_values[row] <= value + margin)


def refined(
    ask: Callable[[FloatArray], Sequence[FloatArray]],
    t: FloatArray,
    rows: Sequence[FloatArray],
    left: IntArray,
    shortest: float = 0.0,
) -> tuple[FloatArray, list[FloatArray]]:
    """Split steps between rows, those with these rows on their left, until straight lines look smooth or steps are the shortest.

    `ask` gives the columns of `rows` at other times; where it cannot, they are all there is.
    """
    columns = list(rows)
    while 0 < len(left) <= MAX_ROWS - len(t):
        t_line, *on_line = (column[left] + SPLIT * (column[left + 1] - column[left]) for column in (t, *columns))
        try:
            new = ask(t_line)
        except ValueError:  # the motion was not kept
            break
        is_rough = np.any([_differs(*each) for each in zip(new, on_line, columns, strict=True)], axis=0)
        t, *columns = (np.insert(column, left + 1, more) for column, more in zip((t, *columns), (t_line, *new), strict=True))
        first = (left + np.arange(len(left)))[is_rough]  # the rough steps by their rows now, each in two parts
        left = np.sort(np.concatenate([first, first + 1]))
        left = left[t[left + 1] - t[left] > shortest]
    return t, columns


def _differs(values: FloatArray, on_line: FloatArray, drawn: FloatArray) -> NDArray[np.bool_]:
    """Say where values lie visibly off a straight line, in a figure that holds them and those drawn before."""
    low, high = min(np.min(values), np.min(drawn)), max(np.max(values), np.max(drawn))
    return np.abs(values - on_line) > SMOOTH * (high - low) + ROUNDING * max(-low, high)


def ramps_of(trajectory: object) -> tuple[Any, ...]:
    """Return the ramps of a trajectory."""
    ramp = getattr(trajectory, "ramp", None)
    return ramp if isinstance(ramp, tuple) else () if ramp is None else (ramp,)


def is_swept(trajectory: object) -> TypeGuard[Ramped]:
    """Whether the angle of the forcing goes otherwise than by the scene's own frequency."""
    return any(ramp.parameter in ("frequency", "phase") for ramp in ramps_of(trajectory))


def forcing_turns(trajectory: Ramped, start: float, end: float) -> FloatArray:
    """Return the times at which the angle of the forcing has made whole turns, counted as ``w t`` is without a ramp."""
    rates = [2.0 * np.pi / float(trajectory.scene.period or np.inf)]
    if any(ramp.parameter == "frequency" for ramp in ramps_of(trajectory)):
        rates.extend(trajectory.parameter(np.linspace(start, end, 257), "frequency"))
    grid = np.linspace(start, end, 2 + int(np.ceil((end - start) * max(rates) * PER_RADIAN)))
    angles = np.unwrap(trajectory.phase(grid))
    origin = angles[0] - rates[0] * start
    turns = origin + 2.0 * np.pi * np.arange(
        np.ceil((angles[0] - origin) / (2.0 * np.pi) - SAME_POINT),
        np.floor((angles[-1] - origin) / (2.0 * np.pi) + SAME_POINT) + 1.0,
    )
    times = np.interp(turns, angles, grid)
    for _ in range(POLISHES):
        off = np.mod(trajectory.phase(times) - turns + np.pi, 2.0 * np.pi) - np.pi
        slope = np.interp(times, grid[1:], np.diff(angles) / np.diff(grid))
        times = np.clip(times - off / slope, start, end)
    return np.asarray(times)


def window(motion: Orbit | Trajectory, t_span: tuple[float, float] | None) -> tuple[float, float]:
    """Return the times that are drawn: what a trajectory covers, or its part in `t_span`; one period of an orbit, or `t_span`."""
    if is_orbit(motion):
        return t_span or (0.0, float(motion.period))
    if not is_trajectory(motion):
        raise not_a_motion(motion)
    t = np.asarray(motion.t, dtype=float)
    if len(t) == 0:
        raise ValueError("trajectory must have rows to draw, got none: simulate with keep='motion' or give t_eval")
    if t_span is None:
        return float(t[0]), float(t[-1])
    start, end = max(t_span[0], float(t[0])), min(t_span[1], float(t[-1]))
    if start > end:
        raise ValueError(f"t_span must meet the trajectory's times, {t[0]:g} to {t[-1]:g}, got {t_span!r}")
    return start, end


def _states(
    trajectory: Trajectory, times: FloatArray, side: Literal["after", "before"], direction: Direction
) -> tuple[FloatArray, FloatArray]:
    """Ask a trajectory for states between its rows; nothing is asked for no times."""
    if len(times) == 0:
        return np.empty(0), np.empty(0)
    return direction.of(trajectory.position(times)), direction.of(trajectory.velocity(times, side=side))


def _snapped(times: FloatArray, hits: FloatArray, margin: float) -> FloatArray:
    """Move times that lie within `margin` of an impact onto it, so that all take the same side."""
    if len(hits) == 0 or len(times) == 0:
        return times
    right = np.clip(np.searchsorted(hits, times), 0, len(hits) - 1)
    left = np.maximum(right - 1, 0)
    nearest = np.where(np.abs(hits[left] - times) < np.abs(hits[right] - times), hits[left], hits[right])
    return np.where(np.abs(nearest - times) <= margin, nearest, times)


def _curve(t: FloatArray, q: FloatArray, v: FloatArray, starts: IntArray) -> Curve:
    """Make a curve, keeping the breaks at which this direction jumps or may have jumped unseen."""
    largest = np.max(np.abs(v), initial=0.0)
    is_jump = np.abs(v[starts] - v[starts - 1]) > SMALL_JUMP * largest
    is_unseen = t[starts] != t[starts - 1]
    return Curve(t, q, v, starts[is_jump | is_unseen])

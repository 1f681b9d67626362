"""Linear systems, and others without a geometry of their own: each coordinate a mass on a track, stops where its gap is zero.

A stop whose normal mixes coordinates has a track of its own, for `n.q`. Positions are those of the coordinates: with base
motion, relative to the base.
"""

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from vibroimpact.plot._axes import STOP_LABEL, label_axis, with_defaults
from vibroimpact.plot._data import FloatArray
from vibroimpact.plot._film import SUBSTEPS, Film
from vibroimpact.plot._solid import draw_flash, draw_solid, half_width

FEW_COORDINATES = 8  # of more only those that a stop acts on alone are drawn, unless others are asked for
WALL_HEIGHT = 0.36  # of a stop above and below its track [tracks]
MARGIN = 0.1  # of the range of positions
WIDTH, AROUND, TRACK_HEIGHT = 6.4, 1.0, 0.7  # of a figure: its width, the room of labels, of each track [inches]
TRAIL_LABEL = "_trail"


def tracks(scene: Any, coordinates: Sequence[int] | None) -> tuple[FloatArray, list[str], list[tuple[int, float, bool] | None]]:
    """Return the tracks' normals (k, n), their names, and for each stop its track, its place on it, whether it is solid above."""
    n = scene.n_dof
    chosen = _chosen(scene, coordinates)
    rows = [np.eye(n)[j] for j in chosen]
    names = [f"q[{j}]" for j in chosen]
    places: list[tuple[int, float, bool] | None] = []
    for index, stop in enumerate(scene.stops):
        normal = _normal(stop, n)
        if normal is None:
            places.append(None)
            continue
        found = [(k, float(row @ normal / (row @ row))) for k, row in enumerate(rows)]
        on = next((at for at in found if np.allclose(at[1] * rows[at[0]], normal, rtol=1e-12, atol=0.0)), None)
        if on is None and np.count_nonzero(normal) == 1:
            places.append(None)  # of a coordinate that was not asked for
            continue
        if on is None:
            rows.append(normal)
            names.append(f"n·q of stop {index}")
            on = len(rows) - 1, 1.0
        scale = -on[1] if stop.side == "lower" else on[1]
        places.append((on[0], float(stop.clearance / scale), scale > 0.0))
    return np.array(rows), names, places


def _chosen(scene: Any, coordinates: Sequence[int] | None) -> list[int]:
    """Return the coordinates that have a track."""
    n = scene.n_dof
    if coordinates is not None:
        return [_coordinate(j, n) for j in coordinates]
    if n <= FEW_COORDINATES:
        return list(range(n))
    normals = [_normal(stop, n) for stop in scene.stops]
    alone = sorted({int(np.flatnonzero(normal)[0]) for normal in normals if normal is not None and np.count_nonzero(normal) == 1})
    has_others = any(normal is not None and np.count_nonzero(normal) > 1 for normal in normals)
    return alone if alone or has_others else list(range(FEW_COORDINATES))


def _coordinate(index: int, n: int) -> int:
    try:
        checked = operator.index(index)
    except TypeError:
        checked = -1
    if not 0 <= checked < n:
        raise ValueError(f"coordinates must be indices from 0 to {n - 1}, got {index!r}")
    return checked


def _normal(stop: Any, n: int) -> FloatArray | None:
    """Return the normal of a stop as a vector; a stop given by functions has none."""
    normal = getattr(stop, "normal", None)
    if normal is None:
        return None
    return np.eye(n)[normal] if np.ndim(normal) == 0 else np.asarray(normal, dtype=float)


class Masses:
    """The artists of masses on tracks, put where a frame has them."""

    def __init__(self, ax: Axes, scene: Any, film: Film, coordinates: Sequence[int] | None, line: dict[str, Any]) -> None:
        """Make the artists; the limits hold every frame and every stop that has a track."""
        normals, names, self.places = tracks(scene, coordinates)
        self.film, self.p = film, film.path @ normals.T
        base = scene.forcing is not None and np.ndim(scene.forcing.amplitude) == 0
        label_axis(ax, "x", "position relative to the base" if base else "position")
        self.heights = -np.arange(len(names), dtype=float)
        self._set_limits(ax, names)
        options = with_defaults(
            line, linestyle="none", marker="s", markersize=16.0, color="C0", markeredgecolor="black", zorder=3.0, label="masses"
        )
        self.masses = ax.plot([], [], **options)[0]
        aside = half_width(self.masses)
        for index, place in enumerate(self.places):
            if place is not None:
                track, position, above = place
                wall = draw_solid(ax, not above, f"{STOP_LABEL}{index}", aside if above else -aside)
                height = self.heights[track]
                wall.set_data([position, position], [height - WALL_HEIGHT, height + WALL_HEIGHT])
        colour = self.masses.get_color()
        self.trails = [ax.plot([], [], color=colour, linewidth=2.0, alpha=0.5, label=TRAIL_LABEL, zorder=2.0)[0] for _ in names]
        self.flashes = [draw_flash(ax, self.masses) for _ in self.places]

    @property
    def size(self) -> tuple[float, float]:
        """The size of a figure for it [inches]: so much for each track."""
        return WIDTH, AROUND + TRACK_HEIGHT * len(self.heights)

    def show(self, frame: int) -> None:
        """Put everything where a frame has it."""
        p = self.p[frame * SUBSTEPS]
        self.masses.set_data(p, self.heights)
        rows = self.film.trail_rows(frame)
        for track, trail in enumerate(self.trails):
            trail.set_data(self.p[rows, track], np.full(len(self.p[rows]), self.heights[track]))
        for index, place in enumerate(self.places):
            hit = [place[0]] if place is not None else list(range(len(p)))
            self.flashes[index].set_data(p[hit], self.heights[hit])
            self.flashes[index].set_alpha(self.film.glow[frame, index])

    def _set_limits(self, ax: Axes, names: list[str]) -> None:
        walls = [place[1] for place in self.places if place is not None]
        low, high = min(self.p.min(), *walls, np.inf), max(self.p.max(), *walls, -np.inf)
        pad = MARGIN * (high - low) or 1.0
        ax.set_xlim(low - pad, high + pad)
        ax.set_ylim(self.heights[-1] - 0.6, 0.6)
        ax.yaxis.set_major_locator(FixedLocator(self.heights.tolist()))
        ax.set_yticks(self.heights, names)
        for height in self.heights:
            ax.axhline(height, color="0.85", linewidth=1.0, label="_track", zorder=0.5)

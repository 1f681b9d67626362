"""Pendulums as they hang: links from a base that moves to and fro, walls and stops that move with it.

Angles are from the downward vertical, x to the right, y upwards; the base is at (u(t), 0).
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibroimpact.plot._axes import STOP_LABEL, label_axis, with_defaults
from vibroimpact.plot._data import FloatArray
from vibroimpact.plot._film import SUBSTEPS, Film
from vibroimpact.plot._solid import draw_flash, draw_solid, half_width

BASE_WIDTH = 0.08  # half of it, in the length of all links
NARROWEST = 0.6  # width of a picture, in its height
MARGIN = 0.12  # of the height of the picture
ROOM, AROUND = (5.4, 4.6), (1.0, 0.8)  # of a figure, for the picture and around it [inches]
FAR = 1.5  # of the length of all links: walls further away are not brought into the picture
TRAIL_LABEL = "_trail"


def link_lengths(system: Any) -> FloatArray | None:
    """Return the lengths of a pendulum's links, in its first one where it has ratios only; None for other systems."""
    if hasattr(system, "lengths"):
        return np.asarray(system.lengths, dtype=float)
    if hasattr(system, "length_ratio"):
        return np.array([1.0, 1.0 / system.length_ratio])
    return None


def base_displacement(forcing: Any, t: FloatArray) -> FloatArray:
    """Return where the base is, `amplitude cos(frequency t + phase)`; without base motion it stays at 0."""
    if forcing is None or np.ndim(forcing.amplitude) > 0:
        return np.zeros_like(t)
    return np.asarray(forcing.amplitude * np.cos(forcing.frequency * t + forcing.phase))


def joints(lengths: FloatArray, q: FloatArray, base: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the base and of every bob, each of shape (m, n + 1)."""
    steps = np.zeros((2, len(q), len(lengths) + 1))
    steps[0, :, 0] = base
    steps[0, :, 1:] = lengths * np.sin(q)
    steps[1, :, 1:] = -lengths * np.cos(q)
    x, y = np.cumsum(steps, axis=2)
    return x, y


def limit_angle(stop: Any, q: FloatArray) -> tuple[int, FloatArray, bool]:
    """Return the last link that a stop acts on, its angle in contact, the others as in `q`, and if that is an upper limit."""
    normal = np.zeros(q.shape[1])
    if np.ndim(stop.normal) == 0:
        normal[stop.normal] = 1.0
    else:
        normal[:] = stop.normal
    if stop.side == "lower":
        normal = -normal
    link = int(np.flatnonzero(normal)[-1])
    others = q @ normal - q[:, link] * normal[link]
    return link, (stop.clearance - others) / normal[link], bool(normal[link] > 0.0)


class Links:
    """The artists of a pendulum, put where a frame has them."""

    def __init__(self, ax: Axes, scene: Any, lengths: FloatArray, film: Film, line: dict[str, Any]) -> None:
        """Make the artists; the limits hold the pendulum in every frame, and the walls that are near."""
        self.film, self.scene, self.lengths = film, scene, lengths
        self.x, self.y = joints(lengths, film.path, base_displacement(scene.forcing, film.path_t))
        label_axis(ax, "x", "x")
        label_axis(ax, "y", "y")
        ax.set_aspect("equal", adjustable="box")
        self._set_limits(ax)
        self.rail = ax.plot([], [], color="0.25", linewidth=3.0, label="_base", zorder=1.0)[0]
        options = with_defaults(line, marker="o", markersize=8.0, linewidth=2.0, color="C0", zorder=3.0, label="pendulum")
        self.chain = ax.plot([], [], **options)[0]
        aside = half_width(self.chain)
        self.stops = [draw_solid(ax, left, label, aside * way) for left, label, way in self._solid_sides()]
        colour = self.chain.get_color()
        self.trail = ax.plot([], [], color=colour, linewidth=1.0, alpha=0.6, label=TRAIL_LABEL, zorder=2.0)[0]
        self.flashes = [draw_flash(ax, self.chain) for _ in scene.stops]

    @property
    def size(self) -> tuple[float, float]:
        """The size of a figure for it [inches]: as large as fits, in one scale."""
        scale = min(room / extent for room, extent in zip(ROOM, self.extent, strict=True))
        return AROUND[0] + scale * self.extent[0], AROUND[1] + scale * self.extent[1]

    def show(self, frame: int) -> None:
        """Put everything where a frame has it."""
        row = frame * SUBSTEPS
        x, y = self.x[row], self.y[row]
        half = BASE_WIDTH * self.lengths.sum()
        self.rail.set_data([x[0] - half, x[0] + half], [0.0, 0.0])
        self.chain.set_data(x, y)
        rows = self.film.trail_rows(frame)
        self.trail.set_data(self.x[rows, -1], self.y[rows, -1])
        for index, stop in enumerate(self.scene.stops):
            self.stops[index].set_data(*self._stop_line(stop, row))
            bob = self._bob_of(stop)
            self.flashes[index].set_data([x[bob]], [y[bob]])
            self.flashes[index].set_alpha(self.film.glow[frame, index])

    def _solid_sides(self) -> list[tuple[bool | None, str, float]]:
        """Return whether each stop is solid on the left of its line, drawn upwards or away from the joint, its name, its side.

        The side is that of its place on which the face of a bob touches it: 1 right, -1 left, 0 neither.
        """
        sides: list[tuple[bool | None, str, float]] = []
        for index, stop in enumerate(self.scene.stops):
            if hasattr(stop, "bob"):
                sides.append((stop.side == "left", f"{STOP_LABEL}{index}", -1.0 if stop.side == "left" else 1.0))
            elif hasattr(stop, "normal"):
                sides.append((limit_angle(stop, self.film.path[:1])[2], f"{STOP_LABEL}{index}", 0.0))
            else:
                sides.append((None, f"_{STOP_LABEL}{index}", 0.0))
        return sides

    def _stop_line(self, stop: Any, row: int) -> tuple[list[float], list[float]]:
        """Return x and y of the line that shows a stop; of one given by functions there is none."""
        x, y = self.x[row], self.y[row]
        if hasattr(stop, "bob"):
            place = float(x[0] + stop.position)
            return [place, place], list(self.wall_span)
        if not hasattr(stop, "normal"):
            return [], []
        link, angle, _ = limit_angle(stop, self.film.path[row : row + 1])
        x0, y0, length = x[link], y[link], self.lengths[link]
        return [x0, x0 + length * np.sin(angle[0])], [y0, y0 - length * np.cos(angle[0])]

    def _bob_of(self, stop: Any) -> int:
        """Return the bob, counted from 1, that flashes when a stop is hit."""
        if hasattr(stop, "bob"):
            return int(stop.bob) + 1
        if hasattr(stop, "normal"):
            return limit_angle(stop, self.film.path[:1])[0] + 1
        return len(self.lengths)

    def _set_limits(self, ax: Axes) -> None:
        reach = float(self.lengths.sum())
        walls = [stop.position for stop in self.scene.stops if hasattr(stop, "bob") and abs(stop.position) <= FAR * reach]
        base, rail = self.x[:, 0], BASE_WIDTH * reach
        ends = [
            base.min() - rail,
            base.max() + rail,
            *(base.min() + wall for wall in walls),
            *(base.max() + wall for wall in walls),
        ]
        low, high = min(self.x.min(), *ends), max(self.x.max(), *ends)
        bottom, top = float(self.y.min()), max(float(self.y.max()), 0.0)
        lack = 0.5 * max(0.0, NARROWEST * (top - bottom) - (high - low))
        low, high = low - lack, high + lack
        pad = MARGIN * max(high - low, top - bottom)
        self.extent = (high - low + 2.0 * pad, top - bottom + 2.0 * pad)
        ax.set_xlim(low - pad, high + pad)
        ax.set_ylim(bottom - pad, top + pad)
        self.wall_span = (bottom - 0.7 * pad, top + 0.7 * pad)

"""What an animation shows at each frame: the times, the positions, the path of the trail, which stop has just been hit.

Times of the motion and of the playback are proportional: `speed` units of the motion's time pass in one second.
"""

import operator
from dataclasses import dataclass

import numpy as np

from vibroimpact.plot._data import FloatArray, Orbit, Trajectory
from vibroimpact.plot._impacts import impacts_of
from vibroimpact.plot._sampling import checked_span, window
from vibroimpact.plot._segments import contacts

SUBSTEPS = 4  # points of the trail in one frame
FADE = 0.3  # time in which the flash of an impact dies away, in playback [s]
NOT_EARLIER = 1e-9  # of a frame: an impact at the time of a frame is shown in it


@dataclass(frozen=True)
class Film:
    """Frames of a motion; `path` has `SUBSTEPS` rows a frame, frame k at row `k * SUBSTEPS`.

    `glow` has a row for each frame and a column for each stop: 1 at an impact and in lasting contact, 0 some time after.
    """

    t: FloatArray
    path_t: FloatArray
    path: FloatArray
    glow: FloatArray
    trail: int

    @property
    def q(self) -> FloatArray:
        """Positions at the frames, shape (n_frames, n)."""
        return self.path[::SUBSTEPS]

    @property
    def decimals(self) -> int:
        """Decimals that tell the times of two frames apart."""
        return int(np.clip(np.ceil(-np.log10(max(self.t[-1] - self.t[0], 1e-300) / len(self.t))), 0, 9))

    def trail_rows(self, frame: int) -> slice:
        """Return the rows of the path that the trail of a frame has."""
        end = frame * SUBSTEPS + 1
        return slice(max(0, end - self.trail), end)


def make_film(
    motion: Orbit | Trajectory,
    t_span: tuple[float, float] | None,
    *,
    fps: float,
    speed: float | None,
    max_frames: int,
    trail: float,
) -> Film:
    """Take the frames of a motion, or say which argument is wrong."""
    start, end = window(motion, checked_span(t_span))
    fps, trail = _number("fps", fps, least=None), _number("trail", trail, least=0.0)
    speed = None if speed is None else _number("speed", speed, least=None)
    n_frames, step = _frames(end - start, fps, speed, max_frames)
    path_t = np.clip(start + step / SUBSTEPS * np.arange((n_frames - 1) * SUBSTEPS + 1), start, end)
    t = path_t[::SUBSTEPS]
    path = np.asarray(motion.position(path_t), dtype=float)
    glow = _glow(motion, t, fade=FADE * fps * step, margin=NOT_EARLIER * step)
    return Film(t, path_t, path, glow, round(min(trail * fps, n_frames) * SUBSTEPS) + 1 if trail > 0.0 else 0)


def _number(name: str, value: float, least: float | None) -> float:
    """Return a finite number that is above 0, or not below `least`."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not (np.isfinite(number) and (number > 0.0 if least is None else number >= least)):
        raise ValueError(f"{name} must be a finite number {'above 0' if least is None else f'from {least:g}'}, got {value!r}")
    return number


def _frames(duration: float, fps: float, speed: float | None, max_frames: int) -> tuple[int, float]:
    """Return the number of frames and the motion's time from one to the next."""
    try:
        most = operator.index(max_frames)
    except TypeError:
        most = 0
    if most < 2:
        raise ValueError(f"max_frames must be an integer from 2, got {max_frames!r}")
    wanted = duration * fps / (speed or 1.0) * (1.0 + NOT_EARLIER) + 1.0
    if wanted < most + 1.0:
        return int(wanted), (speed or 1.0) / fps
    if speed is None:
        return most, duration / (most - 1)
    raise ValueError(
        f"max_frames must not be below the {wanted:.0f} frames of {duration:g} time units at fps={fps:g} and speed={speed:g}, "
        f"got {most}: raise it, or give a shorter t_span or a higher speed"
    )


def _glow(motion: Orbit | Trajectory, t: FloatArray, fade: float, margin: float) -> FloatArray:
    """Return how brightly each stop shines at each frame."""
    glow = np.zeros((len(t), len(motion.scene.stops)))
    times, stops = impacts_of(motion, t[0] - fade, t[-1] + margin)
    for index in range(glow.shape[1]):
        hits = times[stops == index]
        if len(hits):
            last = np.searchsorted(hits, t + margin, side="right") - 1
            since = np.where(last < 0, np.inf, t - hits[np.maximum(last, 0)])
            glow[:, index] = np.clip(1.0 - since / fade, 0.0, 1.0)
    for _, stop, start, end in contacts(motion, None, (float(t[0]), float(t[-1]))):
        glow[(t >= start) & (t <= end), stop] = 1.0
    return glow

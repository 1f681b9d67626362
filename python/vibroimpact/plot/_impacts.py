"""Times and stops of the impacts of a motion; those of an orbit repeat with its period."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact.plot._data import FloatArray, Orbit, Trajectory, is_orbit


def impacts_of(motion: Orbit | Trajectory, start: float, end: float) -> tuple[FloatArray, NDArray[Any]]:
    """Return times and stops of the impacts: of an orbit those of every period that meets a span of time."""
    times, stops = motion.impacts["time"], motion.impacts["stop"]
    if is_orbit(motion):
        turns = np.arange(np.floor(start / motion.period), np.ceil(end / motion.period) + 1.0)
        times = (motion.period * turns[:, None] + times).ravel()
        stops = np.tile(stops, len(turns))
    return times, stops

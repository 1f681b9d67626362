"""The scenes whose parts are costed: a pair of masses, a pendulum, a ball on a shaken table.

Forces and damping that a feature adds are so small that the motion, and with it the search for impacts, stays the same: what
differs between two cases is the machinery. The pair is the one of `benches/scene_cost.rs`, so that both languages are
measured on the same motion.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import vibroimpact as vi

# Changes the motion by nothing that can be seen.
SMALL = 1e-9
MASS = [[2.0, 0.5], [0.5, 1.0]]
STIFFNESS = [[5.0, -2.0], [-2.0, 3.0]]
NONE = [[0.0, 0.0], [0.0, 0.0]]
PROPORTIONAL = [[5.0 * SMALL, -2.0 * SMALL], [-2.0 * SMALL, 3.0 * SMALL]]
OTHER = [[SMALL, 0.0], [0.0, 0.0]]
FREQUENCY = 0.77
DASHPOT = 1e-6  # so weak that thousands of contacts follow each other
START = [0.0, 0.0], [0.7, 0.7]
# Time between two impacts of the pair, and between two Runge-Kutta steps.
IMPACT_EVERY, STEP_EVERY = 3.2, 0.1
LOOSE = 1e-6
GRAVITY = 9.81
TABLE = 2.0 * math.pi * 20.0  # [rad/s]
PERIOD = 2.0 * math.pi / TABLE
DROP = 5e-3  # [m]
# Acceleration of the table [g] and restitution of a ball that bounces once a period, and of one that chatters and rests.
BOUNCING, CHATTERING = (0.6, 0.8), (1.3, 0.4)


def stops(count: int, restitution: float = 1.0) -> list[vi.Stop]:
    """Up to four stops on the pair, the first of which alone is ever reached."""
    near = vi.Stop(0, 0.1, restitution)
    far = [vi.Stop(1, 50.0, 1.0), vi.Stop(1, 60.0, 1.0, side="lower"), vi.Stop(0, 70.0, 1.0, side="lower")]
    return [near, *far][:count]


def harmonic() -> vi.Harmonic:
    """A force that changes nothing."""
    return vi.Harmonic([SMALL, SMALL], FREQUENCY)


def harmonics() -> vi.Fourier:
    """Three harmonics that change nothing."""
    return vi.Fourier(SMALL * np.ones((3, 2)), FREQUENCY)


def record(span: float, every: float) -> vi.Load:
    """A force that follows a record with a sample at such steps, and changes nothing."""
    t = np.arange(int(span / every) + 2) * every
    return vi.Load(0, (t, SMALL * np.cos(FREQUENCY * t)))


def moving_stop() -> vi.Stop:
    """The first stop, which moves by nothing that can be seen."""
    return vi.Stop(0, 0.1, 1.0, motion=vi.Harmonic([SMALL], FREQUENCY))


def spring_out_of_reach() -> vi.Stop:
    """A stop in the place of the second one that gives way and is never reached."""
    return vi.Stop(1, 50.0, contact=vi.Spring(100.0, 1.0, release="gap"))


def pair(damping: Any = NONE, forcing: Any = None, stops: Any = (), load: Any = None) -> vi.Scene:
    """Two masses with the given parts."""
    return vi.Scene(vi.LinearSystem(MASS, damping, STIFFNESS, load=load), forcing, stops)


def pendulum(damping: Any = (0.0, 0.0), forcing: Any = None, walls: Any = ()) -> vi.Scene:
    """A double pendulum with large angles and the given parts."""
    return vi.Scene(vi.DoublePendulum(1.0, 2.0, damping), forcing, walls)


def ball(acceleration: float, restitution: float) -> vi.Scene:
    """A ball on a table that is shaken with an acceleration in g."""
    system = vi.LinearSystem([1.0], [0.0], [0.0], load=[-GRAVITY], influence=[1.0])
    table = vi.BaseMotion(acceleration * GRAVITY / TABLE**2, TABLE)
    return vi.Scene(system, table, vi.Stop(0, 0.0, restitution, side="lower"))


def acceleration_matrix() -> np.ndarray[Any, np.dtype[np.float64]]:
    """`-M^-1 K` of the pair."""
    return -np.linalg.solve(MASS, STIFFNESS)

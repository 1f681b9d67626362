"""Motions with a closed form, modes, multipliers and a map to draw, and what the tests read off the artists."""

from dataclasses import dataclass, field
from itertools import pairwise
from types import SimpleNamespace

import numpy as np

IMPACT = np.dtype(
    [
        ("time", float),
        ("stop", int),
        ("speed_before", float),
        ("speed_after", float),
        ("impulse", float),
        ("phase", float),
    ]
)


def impacts_at(times, stop=0):
    """Impacts with the times that matter here."""
    impacts = np.zeros(len(times), IMPACT)
    impacts["time"] = times
    impacts["stop"] = stop
    return impacts


def stop(normal, clearance, side="upper"):
    return SimpleNamespace(normal=np.asarray(normal, float), clearance=clearance, restitution=1.0, side=side)


# The second coordinate turns with the bounce of the first; stop 3 mixes both, stop 4 has no normal.
STOPS = (
    stop([2.0, 0.0], 0.0, "lower"),
    stop([0.0, -0.5], 0.6),
    stop([0.0, 0.5], 0.75),
    stop([1.0, 1.0], 9.0),
    SimpleNamespace(bob=1, position=0.3),
)


class Bounce:
    """A ball thrown up at speed 1 under gravity 1: q0 = s - s^2/2, back at s = 2; q1 = cos(pi t); forcing period 1."""

    def __init__(self, forcing_period=1.0):
        self.scene = SimpleNamespace(n_dof=2, period=forcing_period, stops=STOPS)

    def position(self, t):
        t = np.asarray(t, float)
        s = t % 2.0
        return np.column_stack([s - s * s / 2, np.cos(np.pi * t)])

    def velocity(self, t, side="after"):
        t = np.asarray(t, float)
        s = t % 2.0
        if side == "before":
            s = np.where(s == 0.0, 2.0, s)
        return np.column_stack([1.0 - s, -np.pi * np.sin(np.pi * t)])

    def gap(self, stop, t):
        """Those of plane stops."""
        which = self.scene.stops[stop]
        along = self.position(t) @ which.normal
        return which.clearance + (along if which.side == "lower" else -along)

    def contact_force(self, stop, t):
        """As if stop 0 were held for the first half of every flight, with a force 2 - t."""
        s = np.asarray(t, float) % 2.0
        return np.where((stop == 0) & (s < 1.0), 2.0 - s, 0.0)


class BouncingOrbit(Bounce):
    period = 2.0
    n_periods = 2
    impacts = impacts_at([0.0])


class BouncingTrajectory(Bounce):
    """The same from 0 to `end`, by the rows for drawing or at `t_eval`."""

    def __init__(self, end=7.0, t_eval=None, keeps_motion=True, forcing_period=1.0):
        super().__init__(forcing_period)
        self.keeps_motion = True
        hits = np.arange(2.0, end, 2.0)
        if t_eval is None:
            flights = [np.linspace(*ends, 21) for ends in pairwise([0.0, *hits, end])]
            self.t = np.concatenate(flights)
            self.v = np.vstack([np.vstack([self.velocity(t[:-1]), self.velocity(t[-1:], side="before")]) for t in flights])
        else:
            self.t = np.asarray(t_eval, float)
            self.v = self.velocity(self.t)
        self.q = self.position(self.t)
        self.impacts = impacts_at(hits)
        self.keeps_motion = keeps_motion

    def position(self, t):
        self._check()
        return super().position(t)

    def velocity(self, t, side="after"):
        self._check()
        return super().velocity(t, side)

    def gap(self, stop, t):
        self._check()
        return super().gap(stop, t)

    def contact_force(self, stop, t):
        self._check()
        return super().contact_force(stop, t)

    def _check(self):
        if not self.keeps_motion:
            raise ValueError("keep must be 'motion'")


class LedgerOfABall:
    """A ball dropped from height 1/2 under gravity 1 on a floor with restitution 0: all its energy is lost at t = 1."""

    t = np.array([0.0, 0.5, 1.0, 1.0, 2.0])
    impacts = impacts_at([1.0])
    energy = SimpleNamespace(
        kinetic=np.array([0.0, 0.125, 0.5, 0.0, 0.0]),
        potential=np.array([0.5, 0.375, 0.0, 0.0, 0.0]),
        forcing_work=np.zeros(5),
        damping_loss=np.zeros(5),
        impact_loss=np.array([0.0, 0.0, 0.0, 0.5, 0.5]),
    )


class Shuttle:
    """A free particle between walls at 1 and -1, period 2: hits stop 0 at t = 0 and stop 1 at t = 1."""

    period = 2.0
    n_periods = 1
    impacts = impacts_at([0.0, 1.0], stop=[0, 1])
    scene = SimpleNamespace(n_dof=1, period=None, stops=(stop([1.0], 1.0), stop([1.0], 1.0, "lower")))

    def position(self, t):
        s = np.asarray(t, float) % 2.0
        return np.where(s < 1.0, 1.0 - 2.0 * s, 2.0 * s - 3.0)[:, None]

    def velocity(self, t, side="after"):
        s = np.asarray(t, float) % 2.0
        falls = s < 1.0 if side == "after" else (s > 0.0) & (s <= 1.0)
        return np.where(falls, -2.0, 2.0)[:, None]


def modes(n=3):
    chain = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    squares, shapes = np.linalg.eigh(chain)
    return SimpleNamespace(natural_frequencies=np.sqrt(squares), shapes=shapes, damping_ratios=np.full(n, 0.05))


def stable_orbit(orders, floquet_multipliers="first", reason="all inside the unit circle"):
    if isinstance(floquet_multipliers, str):
        floquet_multipliers = np.asarray(next(iter(orders.values())))
    return SimpleNamespace(floquet_multipliers=floquet_multipliers, stability=SimpleNamespace(orders=orders, reason=reason))


@dataclass
class Map:
    """One cell of each category in the first row, the second row all without an orbit."""

    x: object = field(default_factory=lambda: np.array([1.0, 2.0, 4.0, 8.0]))
    y: object = field(default_factory=lambda: np.array([0.1, 0.3]))
    x_name: str | None = "frequency"
    y_name: str | None = "clearance[1]"
    n_orbits: object = field(default_factory=lambda: np.array([[0, 1, 2, 1], [0, 0, 0, 0]]))
    is_admissible: object = field(default_factory=lambda: np.array([[0, 0, 1, 1], [0, 0, 0, 0]], bool))
    is_stable: object = field(default_factory=lambda: np.array([[0, 1, 0, 1], [0, 0, 0, 0]], bool))
    multiplier: object = field(default_factory=lambda: np.array([[np.nan, 0.3, 1.7, 0.4], [np.nan] * 4]))


def curve(ax, index=0):
    """The data of one line."""
    return np.asarray(ax.lines[index].get_xdata(), float), np.asarray(ax.lines[index].get_ydata(), float)


def labelled(ax, start):
    return [line for line in ax.lines if str(line.get_label()).startswith(start)]


def largest_step(values):
    return np.nanmax(np.abs(np.diff(values)))


def contains(ax, x, y):
    (x_low, x_high), (y_low, y_high) = sorted(ax.get_xlim()), sorted(ax.get_ylim())
    return bool(np.all((x >= x_low) & (x <= x_high) & (y >= y_low) & (y <= y_high)))

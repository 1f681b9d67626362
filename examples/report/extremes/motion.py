"""One degree of freedom by every method that applies.

Exact flights and Runge-Kutta steps take a `LinearSystem`. Taylor series take a link of unit mass and length, in swings of a
billionth of a radian: the sine of an angle is then the angle to 1e-19 of it, and the link the linear oscillator.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass

import numpy as np

import vibroimpact as vi
from report.extremes.condition import Truth, truth
from report.extremes.finding import ROUNDING, Finding, Rule, fact, measured, stepped
from report.extremes.oscillator import oscillator

SMALL = 2.0**-30  # angle of the link for a unit of position, where the motion does not grow
RTOL = 1e-11  # of steps
MARGIN = 1e-13  # rtol of exact flights, where it is only the width of a graze
ATOL = 1e-3  # of rtol, for motions of unit size
STEPPED = ("rk45", "dop853", "radau")  # any scene
LINEAR = ("exact", *STEPPED)
PENDULUM = ("taylor", *STEPPED)
EVERY = (*LINEAR, "taylor")  # in swings so small that a link is linear


@dataclass(frozen=True)
class Motion:
    """q'' + damping q' + stiffness q = load + force cos(frequency t + phase) from a state, for some time."""

    damping: float = 0.0
    stiffness: float = 0.0
    load: float = 0.0
    force: float = 0.0
    frequency: float = 1.0
    phase: float = 0.0
    q: float = 0.0
    v: float = 0.0
    start: float = 0.0
    length: float = 1.0

    @property
    def methods(self) -> tuple[str, ...]:
        """Methods that apply: no link carries a constant load, nor one whose base would move beyond the doubles."""
        is_constant = self.load or (self.force and self.frequency < 1e-100)
        return LINEAR if is_constant else EVERY

    @property
    def truth(self) -> Truth:
        """Position and velocity at the end."""
        return truth(oscillator, *astuple(self))


@dataclass(frozen=True)
class Side:
    """A stop of the coordinate."""

    clearance: float
    restitution: float
    side: str = "upper"


@dataclass(frozen=True)
class Run:
    """A trajectory in the units of its motion."""

    q: float
    v: float
    times: np.ndarray
    stops: list[int]
    before: np.ndarray
    after: np.ndarray
    impulses: np.ndarray
    trajectory: vi.Trajectory


def walls(clearance: float, restitution: float) -> tuple[Side, Side]:
    """A stop on each side."""
    return Side(clearance, restitution), Side(clearance, restitution, "lower")


def tolerance(method: str) -> float:
    """Rtol of a method; of exact flights it is the width of a graze and of contacts at rest."""
    return MARGIN if method == "exact" else RTOL


def rule_of(method: str) -> Rule:
    """Rounding for exact flights, the tolerance for steps."""
    return ROUNDING if method == "exact" else stepped(RTOL)


def scene_of(motion: Motion, sides: Sequence[Side], method: str, unit: float) -> vi.Scene:
    """The scene in which a method sees the motion, its positions times a unit."""
    m = motion
    stops = [vi.Stop(0, unit * s.clearance, s.restitution, side=s.side) for s in sides]
    if method == "taylor":
        link = vi.PendulumChain([1], [1], damping=m.damping, gravity=m.stiffness)
        base = vi.BaseMotion(unit * m.force / m.frequency**2, m.frequency, m.phase) if m.force else None
        return vi.Scene(link, base, stops)
    forcing = vi.Harmonic(m.force, m.frequency, m.phase) if m.force else None
    return vi.Scene(vi.LinearSystem(1, m.damping, m.stiffness, load=m.load), forcing, stops)


def run(
    motion: Motion,
    sides: Sequence[Side],
    method: str,
    *,
    size: float = 1.0,
    small: float = SMALL,
    rtol: float | None = None,
    keep: str = "motion",
) -> Run:
    """Simulate; ``size`` is that of the smallest motion that counts, ``small`` the angle of the link for a unit of position."""
    unit, chosen = (small if method == "taylor" else 1.0), (tolerance(method) if rtol is None else rtol)
    options = {"method": method, "rtol": chosen, "atol": ATOL * chosen * unit * size, "keep": keep}
    span = (motion.start, motion.start + motion.length)
    found = vi.simulate(scene_of(motion, sides, method, unit), unit * motion.q, unit * motion.v, span, **options)
    q, v = (float(np.ravel(x)[0]) / unit for x in found.final)
    speeds = (found.impacts[name] / unit for name in ("speed_before", "speed_after", "impulse"))
    return Run(q, v, found.impacts["time"], found.impacts["stop"].tolist(), *speeds, found)


def final_states(name: str, motion: Motion, small: float = SMALL) -> Iterator[Finding]:
    """The state at the end of a motion without stops, by each method."""
    expected = motion.truth
    for method in motion.methods:
        end = run(motion, (), method, small=small, keep="final")
        yield measured(f"{name}: q, v at t = {motion.start + motion.length:g}", method, [end.q, end.v], expected, rule_of(method))


def impacts(
    name: str, motion: Motion, sides: Sequence[Side], expected: Truth, order: Sequence[int], **options: object
) -> Iterator[Finding]:
    """Times and speeds of all impacts of a motion, and which stops were hit, by each method."""
    for method in motion.methods:
        found = run(motion, sides, method, keep="impacts", **options)
        yield fact(f"{name}: stops hit", method, shown(found.stops), shown(order))
        values = [found.times, found.before]
        yield measured(f"{name}: times and speeds of {len(order)} impacts", method, values, expected, rule_of(method))


def shown(order: Sequence[int]) -> str:
    """Stops in order, the first of them."""
    return f"{len(order)}: {' '.join(map(str, order[:12]))}{' ...' if len(order) > 12 else ''}"

"""Links at large angles, by series and by steps: elliptic integrals for one, extrapolation in many digits for two."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, Truth, truth
from report.extremes.extrapolated import State, extrapolated
from report.extremes.finding import Finding, fact, measured
from report.extremes.motion import ATOL, PENDULUM, RTOL, rule_of
from report.extremes.registry import case


def link(name: str, stops: Sequence[vi.Stop], q: float, v: float, end: float, expected: Truth) -> Iterator[Finding]:
    """A link of unit length under unit gravity between stops of its angle: times and speeds of its impacts."""
    scene = vi.Scene(vi.PendulumChain([1], [1], gravity=1), None, stops)
    count = len(expected.parts[0])
    for method in PENDULUM:
        found = vi.simulate(scene, q, v, (0, end), method=method, rtol=RTOL, atol=ATOL * RTOL).impacts[:count]
        values = [found["time"], found["speed_before"]]
        yield measured(f"{name}: times and speeds of {count} impacts", method, values, expected, rule_of(method))


def swings(count: int) -> Callable[..., Parts]:
    """Impacts at the lowest point, from rest at an angle: a quarter of a period, then to the height that is left and back.

    With e = 1 every half period; e is an input, so that the condition number knows what a change on the way does.
    """

    def function(angle: mpf, restitution: mpf) -> Parts:
        half_speeds = [mp.sin(angle / 2) * restitution**k for k in range(count)]
        times = [mp.ellipk(half_speeds[0] ** 2)]
        for x in half_speeds[1:]:
            times.append(times[-1] + 2 * mp.ellipk(x**2))
        return [times, [2 * x for x in half_speeds]]

    return function


@case("clearance 0")
def lowest() -> Iterator[Finding]:
    count = 8
    for angle in (1.0, 3.0, 3.14):
        expected = truth(swings(count), angle, 1.0)
        end = float(expected.parts[0][-1]) * (1 + 1e-3)
        stops = [vi.Stop(0, 0, 1, side="lower")]
        yield from link(f"a link let go at {angle:g} rad", stops, angle, 0, end, expected)


def leaning(count: int) -> Callable[..., Parts]:
    """Impacts on a stop beyond the lowest point: each flight leaves and returns at one speed, and goes up to its own angle."""

    def function(clearance: mpf, restitution: mpf, speed: mpf) -> Parts:
        times, speeds, low = [], [speed], mp.sin(-clearance / 2)
        for k in range(count):
            modulus = mp.sqrt(low**2 + (speeds[k] / 2) ** 2)
            flight = 2 * (mp.ellipk(modulus**2) - mp.ellipf(mp.asin(low / modulus), modulus**2))
            times.append(flight + (times[-1] if times else 0))
            speeds.append(speeds[k] * restitution)
        return [times, speeds[:count]]

    return function


@case("negative clearance (preloaded stop)")
def preloaded() -> Iterator[Finding]:
    for restitution, count in ((0.9, 40), (0.5, 8)):
        expected = truth(leaning(count), -0.5, restitution, 1.2)
        end = float(expected.parts[0][-1]) * (1 + 1e-6)
        stops = [vi.Stop(0, -0.5, restitution)]
        yield from link(f"a link, e = {restitution:g}", stops, -0.5, -1.2, end, expected)


def crossings(count: int) -> Callable[..., Parts]:
    """Elastic impacts of a fast link between stops at c and -c."""

    def function(clearance: mpf, speed: mpf) -> Parts:
        modulus = 4 / speed**2
        whole = 4 / speed * mp.ellipf(clearance / 2, modulus)
        hit = mp.sqrt(speed**2 - 4 * mp.sin(clearance / 2) ** 2)
        return [[whole * (k + mpf(1) / 2) for k in range(count)], [hit] * count]

    return function


@case("speeds so high that two impacts fall in one Runge-Kutta step")
def fast() -> Iterator[Finding]:
    count = 50
    expected = truth(crossings(count), 1.0, 1e6)
    stops = [vi.Stop(0, 1, 1), vi.Stop(0, 1, 1, side="lower")]
    yield from link("a link at 1e6 rad/s", stops, 0, 1e6, count * 2e-6, expected)


@case("stop on both sides closer than the motion")
def narrow() -> Iterator[Finding]:
    count = 50
    expected = truth(crossings(count), 1e-6, 1.9)
    stops = [vi.Stop(0, 1e-6, 1), vi.Stop(0, 1e-6, 1, side="lower")]
    yield from link("a link in a room of 1e-6 rad", stops, 0, 1.9, count * 2e-6 / 1.9, expected)


def double_pendulum(steps: int) -> Callable[..., Parts]:
    """Angles and speeds of the dimensionless double pendulum after some time."""

    def function(mass_ratio: mpf, length_ratio: mpf, *start: mpf) -> Parts:
        xi, mu = mass_ratio / (1 + mass_ratio), length_ratio
        alpha = xi / mu

        def rate(x: State) -> State:
            c, s = mp.cos(x[0] - x[1]), mp.sin(x[0] - x[1])
            first = -alpha * x[3] ** 2 * s - mp.sin(x[0]) / (1 + mass_ratio)
            second = mu * x[2] ** 2 * s - mu * mp.sin(x[1]) / (1 + mass_ratio)
            determinant = 1 - xi * c**2
            return [x[2], x[3], (first - alpha * c * second) / determinant, (second - mu * c * first) / determinant]

        *state, time = start
        end = extrapolated(rate, state, time, steps)
        return [end[:2], end[2:]]

    return function


def two_links(name: str, mass_ratio: float, length_ratio: float, end: float, steps: int) -> Iterator[Finding]:
    """Two links from half a radian."""
    q, v = [0.9, -0.7], [0.1, 0.2]
    expected = truth(double_pendulum(steps), mass_ratio, length_ratio, *q, *v, end)
    scene = vi.Scene(vi.DoublePendulum(mass_ratio, length_ratio))
    for method in PENDULUM:
        found = vi.simulate(scene, q, v, (0, end), method=method, rtol=RTOL, atol=ATOL * RTOL, keep="final")
        yield fact(f"{name}: status", method, found.status, "finished")
        yield measured(f"{name}: q, v at t = {end:g}", method, np.array(found.final), expected, rule_of(method))


@case("mass ratio 1e-6")
def light() -> Iterator[Finding]:
    yield from two_links("double pendulum, large angles", 1e-6, 1.0, 3.0, 10)


@case("mass ratio 1e6")
def heavy() -> Iterator[Finding]:
    yield from two_links("double pendulum, large angles", 1e6, 1.0, 0.03, 14)


@case("stiffness ratio 1e8")
def short_link() -> Iterator[Finding]:
    yield from two_links("double pendulum, lengths 1e8 to 1", 1.0, 1e8, 3e-4, 12)

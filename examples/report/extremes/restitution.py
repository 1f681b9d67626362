"""Restitution at its ends: a body between two stops, an oscillator at one."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mpmath import mp, mpf

from report.extremes.condition import Parts, known, truth
from report.extremes.finding import Finding, fact, measured
from report.extremes.motion import Motion, Side, impacts, rule_of, run, walls
from report.extremes.registry import case

COUNT = 40
BODY = Motion(v=2.0)


def between_walls(count: int) -> Callable[..., Parts]:
    """Times and speeds of the impacts of a free body that starts in the middle: 2 c/(v e^k) apart, v e^k."""

    def function(clearance: mpf, restitution: mpf, speed: mpf) -> Parts:
        times, speeds = [clearance / speed], [speed]
        for _ in range(count - 1):
            speeds.append(speeds[-1] * restitution)
            times.append(times[-1] + 2 * clearance / speeds[-1])
        return [times, speeds]

    return function


def bouncing(restitution: float) -> Iterator[Finding]:
    """A free body between two stops."""
    expected = truth(between_walls(COUNT), 0.5, restitution, BODY.v)
    length = float(expected.parts[0][-1]) * (1 + 1e-9)
    order = [0, 1] * (COUNT // 2)
    yield from impacts("a body between two stops", Motion(v=BODY.v, length=length), walls(0.5, restitution), expected, order)


@case("e = 1")
def elastic() -> Iterator[Finding]:
    yield from bouncing(1.0)
    yield from at_the_wall(1.0)


@case("e = 1 - 1e-12")
def nearly_elastic() -> Iterator[Finding]:
    yield from bouncing(1 - 1e-12)
    yield from at_the_wall(1 - 1e-12)


def at_the_wall(restitution: float) -> Iterator[Finding]:
    """An oscillator that swings to a stop at three quarters of its amplitude, twelve times."""
    count, sides = 12, [Side(0.75, restitution)]
    expected = truth(repeated(count), 0.75, restitution, 1.0)
    length = float(expected.parts[0][-1]) * (1 + 1e-9)
    motion = Motion(0.0, 1.0, v=1.0, length=length)
    yield from impacts("an oscillator at a stop", motion, sides, expected, [0] * count)


def repeated(count: int) -> Callable[..., Parts]:
    """Times and speeds of the impacts of q'' = -q on a stop at c > 0, from the middle; away and back takes 2 (pi - atan(v/c))."""

    def function(clearance: mpf, restitution: mpf, speed: mpf) -> Parts:
        times, speeds = [mp.asin(clearance / speed)], [mp.sqrt(speed**2 - clearance**2)]
        for _ in range(count - 1):
            speeds.append(speeds[-1] * restitution)
            times.append(times[-1] + 2 * (mp.pi - mp.atan(speeds[-1] / clearance)))
        return [times, speeds]

    return function


def after_first(clearance: mpf, restitution: mpf, speed: mpf, length: mpf) -> Parts:
    """Speed after the first impact of a free body, and its position and velocity later."""
    left = -restitution * speed
    return [[-left], [clearance + left * (length - clearance / speed)], [left]]


@case("e = 0")
def plastic() -> Iterator[Finding]:
    body = Motion(v=2.0, length=1e3)
    for method in body.methods:
        found = run(body, walls(1.0, 0.0), method)
        yield fact("a body stays where it hits: stops hit", method, found.stops, [0])
        yield measured(
            "time, q, v at the end", method, [found.times, [found.q], [found.v]], known([0.5], [1], [0]), rule_of(method)
        )
    spring = Motion(0.0, 1.0, v=2.0, length=2.0)
    expected = truth(pulled_back, 1.0, 2.0, spring.length)
    for method in spring.methods:
        found = run(spring, [Side(1.0, 0.0)], method)
        values = [found.times, [found.q], [found.v]]
        yield measured("a spring pulls it back at once: time, q, v", method, values, expected, rule_of(method))


def pulled_back(clearance: mpf, speed: mpf, length: mpf) -> Parts:
    """Q'' = -q hits the stop, loses its velocity and starts from rest."""
    time = mp.asin(clearance / speed)
    return [[time], [clearance * mp.cos(length - time)], [-clearance * mp.sin(length - time)]]


@case("e = 1e-12")
def nearly_plastic() -> Iterator[Finding]:
    body = Motion(v=2.0, length=1e4)
    expected = truth(after_first, 1.0, 1e-12, body.v, body.length)
    for method in body.methods:
        found = run(body, [Side(1.0, 1e-12)], method, size=1e-12)
        yield fact("stops hit", method, found.stops, [0])
        values = [found.after, [found.q], [found.v]]
        yield measured("speed after, and q, v at t = 1e4", method, values, expected, rule_of(method))

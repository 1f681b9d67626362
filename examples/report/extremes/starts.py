"""Where a motion starts and where its stop stands: clearances of both signs and none, contact, penetration, touch."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, known, truth
from report.extremes.finding import Finding, fact, measured, refused, stepped
from report.extremes.motion import EVERY, PENDULUM, RTOL, Motion, Side, impacts, rule_of, run
from report.extremes.registry import case


def half_periods(count: int) -> Callable[..., Parts]:
    """Impacts on a stop at the equilibrium of a damped oscillator: every half period, speeds falling in ratio."""

    def function(damping: mpf, stiffness: mpf, restitution: mpf, q: mpf) -> Parts:
        rate = mp.sqrt(stiffness - damping**2 / 4)
        times = [mp.atan2(rate, -damping / 2) / rate]
        first = q * stiffness / rate * mp.exp(-damping / 2 * times[0]) * mp.sin(rate * times[0])
        speeds = [first]
        for _ in range(count - 1):
            times.append(times[-1] + mp.pi / rate)
            speeds.append(speeds[-1] * restitution * mp.exp(-damping / 2 * mp.pi / rate))
        return [times, speeds]

    return function


@case("clearance 0")
def middle() -> Iterator[Finding]:
    for damping, restitution, count in ((0.0, 1.0, 12), (0.1, 0.8, 8)):
        expected = truth(half_periods(count), damping, 1.0, restitution, 1.0)
        motion = Motion(damping, 1.0, q=1.0, length=float(expected.parts[0][-1]) + 1.0)
        name = f"a stop at the equilibrium, damping {damping:g}, e = {restitution:g}"
        yield from impacts(name, motion, [Side(0.0, restitution, "lower")], expected, [0] * count)


def preloaded(count: int) -> Callable[..., Parts]:
    """Q'' = -q against a stop on the far side of its equilibrium: a flight that leaves at v returns at v after 2 atan(v/c)."""

    def function(clearance: mpf, restitution: mpf, speed: mpf) -> Parts:
        times, speeds = [2 * mp.atan(-speed / clearance)], [speed]
        for _ in range(count - 1):
            speeds.append(speeds[-1] * restitution)
            times.append(times[-1] + 2 * mp.atan(-speeds[-1] / clearance))
        return [times, speeds]

    return function


def rest(clearance: mpf, restitution: mpf, speed: mpf) -> Parts:
    """When it comes to rest, to fifty digits, and where."""
    count = 2 + int(mp.log(mpf(10) ** -55) / mp.log(restitution))
    return [[preloaded(count)(clearance, restitution, speed)[0][-1]], [clearance]]


@case("negative clearance (preloaded stop)")
def negative() -> Iterator[Finding]:
    motion = Motion(0.0, 1.0, q=-0.5, v=-0.3, length=1e3)
    for restitution, count in ((0.9, 40), (0.5, 8), (0.05, 2)):
        sides = [Side(-0.5, restitution)]
        expected = truth(preloaded(count), -0.5, restitution, 0.3)
        end = truth(rest, -0.5, restitution, 0.3)
        for method in motion.methods:
            found = run(motion, sides, method, rtol=RTOL)
            values = [found.times[:count], found.before[:count]]
            name = f"e = {restitution:g}: times and speeds of the first {count} impacts"
            yield measured(name, method, values, expected, rule_of(method))
            last = found.trajectory.segments[-1]
            yield fact(f"e = {restitution:g}: at the end", method, (str(last["kind"]), float(last["end"])), ("stick", 1e3))
            values = [[last["start"]], [found.q]]
            yield measured(f"e = {restitution:g}: time of rest, q for ever", method, values, end, stepped(RTOL))


@case("start in contact")
def touching() -> Iterator[Finding]:
    """Approaching: struck at once. Leaving: free. At rest: it stays."""
    for name, v, count in (("approaching", 1.0, 1), ("leaving", -1.0, 0), ("at rest", 0.0, 0)):
        expected = truth(lambda q, v, e: [[q - (e * v if v > 0 else -v)], [min(-e * v, v)]], 0.7, v, 0.5)
        motion = Motion(q=0.7, v=v, length=1.0)
        for method in motion.methods:
            found = run(motion, [Side(0.7, 0.5)], method)
            yield fact(f"{name}: times of impacts", method, found.times.tolist(), [0.0] * count)
            yield measured(f"{name}: q, v at t = 1", method, [found.q, found.v], expected, rule_of(method))


@case("start in penetration")
def inside() -> Iterator[Finding]:
    for depth in (1e-6, 0.8):
        for method in EVERY:
            motion, sides = Motion(q=0.7, length=1.0), [Side(0.7 - depth, 0.5)]
            yield refused(f"by {depth:g}, {method}", lambda m=motion, s=sides, a=method: run(m, s, a), "q0", "margin")


def touches(stiffness: mpf, q: mpf) -> Parts:
    """Times of the later touches, and the state after four and a half periods."""
    period = 2 * mp.pi / mp.sqrt(stiffness)
    return [[k * period for k in range(1, 5)], [-q]]


@case("start exactly grazing")
def grazing() -> Iterator[Finding]:
    """An oscillator at rest on its stop, pulled away: every period it is back at a touch, or to the error of its steps."""
    motion = Motion(0.0, 1.0, q=1.0, length=float(9 * mp.pi))
    expected = truth(touches, 1.0, 1.0)
    for method in motion.methods:
        found = run(motion, [Side(1.0, 0.5)], method)
        if method == "exact":
            yield fact("impacts", method, len(found.times), 0)
            later = [t for t in found.trajectory.grazes["time"] if t > 1]
            yield measured("times of touches, q after 4.5 periods", method, [later, [found.q]], expected, rule_of(method))
        else:
            deepest = max((speed**2 / 2 for speed in found.before), default=0.0)
            name = "how deep the fastest impact passes the stop, q after 4.5 periods"
            yield measured(name, method, [[deepest], [found.q]], known([0], [-1]), rule_of(method))


@case("equilibrium exactly on a wall with no force")
def balanced() -> Iterator[Finding]:
    motion = Motion(0.1, 1.0, length=1e3)
    for method in motion.methods:
        found = run(motion, [Side(0.0, 0.5)], method)
        yield fact("impacts", method, len(found.times), 0)
        yield measured("q, v at t = 1e3", method, [found.q, found.v], known([0], [0]), rule_of(method))


@case("equilibrium exactly on a wall with no force")
def hanging() -> Iterator[Finding]:
    """A double pendulum that hangs along a vertical wall."""
    scene = vi.Scene(vi.DoublePendulum(1, 1, (0.1, 0.1)), None, vi.Wall(1, 0, 0.5))
    for method in PENDULUM:
        found = vi.simulate(scene, [0, 0], [0, 0], (0, 1e3), method=method)
        yield measured("a double pendulum along a wall: q, v", method, found.final, known([0, 0], [0, 0]), rule_of(method))

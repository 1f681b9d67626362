"""Several stops: all but together, twice the same, without room, more than there are coordinates."""

from __future__ import annotations

from collections.abc import Iterator

from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.bodies import MASS, final, flown, simulated
from report.extremes.condition import Parts, Truth, known, truth
from report.extremes.finding import Finding, fact, measured, stepped
from report.extremes.motion import ATOL, EVERY, LINEAR, Motion, Side, rule_of, run, tolerance, walls
from report.extremes.registry import case
from report.extremes.rows import NEARLY_TOGETHER

END = 1.5
E0, E1 = 0.5, 0.8


def coupled(second: mpf, e0: mpf, e1: mpf, end: mpf) -> Parts:
    """Two coupled bodies at unit speed towards stops at 1 and at ``second``."""
    inverse = mp.matrix(MASS) ** -1
    return flown(inverse, [mpf(0)] * 2, [mpf(1)] * 2, [mpf(1), second], [e0, e1], end)


def apart(second: mpf, e0: mpf, e1: mpf, end: mpf) -> Parts:
    """The same, not coupled."""
    return flown(mp.eye(2), [mpf(0)] * 2, [mpf(1)] * 2, [mpf(1), second], [e0, e1], end)


def together(e0: mpf, e1: mpf, end: mpf) -> Parts:
    """Both stops at one instant: each leaves at its own restitution times the approach."""
    return [[1 - e0 * (end - 1), 1 - e1 * (end - 1)], [-e0, -e1]]


@case(NEARLY_TOGETHER)
def uncoupled() -> Iterator[Finding]:
    for delta in (1e-12, -1e-12):
        scene = vi.Scene(vi.LinearSystem([1, 1], [0, 0], [0, 0]), None, [vi.Stop(0, 1, E0), vi.Stop(1, 1 + delta, E1)])
        expected = truth(apart, 1 + delta, E0, E1, END)
        for method in LINEAR:
            rtol = tolerance(method)
            found = vi.simulate(scene, [0, 0], [1, 1], (0, END), method=method, rtol=rtol, atol=ATOL * rtol)
            yield fact(f"uncoupled, {delta:+g}: order", method, found.impacts["stop"].tolist(), [0, 1] if delta > 0 else [1, 0])
            yield measured(f"uncoupled, {delta:+g}: q, v", method, found.final, expected, rule_of(method))


def outcome(delta: float) -> Truth:
    """What follows where the second stop stands further by delta."""
    return truth(coupled, 1 + delta, E0, E1, END) if delta else truth(together, E0, E1, END)


def coupled_stops(delta: float) -> list[vi.Stop]:
    """Stops of the two coupled bodies."""
    return [vi.Stop(0, 1, E0), vi.Stop(1, 1 + delta, E1)]


@case(NEARLY_TOGETHER)
def inertia() -> Iterator[Finding]:
    for delta in (1e-12, 0.0, -1e-12):
        for method in EVERY:
            found = simulated(coupled_stops(delta), [0, 0], [1, 1], END, method)
            name = f"coupled by inertia, {delta:+g}: q, v"
            yield measured(name, method, final(found, method), outcome(delta), rule_of(method))


@case(NEARLY_TOGETHER)
def behind() -> Iterator[Finding]:
    """Two stops of one coordinate: the nearer is hit, the other never."""
    body = Motion(v=1.0, length=END)
    for method in body.methods:
        found = run(body, [Side(1 + 1e-12, 0.9), Side(1.0, 0.5)], method)
        yield fact("one behind the other: stops hit", method, found.stops, [1])
        yield measured("one behind the other: q, v", method, [found.q, found.v], known([0.75], [-0.5]), rule_of(method))


@case("the same stop given twice")
def twice() -> Iterator[Finding]:
    body = Motion(v=2.0, length=1.0)
    for restitution in (0.0, 0.6, 1.0):
        expected = truth(lambda v, e: [[(1 + e) * v], [1 - e * v * (1 - 1 / v)], [-e * v]], 2.0, restitution)
        for method in body.methods:
            found = run(body, [Side(1.0, restitution)] * 2, method)
            values = [[found.impulses.sum()], [found.q], [found.v]]
            yield measured(f"e = {restitution:g}: sum of impulses, q, v", method, values, expected, rule_of(method))


@case("a stop both sides at once with no room (jam)")
def jam() -> Iterator[Finding]:
    """The one place there is, is kept, and the run ends: at rest, or told that the contact is not resolved."""
    for name, motion in {
        "at rest": Motion(length=10.0),
        "pushed at speed 1": Motion(v=1.0, length=10.0),
        "driven": Motion(0.1, 1.0, force=1.0, length=10.0),
    }.items():
        for method in motion.methods:
            found = run(motion, walls(0.0, 0.5), method)
            is_told = found.trajectory.status in ("finished", "unresolved_contact")
            yield fact(f"{name}: ends ({found.trajectory.status})", method, is_told, True)
            # Impacts without end are completed to the tolerance.
            rule = stepped(tolerance(method))
            yield measured(f"{name}: q, v", method, [found.q, found.v], known([0], [0]), rule)


@case("three stops on two coordinates (dependent normals)")
def dependent() -> Iterator[Finding]:
    """Links that lean into a corner, a third stop through its edge, come to rest there."""
    stops = [vi.Stop(i, -0.2, 0.3, side="lower") for i in (0, 1)] + [vi.Stop([1, 1], -0.4, 0.3, side="lower")]
    for method in EVERY:
        found = simulated(stops, [0.3, 0.4], [0, 0], 60.0, method, gravity=1.0, damping=0.4)
        yield fact("status", method, found.status, "finished")
        rule = stepped(tolerance(method))
        yield measured("q, v at rest", method, final(found, method), known([0.2, 0.2], [0, 0]), rule)

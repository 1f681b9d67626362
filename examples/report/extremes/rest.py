"""Chatter and lasting contact: how motions come to rest on stops, stay and are let go."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.bodies import MASS, final, simulated
from report.extremes.condition import Parts, Truth, known, truth
from report.extremes.exponential import system_truth
from report.extremes.finding import Finding, fact, measured, stepped
from report.extremes.motion import ATOL, EVERY, LINEAR, Motion, Side, rule_of, run, tolerance
from report.extremes.registry import case
from report.extremes.starts import rest


def ball(height: mpf, restitution: mpf, gravity: mpf) -> Parts:
    """When a dropped ball comes to rest: a fall and flights of 2 e^k of it."""
    return [[mp.sqrt(2 * height / gravity) * (1 + 2 * restitution / (1 - restitution))]]


@case("bouncing ball to rest")
def dropped() -> Iterator[Finding]:
    for restitution in (0.1, 0.5, 0.9, 0.99):
        expected = truth(ball, 1.0, restitution, 1.0)
        motion = Motion(load=-1.0, q=1.0, length=1.5 * float(expected.parts[0][0]))
        ends = Truth([*expected.parts, [mpf(0)], [mpf(0)]], [*expected.conditions, 1.0, 1.0])
        for rtol in (1e-9, 1e-11, 1e-13):
            for method in motion.methods:
                found = run(motion, [Side(0.0, restitution, "lower")], method, rtol=rtol)
                values = [[found.trajectory.segments["start"][-1]], [found.q], [found.v]]
                yield measured(f"e = {restitution:g}, rtol {rtol:g}: time of rest, q, v", method, values, ends, stepped(rtol))


@case("bouncing ball to rest")
def on_a_spring() -> Iterator[Finding]:
    """The force on the stop changes along each flight: the end of the impacts is completed to the tolerance asked for."""
    motion = Motion(0.0, 1.0, q=-0.5, v=-0.3, length=10.0)
    expected = truth(rest, -0.5, 0.5, 0.3)
    for rtol in (1e-7, 1e-9, 1e-11, 1e-13):
        for method in motion.methods:
            found = run(motion, [Side(-0.5, 0.5)], method, rtol=rtol)
            values = [[found.trajectory.segments["start"][-1]], [found.q]]
            yield measured(f"pressed by a spring, rtol {rtol:g}: time of rest, q", method, values, expected, stepped(rtol))


@case("stuck for ever")
def held() -> Iterator[Finding]:
    """A body at rest on its stop under a spring; and one whose contact force 1 + cos t touches zero and does not let go."""
    pressed = Motion(0.1, 1.0, q=-0.5, length=1e6)
    for method in pressed.methods:
        found = run(pressed, [Side(-0.5, 0.3)], method)
        yield from stuck("pressed by a spring", method, found.trajectory, 1e6)
        yield measured("pressed by a spring: q, v", method, [found.q, found.v], known([-0.5], [0]), rule_of(method))
    touched = Motion(0.0, 1.0, load=1.0, force=1.0, length=1e3)
    for method in touched.methods:
        found = run(touched, [Side(0.0, 0.5)], method)
        yield from stuck("contact force 1 + cos t", method, found.trajectory, 1e3)
        yield measured("contact force 1 + cos t: q, v", method, [found.q, found.v], known([0], [0]), rule_of(method))


def stuck(name: str, method: str, found: vi.Trajectory, end: float) -> Iterator[Finding]:
    """Nothing but one lasting contact from the start to the end; whatever there is follows in time."""
    kinds = Counter(str(kind) for kind in found.segments["kind"])
    yield fact(f"{name}: segments until t = {end:g}", method, dict(kinds), {"stick": 1})
    backwards = int(np.sum(found.segments["start"][1:] < found.segments["end"][:-1]))
    yield fact(f"{name}: segments that begin before the last one ends", method, backwards, 0)


@case("stuck in several stops")
def corner() -> Iterator[Finding]:
    """Two coupled bodies thrown into a corner under a load; links that hang into one."""
    stops = [vi.Stop(0, 0.2, 0.3), vi.Stop(1, 0.3, 0.6)]
    scene = vi.Scene(vi.LinearSystem([[1, 0.2], [0.2, 1]], [0, 0], [1, 1], load=[1, 1]), None, stops)
    for method in LINEAR:
        rtol = tolerance(method)
        found = vi.simulate(scene, [0, 0.05], [0.3, 0.1], (0, 30), method=method, rtol=rtol, atol=ATOL * rtol)
        yield fact("loaded bodies: status, held at the end", method, at_end(found), ("finished", [0, 1]))
        yield measured("loaded bodies: q, v", method, found.final, known([0.2, 0.3], [0, 0]), stepped(rtol))
    stops = [vi.Stop(i, -0.2, 0.3, side="lower") for i in (0, 1)]
    for method in EVERY:
        found = simulated(stops, [0.3, 0.4], [0, 0], 60.0, method, gravity=1.0, damping=0.4)
        yield fact("links: status, held at the end", method, at_end(found), ("finished", [0, 1]))
        yield measured("links: q, v", method, final(found, method), known([0.2, 0.2], [0, 0]), stepped(tolerance(method)))


def at_end(found: vi.Trajectory) -> tuple[str, list[int]]:
    """How the run ended, and the stops in contact then."""
    return found.status, sorted({int(s["stop"]) for s in found.segments if s["kind"] == "stick" and s["end"] == found.t[-1]})


def let_go(coupling: mpf, load: mpf, distance: mpf, restitution: mpf, end: mpf) -> Parts:
    """One body is held, the other comes at unit speed to its lower stop: then both fly on parabolas."""
    inverse = mp.matrix([[1, coupling], [coupling, 1]]) ** -1
    s = end - distance
    speeds = [inverse[0, 1] * (1 + restitution) / inverse[1, 1], -1 + (1 + restitution)]
    pulls = [inverse[0, 0] * load, inverse[1, 0] * load]
    places = [mpf(0), -distance]
    positions = [x + v * s + a * s**2 / 2 for x, v, a in zip(places, speeds, pulls, strict=True)]
    return [positions, [v + a * s for v, a in zip(speeds, pulls, strict=True)]]


@case("released by another stop's impact")
def by_another() -> Iterator[Finding]:
    inputs = (0.6, 0.05, 0.3, 0.9, 1.3)
    coupling, load, distance, restitution, end = inputs
    stops = [vi.Stop(0, 0, 0), vi.Stop(1, distance, restitution, side="lower")]
    scene = vi.Scene(vi.LinearSystem([[1, coupling], [coupling, 1]], [0, 0], [0, 0], load=[load, 0]), None, stops)
    for method in LINEAR:
        rtol = tolerance(method)
        found = vi.simulate(scene, [0, 0], [0, -1], (0, end), method=method, rtol=rtol, atol=ATOL * rtol)
        segments = [(str(s["kind"]), int(s["stop"])) for s in found.segments]
        yield fact("pressed by a load: segments", method, segments, [("stick", 0), ("flight", -1)])
        yield measured("pressed by a load: q, v", method, found.final, truth(let_go, *inputs), rule_of(method))
    for method in EVERY:
        found = simulated(stops, [0, 0], [0, -1], end, method)
        expected = truth(links_let_go, distance, restitution, end)
        yield measured("links, at rest on the stop: q, v", method, final(found, method), expected, rule_of(method))


def links_let_go(distance: mpf, restitution: mpf, end: mpf) -> Parts:
    """The same of two links without forces."""
    inverse = mp.matrix(MASS) ** -1
    s = end - distance
    v = [inverse[0, 1] * (1 + restitution) / inverse[1, 1], restitution]
    return [[v[0] * s, -distance + v[1] * s], v]


@case("released with L' = 0 too")
def without_slope() -> Iterator[Finding]:
    """Contact force cos^3 t, of a force 3/4 cos t and a spring to a body that swings as cos 3 t."""
    coupling = 0.5
    stiffness = [[1, coupling], [coupling, 9]]
    scene = vi.Scene(vi.LinearSystem([1, 1], [0, 0], stiffness), vi.Harmonic([0.75, 0], 1), vi.Stop(0, 0, 0))
    later = 1.0
    end = float(mp.pi / 2) + later
    start = -1 / (4 * coupling)
    flight = end - mp.pi / 2
    expected = system_truth(
        np.eye(2), np.zeros((2, 2)), stiffness, [0, 0], [0.75, 0], 1.0, mp.pi / 2, [0, 0], [0, 3 * start], flight
    )
    for method in LINEAR:
        rtol = tolerance(method)
        found = vi.simulate(scene, [0, start], [0, 0], (0, end), method=method, rtol=rtol, atol=ATOL * rtol)
        kinds = [str(kind) for kind in found.segments["kind"]]
        yield fact("segments", method, kinds, ["stick", "flight"])
        force = [[float(mp.cos(mpf(found.segments["end"][0])) ** 3)]]
        yield measured("contact force at the release", method, force, known([0]), rule_of(method))
        yield measured("q, v after it", method, found.final, expected, rule_of(method))

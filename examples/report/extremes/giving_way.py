"""Stops that give way, at their ends: springs far stiffer or softer than the system, equal roots, preloads, touches.

Free and pressed arcs of one coordinate are closed forms; a contact begins and ends where the way into the stop is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import count as numbers

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, Truth, known, truth
from report.extremes.finding import Finding, fact, measured
from report.extremes.motion import ATOL, LINEAR, rule_of, tolerance
from report.extremes.oscillator import oscillator
from report.extremes.registry import case
from report.extremes.rows import PRELOADED, STIFF

CONTACTS = 12
CLEARANCE = 0.5


def run(system: vi.LinearSystem, stops: Sequence[vi.Stop], v: float, end: float, method: str, size: float = 1.0) -> vi.Trajectory:
    """The motion of one coordinate from its middle."""
    rtol = tolerance(method)
    return vi.simulate(vi.Scene(system, None, stops), 0.0, v, (0.0, end), method=method, rtol=rtol, atol=ATOL * rtol * size)


def elastic(n: int) -> Callable[..., Parts]:
    """Beginnings, ends and farthest places of the contacts of q'' = -q on a spring with a preload, from the middle.

    All begin and end at the speed u = sqrt(v^2 - c^2). With W^2 = 1 + k they last 2 atan(u W/(c + F0))/W, and away and back takes
    2 (pi - atan(u/c)).
    """

    def function(clearance: mpf, stiffness: mpf, preload: mpf, speed: mpf) -> Parts:
        u, w, pull = mp.sqrt(speed**2 - clearance**2), mp.sqrt(1 + stiffness), clearance + preload
        pressed, away = 2 * mp.atan(u * w / pull) / w, 2 * (mp.pi - mp.atan(u / clearance))
        starts = [mp.asin(clearance / speed) + i * (pressed + away) for i in range(n)]
        deepest = (mp.sqrt(pull**2 + (u * w) ** 2) - pull) / w**2
        return [starts, [start + pressed for start in starts], [clearance + deepest] * n]

    return function


def bouncing(stiffness: float, preload: float = 0.0, methods: Sequence[str] = LINEAR) -> Iterator[Finding]:
    """An oscillator at a spring, beside the closed form."""
    inputs = (CLEARANCE, stiffness, preload, 1.0)
    expected = truth(elastic(CONTACTS), *inputs)
    end = float(expected.parts[1][-1]) + 0.1
    name = f"an oscillator, k = {stiffness:g}" + (f", preload {preload:g}" if preload else "")
    stops = [vi.Stop(0, CLEARANCE, contact=vi.Spring(stiffness, preload=preload))]
    for method in methods:
        yield from contacts(name, run(vi.LinearSystem(1, 0, 1), stops, 1.0, end, method), expected, method)


def contacts(name: str, found: vi.Trajectory, expected: Truth, method: str) -> Iterator[Finding]:
    """Beginnings, ends and farthest places of all contacts: a place has the digits of a position, the way into a stop fewer."""
    table, clearance = found.contacts, found.scene.stops[0].clearance
    yield fact(f"{name}: status, contacts", method, (found.status, len(table)), ("finished", len(expected.parts[0])))
    values = [table["start"], table["end"], clearance + table["peak_approach"]]
    yield measured(f"{name}: starts, ends, farthest places", method, values, expected, rule_of(method))


def given_back(zeta: mpf, w: mpf, is_pulling: bool) -> tuple[mpf, mpf, mpf]:
    """Duration, share of the speed given back, and largest approach by unit speed of a free body on a spring with a dashpot."""
    ring = mp.sqrt(1 - zeta**2)
    turn = mp.pi if is_pulling else 2 * mp.acos(zeta)
    share = mp.exp(-zeta * turn / ring) if zeta != 1 else mp.exp(-2)
    duration = turn / (w * ring) if zeta != 1 else 2 / w
    deepest = mp.exp(-zeta * mp.acos(zeta) / ring) / w if zeta != 1 else mp.exp(-1) / w
    return duration, share, deepest


def between(n: int, is_pulling: bool) -> Callable[..., Parts]:
    """Beginnings, ends and farthest places of the contacts of a free body between two such stops."""

    def function(clearance: mpf, stiffness: mpf, damping: mpf, speed: mpf) -> Parts:
        w = mp.sqrt(stiffness)
        duration, share, deepest = given_back(damping / (2 * w), w, is_pulling)
        start, parts = clearance / speed, ([], [], [])
        for _ in range(n):
            for part, value in zip(parts, (start, start + duration, clearance + deepest * speed), strict=True):
                part.append(value)
            left = mpf(0) if is_pulling else damping / stiffness * share * speed  # the way to go where the force has ended
            speed *= share
            start += duration + (2 * clearance + left) / speed
        return [*parts]

    return function


def body(stiffness: float, damping: float, release: str, n: int, methods: Sequence[str]) -> Iterator[Finding]:
    """A free body between two springs with dashpots."""
    inputs = (CLEARANCE, stiffness, damping, 1.0)
    expected = truth(between(n, release == "gap"), *inputs)
    end = float(expected.parts[1][-1]) + 0.1
    law = vi.Spring(stiffness, damping, release=release)
    stops = [vi.Stop(0, CLEARANCE, contact=law), vi.Stop(0, CLEARANCE, side="lower", contact=law)]
    for method in methods:
        found = run(vi.LinearSystem(1, 0, 0), stops, 1.0, end, method)
        yield from contacts(f'a body between two, k = {stiffness:g}, release="{release}"', found, expected, method)


@case(STIFF)
def stiff() -> Iterator[Finding]:
    for stiffness in (1e4, 1e8, 1e12):
        yield from bouncing(stiffness)
        yield from body(stiffness, 0.4 * stiffness**0.5, "gap", 6, LINEAR)
        yield from body(stiffness, 0.4 * stiffness**0.5, "clipped", 6, ("exact",))


@case("a spring 1e-6 of the system's")
def soft() -> Iterator[Finding]:
    yield from bouncing(1e-6)


def visit(clearance: mpf, stiffness: mpf, damping: mpf, speed: mpf, end: mpf) -> Parts:
    """Beginning and end of the contact of q'' = -q, from the middle, with a spring and a dashpot that pulls; the state later."""
    still = (mpf(0),) * 3
    with mp.workdps(110):
        start, u = mp.asin(clearance / speed), mp.sqrt(speed**2 - clearance**2)

        def pressed(s: mpf) -> list[mpf]:
            return [p[0] for p in oscillator(damping, 1 + stiffness, stiffness * clearance, *still, clearance, u, mpf(0), s)]

        steps = (mpf(k) / 64 for k in numbers(1))
        low = next(s for s in steps if pressed(s + mpf(1) / 64)[0] <= clearance)
        lasts = mp.findroot(lambda s: pressed(s)[0] - clearance, (low, low + mpf(1) / 64), solver="anderson", tol=mpf(10) ** -90)
        free = oscillator(mpf(0), mpf(1), mpf(0), *still, *pressed(lasts), mpf(0), end - start - lasts)
    return [[+start], [+(start + lasts)], *([+x for x in part] for part in free)]


@case("critically damped while pressed")
def defective() -> Iterator[Finding]:
    for off in (0.0, 1e-12, -1e-12):
        inputs = (0.05, 3.0, 4.0 + off, 1.0, 5.0)  # q'' + damping q' + 4 q = 0.15 while pressed
        clearance, stiffness, damping, speed, end = inputs
        expected = truth(visit, *inputs)
        stops = [vi.Stop(0, clearance, contact=vi.Spring(stiffness, damping, release="gap"))]
        for method in LINEAR:
            found = run(vi.LinearSystem(1, 0, 1), stops, speed, end, method)
            values = [found.contacts["start"], found.contacts["end"], *found.final]
            name = f"an oscillator, damping 4 {off:+g}: start, end, q, v"
            yield measured(name, method, values, expected, rule_of(method))
    yield from body(4.0, 4.0, "clipped", 4, ("exact",))


@case(PRELOADED)
def preloaded() -> Iterator[Finding]:
    for stiffness, preload in ((10.0, 0.7), (1e8, 0.7), (10.0, 1e-9), (10.0, 1e6)):
        yield from bouncing(stiffness, preload, ("exact",))
    push = vi.LinearSystem(1, 0, 0, load=[0.5])
    seat = [vi.Stop(0, 0.0, contact=vi.Spring(10.0, 1.0, release="gap", preload=0.7))]
    found = run(push, seat, 0.0, 1e3, "exact")
    yield fact("under less than the preload: states", "exact", states(found), ["seated"])
    yield measured("under less than the preload: q, v", "exact", [*found.final], known([0], [0]), rule_of("exact"))
    yield from carried_off()


def carried_off() -> Iterator[Finding]:
    """A body at rest at its seat: under F cos t let go at pi/2, and pressed where F sin t passes the preload."""
    stop = vi.Stop(0, 0.0, contact=vi.Spring(10.0, preload=0.7))
    none = mpf(0)
    for name, force, phase, time, law in (
        ("let go", 0.5, 0.0, lambda force, preload: mp.pi / 2, (none, none, none)),
        ("pressed", 0.9, -np.pi / 2, lambda force, preload: mp.asin(preload / force), (none, mpf(10), mpf(-0.7))),
    ):
        end = 2.0

        def state(force: mpf, preload: mpf, end: mpf, time=time, law=law, phase=phase) -> Parts:
            t = time(force, preload)
            turn = mpf(0) if phase == 0.0 else -mp.pi / 2
            return [[t], *oscillator(*law, force, mpf(1), turn, none, none, t, end - t)]

        expected = truth(state, force, 0.7, end)
        scene = vi.Scene(vi.LinearSystem(1, 0, 0), vi.Harmonic(force, 1.0, phase), stop)
        found = vi.simulate(scene, 0.0, 0.0, (0.0, end), rtol=tolerance("exact"), atol=1e-16)
        names = ["seated", "free" if name == "let go" else "pressed"]
        yield fact(f"{name}: states", "exact", states(found), names)
        values = [[found.regimes["end"][0]], *found.final]
        yield measured(f"{name}: time, q, v", "exact", values, expected, rule_of("exact"))


def states(found: vi.Trajectory) -> list[str]:
    """States of the only stop, one after another."""
    return [str(state) for (state,) in found.regimes["state"]]


@case("a touch of 1e-12 of the amplitude")
def touch() -> Iterator[Finding]:
    for preload in (0.0, 1.0):
        clearance = 1 - 1e-12
        expected = truth(elastic(1), clearance, 4.0, preload, 1.0)
        stops = [vi.Stop(0, clearance, contact=vi.Spring(4.0, preload=preload))]
        found = run(vi.LinearSystem(1, 0, 1), stops, 1.0, 3.0, "exact")
        yield from contacts(f"k = 4, preload {preload:g}", found, expected, "exact")
    stops = [vi.Stop(0, 1 + 1e-12, contact=vi.Spring(4.0))]
    for method in LINEAR:
        found = run(vi.LinearSystem(1, 0, 1), stops, 1.0, 3.0, method)
        yield fact("a stop out of reach by as much: contacts", method, len(found.contacts), 0)
    for method in LINEAR:
        clearance = 1 - 1e-4
        expected = truth(elastic(1), clearance, 4.0, 0.0, 1.0)
        found = run(vi.LinearSystem(1, 0, 1), [vi.Stop(0, clearance, contact=vi.Spring(4.0))], 1.0, 3.0, method)
        yield from contacts("k = 4, a touch of 1e-4", found, expected, method)

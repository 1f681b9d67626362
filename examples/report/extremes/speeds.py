"""Speeds and lengths out of proportion: impacts at 1e-12, many in one step, stops closer than the motion, a million impacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from mpmath import mp, mpf

from report.extremes.condition import Parts, known, truth
from report.extremes.finding import FACTOR, ROUNDING, Finding, Rule, fact, measured
from report.extremes.motion import RTOL, Motion, impacts, rule_of, run, walls
from report.extremes.registry import LONG, SHORT, case
from report.extremes.restitution import between_walls


def between(name: str, clearance: float, restitution: float, speed: float, count: int, size: float) -> Iterator[Finding]:
    """A free body between two stops, from the middle, for some impacts and a little more."""
    expected = truth(between_walls(count), clearance, restitution, speed)
    length = float(expected.parts[0][-1]) * (1 + 1e-9)
    order = ([0, 1] * count)[:count]
    yield from impacts(name, Motion(v=speed, length=length), walls(clearance, restitution), expected, order, size=size)


@case("impact speeds 1e-12")
def gentle() -> Iterator[Finding]:
    yield from between("in a room of 1e-9", 1e-9, 0.5, 1e-12, 6, 1e-12)
    yield from wide()


def wide() -> Iterator[Finding]:
    """A crossing of 1e12 units of time: a method whose search goes through it in steps of one unit is not waited for."""
    name, count, speed = "in a room of 1", 2, 1e-12
    expected = truth(between_walls(count), 1.0, 0.5, speed)
    length = float(expected.parts[0][-1]) * (1 + 1e-9)
    motion, sides = Motion(v=speed, length=length), walls(1.0, 0.5)
    for method in motion.methods:
        few, more = (evaluations(replace(motion, length=part * length), method) for part in PARTS)
        searched = (more - few) / (PARTS[1] - PARTS[0])
        if searched > PATIENCE:
            first = PARTS[1] * length
            reason = f"not waited for: {searched:.0e} evaluations of the gap, at the rate of the first {first:.0e} of time"
            yield Finding(f"{name}: gap evaluations", method, "fact", reason, f"below {PATIENCE:.0e}", False)
            continue
        found = run(motion, sides, method, keep="impacts", size=speed)
        yield measured(f"{name}: times and speeds", method, [found.times, found.before], expected, rule_of(method))


PATIENCE = 1e9  # evaluations of a gap: minutes
PARTS = (1e-7, 1e-6)  # of the motion, between which evaluations are counted: steps that grow make a start of their own


def evaluations(motion: Motion, method: str) -> int:
    """How often the gaps are evaluated in a motion between two stops at 1."""
    return int(run(motion, walls(1.0, 0.5), method, keep="final", size=motion.v).trajectory.stats.n_gap_evaluations)


@case("speeds so high that two impacts fall in one Runge-Kutta step")
def fast() -> Iterator[Finding]:
    yield from between("a body at 1e9", 1.0, 1.0, 1e9, 500, 1.0)
    yield from crossing()


def crossings(count: int) -> Callable[..., Parts]:
    """Times at which q'' = -q, elastic, hits stops at c and -c: each crossing takes 2 asin(c/A)."""

    def function(clearance: mpf, speed: mpf) -> Parts:
        whole = 2 * mp.asin(clearance / speed)
        return [[whole * (k + mpf(1) / 2) for k in range(count)], [mp.sqrt(speed**2 - clearance**2)] * count]

    return function


def crossing() -> Iterator[Finding]:
    """An oscillator at 1e6: a step of its own would be a tenth of a unit long and hold a hundred thousand impacts."""
    count = 50
    expected = truth(crossings(count), 1.0, 1e6)
    motion = Motion(0.0, 1.0, v=1e6, length=float(count * 2e-6))
    yield from impacts("an oscillator at 1e6", motion, walls(1.0, 1.0), expected, [0, 1] * (count // 2))


@case("stop on both sides closer than the motion")
def narrow() -> Iterator[Finding]:
    yield from between("a room of 1e-9, a body at 1", 1e-9, 1.0, 1.0, 500, 1e-9)
    count = 50
    expected = truth(crossings(count), 1e-6, 1.0)
    motion = Motion(0.0, 1.0, v=1.0, length=count * 2e-6)
    name = "a room of 1e-6, an oscillator of amplitude 1"
    yield from impacts(name, motion, walls(1e-6, 1.0), expected, [0, 1] * (count // 2), size=1e-6)


def adding_up(method: str, count: int) -> Rule:
    """Of exact flights no error may add up; of steps one tolerance at each impact."""
    return ROUNDING if method == "exact" else Rule("steps, at each impact", count * RTOL / FACTOR)


def steady_row(count: int) -> Iterator[Finding]:
    """An elastic body at unit speed in a room of unit width: one impact each unit of time."""
    motion = Motion(v=1.0, length=count + 0.25)
    for method in motion.methods:
        found = run(motion, walls(0.5, 1.0), method, keep="impacts")
        yield fact(f"a body, {count} impacts: counted", method, len(found.times), count)
        values = [found.times[-1:], [found.before[-1]], [found.before.min()], [found.before.max()]]
        # t_k = (2 k + 1) c/v: condition number 2; the speed is the start's: 1.
        expected = known([count - mpf(1) / 2], [1], [1], [1], condition=2.0)
        yield measured(
            f"a body, {count} impacts: last time; last, least, largest speed", method, values, expected, adding_up(method, count)
        )


def swings(count: int) -> Iterator[Finding]:
    """An elastic oscillator at a stop at its equilibrium: one impact each half period."""
    motion = Motion(0.0, 1.0, v=-1.0, length=(count + 0.25) * np.pi)
    for method in motion.methods:
        found = run(motion, walls(0.0, 1.0)[1:], method, keep="impacts")
        yield fact(f"an oscillator, {count} impacts after the first: counted", method, len(found.times), count + 1)
        values = [found.times[-1:], [found.before.min()], [found.before.max()]]
        # t_k = k pi sqrt(m/k): condition number 1 with m and k counted.
        expected = known([count * mp.pi], [1], [1])
        yield measured(
            f"an oscillator, {count} impacts: last time; least, largest speed", method, values, expected, adding_up(method, count)
        )


@case("10^6 impacts in one run without drift", LONG)
def million() -> Iterator[Finding]:
    yield from steady_row(1_000_000)
    yield from swings(1_000_000)


@case("10^6 impacts in one run without drift", SHORT)
def ten_thousand() -> Iterator[Finding]:
    yield from steady_row(10_000)
    yield from swings(10_000)

"""Runs of scenes of any size: modes, stops, length, trajectories, links, values, cells, masses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import vibroimpact as vi
from report.cost import scenes
from report.cost.case import Run
from report.cost.scenes import IMPACT_EVERY, LOOSE, START, STEP_EVERY, pair

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def forced_modes(frequencies: Any, normal: Any, clearance: float) -> Run:
    """Modes under a force at the point that hits a stop, counted in impacts."""
    n = len(frequencies)
    system = vi.LinearSystem(np.ones(n), 0.04 * frequencies, frequencies**2)
    scene = vi.Scene(system, vi.Harmonic(0.3 * normal, 0.9), vi.Stop(normal, clearance, 0.7))
    zero = np.zeros(n)

    def run(units: int) -> int:
        done = vi.simulate(scene, zero, zero, (0.0, 1e9), keep="final", max_impacts=units)
        return int(done.stats.n_impacts)

    return run


def modes_in_a_band(n: int) -> Run:
    """Frequencies between 1 and 3, however many: the motion of the point that hits hardly depends on their number."""
    return forced_modes(np.sort(1.0 + 2.0 * (np.arange(n) * GOLDEN % 1.0)), np.ones(n) / math.sqrt(n), 0.1)


def modes_of_a_bar(n: int) -> Run:
    """Frequencies 1, 2, 3, ...: each mode more is faster than all before, and each impact excites it."""
    frequencies = np.arange(1.0, n + 1.0)
    return forced_modes(frequencies, (-1.0) ** np.arange(n) / frequencies, 0.5)


def first_held(n: int) -> Run:
    """A load presses the end of a bar on a stop: the bar's modes while it is held are made, once in each run."""
    frequencies = np.arange(1.0, n + 1.0)
    push = (-1.0) ** np.arange(n)
    system = vi.LinearSystem(np.ones(n), 0.04 * frequencies, frequencies**2, load=push)
    scene = vi.Scene(system, None, vi.Stop(push, 0.0, 0.0))
    zero = np.zeros(n)

    def run(units: int) -> int:
        for _ in range(units):
            vi.simulate(scene, zero, zero, (0.0, 1e-3), keep="final")
        return units

    return run


def far_stops(method: str, k: int) -> Run:
    """The pair with one stop that it hits and others that it never reaches."""
    far = [vi.Stop(1, 50.0 + i, 1.0) for i in range(k - 1)]
    scene = pair(stops=[*scenes.stops(1), *far])

    def run(units: int) -> int:
        span = (0.0, IMPACT_EVERY * units)
        return int(vi.simulate(scene, *START, span, method=method, rtol=LOOSE, keep="final").stats.n_impacts)

    return run


def polygon(k: int) -> Run:
    """A mass in the plane, on two springs, inside a polygon of stops: every one of them is hit."""
    angles = 2.0 * math.pi * np.arange(k) / k
    walls = [vi.Stop([math.cos(a), math.sin(a)], 0.5, 1.0) for a in angles]
    scene = vi.Scene(vi.LinearSystem([1.0, 1.0], [0.0, 0.0], [1.0, 1.7]), None, walls)

    def run(units: int) -> int:
        done = vi.simulate(scene, [0.1, 0.0], [1.0, 0.7], (0.0, 1e9), keep="final", max_impacts=units)
        return int(done.stats.n_impacts)

    return run


def whole_run(keep: str, impacts: int) -> Run:
    """Whole runs of so many impacts, the cost of each divided by their number."""
    scene = pair(stops=scenes.stops(1))

    def run(units: int) -> int:
        made = 0
        for _ in range(units):
            done = vi.simulate(scene, *START, (0.0, 1e12), keep=keep, max_impacts=impacts)
            made += int(done.stats.n_impacts)
        return made

    return run


def many(workers: int, count: int) -> Run:
    """So many trajectories of 50 impacts at once; a unit is one of them."""
    scene = pair(stops=scenes.stops(1))
    turn = np.linspace(0.0, 0.1, count)[:, None]
    start = np.zeros((count, 2)), np.array(START[1]) + turn

    def run(units: int) -> int:
        for _ in range(units):
            vi.simulate_many(scene, *start, (0.0, 50 * IMPACT_EVERY), workers=workers)
        return units * count

    return run


def chain(method: str, links: int) -> Run:
    """A hanging chain of links that swings, no wall, counted in steps."""
    each = np.full(links, 1.0 / links)
    scene = vi.Scene(vi.PendulumChain(each, each))
    start = np.full(links, -0.3), np.zeros(links)
    # The steps shorten with the links as the fastest swing does.
    pace = STEP_EVERY / links

    def run(units: int) -> int:
        done = vi.simulate(scene, *start, (0.0, pace * units), method=method, rtol=LOOSE, keep="final")
        return int(done.stats.n_steps)

    return run


#: A driven mass before a stop, at forces above its last doubling: it settles on one impact in each period.
OSCILLATOR = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))


def diagram(values: int) -> Run:
    """A bifurcation diagram of so many values; a unit is one of them."""
    axis = ("forcing_scale", np.linspace(8.0, 10.0, values))

    def run(units: int) -> int:
        for _ in range(units):
            vi.bifurcation_diagram(OSCILLATOR, axis, section="impact", transient=50, periods=20, workers=1)
        return units * values

    return run


def basin(cells: int) -> Run:
    """Basins of so many cells of known attractors; a unit is one of them."""
    scene = OSCILLATOR.replace(forcing_scale=9.0)
    attractors = vi.find_attractors(scene, [(-3.0, 1.0), (-5.0, 5.0)], seeds=20, workers=1)

    def run(units: int) -> int:
        for _ in range(units):
            vi.basins(scene, q=(-3.0, 1.0, cells // 10), v=(-5.0, 5.0, 10), attractors=attractors, workers=1)
        return units * cells

    return run


def exponents(masses: int) -> Run:
    """All exponents of a chain of masses between springs, its last one before a stop, counted in impacts."""
    stiffness = 2.0 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    last = np.eye(masses)[-1]
    system = vi.LinearSystem(np.ones(masses), 0.05 * stiffness, stiffness)
    scene = vi.Scene(system, vi.Harmonic(last, 0.9), vi.Stop(last, 0.2, 0.7))
    zero = np.zeros(masses)

    def run(units: int) -> int:
        found = vi.lyapunov_exponents(scene, zero, zero, (0.0, units * scene.period))
        return int(found.n_impacts)

    return run

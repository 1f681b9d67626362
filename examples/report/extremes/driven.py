"""What drives a scene at its extremes: a blow, a record, a swept force, a stop that shakes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, truth
from report.extremes.finding import Finding, fact, measured
from report.extremes.motion import ATOL, LINEAR, RTOL, rule_of, tolerance
from report.extremes.registry import case

STIFFNESS = 2.25


def end_of(scene: vi.Scene, span: tuple[float, float], method: str, **options: object) -> vi.Trajectory:
    """A run from rest, by a method with its tolerance."""
    rest, rtol = np.zeros(scene.n_dof), tolerance(method)
    return vi.simulate(scene, rest, rest, span, method=method, rtol=rtol, atol=ATOL * RTOL, **options)


def after_lines(end: mpf, *samples: mpf) -> Parts:
    """Position and velocity from rest of x'' + k x = s(t), straight lines through samples: a ramp for each corner."""
    half = len(samples) // 2
    t, values = samples[:half], samples[half:]
    slopes = [mpf(0), *((b - a) / (d - c) for a, b, c, d in zip(values, values[1:], t, t[1:], strict=False)), mpf(0)]
    w = mp.sqrt(mpf(STIFFNESS))
    x = v = mpf(0)
    for time, before, after in zip(t, slopes, slopes[1:], strict=False):
        since = end - time
        x += (after - before) * (since / w**2 - mp.sin(w * since) / w**3)
        v += (after - before) * (1 - mp.cos(w * since)) / w**2
    return [[x], [v]]


def by_lines(name: str, t: np.ndarray, values: np.ndarray, end: float) -> Iterator[Finding]:
    """The state at the end under a signal of straight lines that is zero at both ends, by each method."""
    scene = vi.Scene(vi.LinearSystem(1, 0, STIFFNESS), vi.Load(0, (t, values)))
    expected = truth(after_lines, end, *t, *values)
    for method in LINEAR:
        run = end_of(scene, (0.0, end), method, keep="final")
        yield measured(f"{name}: q, v at t = {end:g}", method, [run.final[0], run.final[1]], expected, rule_of(method))


@case("a blow of 1e-9 s")
def blow() -> Iterator[Finding]:
    length = 1e-9
    yield from by_lines("a triangle of unit impulse", np.array([0.0, length / 2, length]), np.array([0.0, 2 / length, 0.0]), 10.0)


@case("a record of straight lines")
def record() -> Iterator[Finding]:
    values = np.random.default_rng(3).normal(size=60)
    values[[0, -1]] = 0.0
    yield from by_lines("60 samples", np.linspace(0.0, 6.0, 60), values, 9.0)


def swept(start: mpf, rate: mpf, phase: mpf, time: mpf) -> Parts:
    """Cosine and sine of the angle of a linear sweep."""
    angle = start * time + rate * time**2 / 2 + phase
    return [[mp.cos(angle), mp.sin(angle)]]


@case("a force swept over 1e5 turns")
def sweep() -> Iterator[Finding]:
    start, rate, phase, length = 30.0, 0.1, 0.3, 3000.0
    scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, start, phase))
    ramp = vi.Ramp("frequency", 1e3, rate=rate)
    run = vi.simulate(scene, 0, 0, (0.0, length), ramp=ramp, keep="final")
    angle = float(run.phase(length))
    expected = truth(lambda time: swept(mpf(start), mpf(rate), mpf(phase), time), length)
    yield measured("cosine and sine of its angle", "taylor", [[np.cos(angle), np.sin(angle)]], expected, rule_of("exact"))


def meeting(first: float, *inputs: float) -> Parts:
    """When a body of constant speed meets a stop that shakes, nearest to a time, and how fast."""
    clearance, amplitude, w, phase, speed = (mpf(x) for x in inputs)
    gap = lambda t: clearance + amplitude * mp.cos(w * t + phase) - speed * t  # noqa: E731
    time = mp.findroot(gap, mpf(first))
    return [[time], [speed + amplitude * w * mp.sin(w * time + phase)]]


@case("a stop that shakes 1e4 times while a body comes near")
def shaking() -> Iterator[Finding]:
    inputs = clearance, amplitude, w, phase, speed = 1.0, 1e-3, 6e4, 0.7, 1.0
    stop = vi.Stop(0, clearance, 0.5, motion=vi.Harmonic([amplitude], w, phase))
    scene = vi.Scene(vi.LinearSystem(1, 0, 0), None, stop)
    # The first touch is no earlier than where the nearest wall would be met; the wall is looked at 2000 times in each shake.
    t = np.arange((clearance - amplitude) / speed, (clearance + amplitude) / speed, 2 * np.pi / w / 2000)
    first = float(t[np.flatnonzero(clearance + amplitude * np.cos(w * t + phase) - speed * t < 0.0)[0]])
    expected = truth(lambda *x: meeting(first, *x), *inputs)
    for method in LINEAR:
        options = {"method": method, "rtol": tolerance(method), "atol": ATOL * RTOL, "max_impacts": 1, "keep": "impacts"}
        run = vi.simulate(scene, [0.0], [speed], (0.0, 1.1), **options)
        yield fact("impacts", method, run.impacts.size, 1)
        yield measured(
            "first impact: time, speed", method, [run.impacts["time"], run.impacts["speed_before"]], expected, rule_of(method)
        )

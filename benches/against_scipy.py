"""Print speeds as ratios to SciPy RK45.

Run by hand, ``python benches/against_scipy.py [rounds]``, with SciPy and a release build of the package installed
(``maturin develop --release``). The contestant is what a user would write: ``solve_ivp`` with ``method="RK45"``, rtol
1e-6, a terminal event for each stop, and a restart after each impact, on the paper's third case. Every other measurement
is taken beside it, round by round in the same process, so that the machine's moods fall on both; medians are printed, and
the ratio is the median of the ratios.
"""

import sys
import time
from math import cos, sin
from statistics import median

import numpy as np
from scipy.integrate import solve_ivp

import vibroimpact as vi

ROUNDS = 15
SPAN_SCIPY = 400.0
SPAN_EXACT = 20000.0
START = (0.02, -0.1), (0.0, 0.3)
PATTERN, N_PERIODS = [1], 2


def linear_rate(scene):
    """Return the right-hand side of the small motions."""
    system, base = scene.system, scene.forcing
    inverse = np.linalg.inv(system.mass)
    stiffness, damping = inverse @ system.stiffness, inverse @ system.damping
    frequency, phase = base.frequency, base.phase
    amplitude = system.influence * base.amplitude * frequency**2

    def rate(t, x):
        q, v = x[:2], x[2:]
        return np.concatenate((v, amplitude * np.cos(frequency * t + phase) - damping @ v - stiffness @ q))

    return rate


def pendulum_rate(scene):
    """Return the right-hand side of eq. (3), its two equations solved by hand."""
    system, base = scene.system, scene.forcing
    gravity = 1 / (1 + system.mass_ratio)
    alpha = system.mass_ratio * gravity / system.length_ratio
    second = alpha / system.length_ratio
    (c00, c01), (c10, c11) = system.damping.tolist()
    amplitude, frequency, phase = base.amplitude * base.frequency**2, base.frequency, base.phase

    def rate(t, x):
        p, q, u, v = x.tolist()
        push, sine, cosine = amplitude * cos(frequency * t + phase), sin(p - q), alpha * cos(p - q)
        f = push * cos(p) - gravity * sin(p) - alpha * sine * v * v - c00 * u - c01 * v
        g = alpha * (push * cos(q) - gravity * sin(q) + sine * u * u) - c10 * u - c11 * v
        det = second - cosine * cosine
        return np.array([u, v, (second * f - cosine * g) / det, (g - cosine * f) / det])

    return rate


def scipy_flights(scene, q0, v0, span):
    """Return the number of impacts up to the end of the span, by events and restarts."""
    rate = linear_rate(scene) if isinstance(scene.system, vi.LinearSystem) else pendulum_rate(scene)

    def event(stop):
        def gap(t, x):
            return stop.clearance - x[stop.normal]

        gap.terminal, gap.direction = True, -1
        return gap

    events = [event(stop) for stop in scene.stops]
    t, x, impacts = 0.0, np.concatenate((q0, v0)), 0
    while t < span:
        flight = solve_ivp(rate, (t, span), x, method="RK45", rtol=1e-6, atol=1e-9, events=events)
        t, x = flight.t[-1], flight.y[:, -1].copy()
        for stop, times in zip(scene.stops, flight.t_events, strict=True):
            if len(times):
                x[2 + stop.normal] *= -stop.restitution
                impacts += 1
    return impacts


def microseconds(action, repeats=1):
    """Time of one action [us]."""
    start = time.perf_counter()
    for _ in range(repeats):
        action()
    return (time.perf_counter() - start) / repeats * 1e6


def stepped(scene, rtol, method):
    """Return a run in steps, as long as SciPy's."""
    return vi.simulate(scene, *START, (0.0, SPAN_SCIPY), method=method, rtol=rtol, atol=0.1 * rtol, keep="final")


def loosest(scene, error, method):
    """Return the loosest tolerance, in quarter decades, at and below which the state at the end is right to an error."""
    truth = np.concatenate(stepped(scene, 3e-14, method).final)
    rtol = 1e-13
    while np.abs(np.concatenate(stepped(scene, rtol * 10**0.25, method).final) - truth).max() <= error:
        rtol *= 10**0.25
    return rtol


def many_modes(n=10_000):
    """Return a string of n modes with three stops along it."""
    w = np.arange(1.0, n + 1)

    def shape(x):
        return np.sqrt(2.0) * np.sin(np.pi * w * x)

    stops = [vi.Stop(shape(x), 0.1, 0.8) for x in (0.2, 0.5, 0.7)]
    return vi.Scene(vi.LinearSystem(np.ones(n), 0.04 * w, w**2), vi.Harmonic(shape(0.37), 1.5), stops)


def contestants():
    """Each a name, the scene of SciPy's run, and a function that measures the time of one unit of work [us]."""
    scene, pendulums = vi.paper_scene(kind=3), vi.paper_scene(kind=3, linear=False)
    far = scene.replace(clearance=100.0)
    string = many_modes()
    n_orbits = len(vi.periodic_orbits(scene, PATTERN, N_PERIODS))

    def decided():
        for orbit in vi.periodic_orbits(scene, PATTERN, N_PERIODS):
            assert orbit.is_admissible or orbit.violation
            assert len(orbit.floquet_multipliers) == 4

    def cells(scale):
        side = 100
        x, y = ("frequency", np.linspace(1.0, 2.0, side)), ("forcing_scale", np.linspace(*scale, side))
        return microseconds(lambda: vi.existence_map(scene, PATTERN, x, y, N_PERIODS, workers=1)) / side**2

    def flights():
        n = []
        run = microseconds(lambda: n.append(vi.simulate(scene, *START, (0.0, SPAN_EXACT), keep="final")))
        return run / n[0].stats.n_impacts

    def call(system, pattern, repeats, **options):
        return lambda: microseconds(lambda: vi.periodic_orbits(system, pattern, **options), repeats)

    def steps(moved, error, method="rk45"):
        rtol = loosest(moved, error, method)
        n_impacts = stepped(moved, rtol, method).stats.n_impacts
        return lambda: microseconds(lambda: stepped(moved, rtol, method), 20) / n_impacts

    on_linear = [
        ("one orbit with admissibility and multipliers", lambda: microseconds(decided, 1000) / n_orbits),
        ("one call of periodic_orbits that finds none", call(far, PATTERN, 1000, n_periods=N_PERIODS)),
        ("one call with the phase given", call(scene, PATTERN, 1000, n_periods=N_PERIODS, phase=2.0)),
        ("one cell of an existence map, no orbit there", lambda: cells((1e-4, 1e-2))),
        ("one cell of an existence map, orbits in most", lambda: cells((0.2, 2.2))),
        ("exact flights, one impact", flights),
        ("10 000 modes, three stops at one instant", call(string, [(0, 1, 2)], 1, phase=0.7)),
        ("steps to 1e-5, one impact", steps(scene, 1e-5)),
        ("steps to 1e-9, one impact", steps(scene, 1e-9)),
    ]
    on_pendulums = [
        ("large motions, steps to 1e-5, one impact", steps(pendulums, 1e-5)),
        ("large motions, steps to 1e-9, one impact", steps(pendulums, 1e-9)),
        ("large motions, series to 1e-5, one impact", steps(pendulums, 1e-5, "taylor")),
        ("large motions, series to 1e-9, one impact", steps(pendulums, 1e-9, "taylor")),
    ]
    return [(name, rival, measure) for rival, many in ((scene, on_linear), (pendulums, on_pendulums)) for name, measure in many]


def main():
    """Measure everything and print it."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    rivals = contestants()
    times = {name: [] for name, _, _ in rivals}
    for _, _, measure in rivals:
        measure()  # warm
    for _ in range(rounds):
        for name, scene, measure in rivals:
            n = []
            span = microseconds(lambda n=n, scene=scene: n.append(scipy_flights(scene, *START, SPAN_SCIPY)))
            times[name].append((measure(), span / n[0]))
    for name, pairs in times.items():
        own, rival, ratio = (median(of) for of in (*zip(*pairs, strict=True), [p[1] / p[0] for p in pairs]))
        print(f"{name:46} {own:10.2f} us   SciPy RK45's impact {rival:6.0f} us, {ratio:8.2f} times as long")


if __name__ == "__main__":
    main()

"""Periodic orbits at their extremes: very long and short periods, families, folds, touches, repetitions, no solution."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, truth
from report.extremes.exponential import flow
from report.extremes.finding import ROUNDING, Finding, fact, measured
from report.extremes.periodic import driven_rate, driven_state, mismatch, on_the_way, one_stop, reach, recovery, state_matrix
from report.extremes.registry import case

PERIODS = {1: 3, 2: 2, 3: 2}  # of forcing, of the paper's kinds


def oscillator(damping: float, force: float, frequency: float, restitution: float, *clearances: float) -> vi.Scene:
    """A unit mass on a unit spring with an upper stop, and a lower one where a second clearance is given."""
    stops = [vi.Stop(0, c, restitution, side=side) for c, side in zip(clearances, ("upper", "lower"), strict=False)]
    return vi.Scene(vi.LinearSystem(1, damping, 1), vi.Harmonic(force, frequency), stops)


def both_orbits(name: str, n_periods: int, *inputs: float) -> Iterator[Finding]:
    """Phases and speeds of both orbits of one impact in some periods."""
    damping, force, frequency, restitution, clearance = inputs
    orbits = vi.periodic_orbits(oscillator(*inputs), [0], n_periods)
    found = sorted(orbits, key=lambda orbit: orbit.phase)
    expected = truth(one_stop(n_periods), damping, 1.0, force, frequency, restitution, clearance)
    phases, speeds = [orbit.phase for orbit in found], [orbit.v0[0] for orbit in found]
    yield measured(f"{name}: phases", "orbit", [phases], expected.part(0), ROUNDING)
    yield measured(f"{name}: velocities after the impact", "orbit", [speeds], expected.part(1), ROUNDING)
    wait = found[0].period / 4
    instants = wait * np.arange(3)
    motion = [found[0].position(instants), found[0].velocity(instants)]
    expected = truth(on_the_way(n_periods), damping, 1.0, force, frequency, restitution, clearance, wait)
    yield measured(f"{name}: q, v at the impact, after a quarter and a half of the period", "orbit", motion, expected, ROUNDING)


@case("T over 1e4 free periods")
def long() -> Iterator[Finding]:
    for zeta in (0.0, 0.01):
        yield from both_orbits(f"w = 0.9e-4, zeta = {zeta:g}", 1, 2 * zeta, 1.0, 0.9e-4, 0.7, 0.3)
        yield from both_orbits(f"15000 periods of w = 1.3, zeta = {zeta:g}", 15000, 2 * zeta, 1.0, 1.3, 0.7, 0.3)


@case("T under 1e-3 of a free period")
def short() -> Iterator[Finding]:
    for zeta in (0.0, 0.01, 10.0):
        yield from both_orbits(f"w = 2000, zeta = {zeta:g}", 1, 2 * zeta, 1.0, 2000.0, 0.7, 1e-7)


@case("orbit degenerate with e = 1 undamped (family)")
def families() -> Iterator[Finding]:
    for kind, dimension in ((1, 2), (2, 1), (3, 1)):
        scene = vi.paper_scene(kind, damping=0.0).replace(restitution=1)
        pattern, n = vi.KINDS[kind], PERIODS[kind]
        for phase in (0.0, np.pi):
            orbits = vi.periodic_orbits(scene, pattern, n, phase=phase)
            name = f"kind {kind} at phase {phase:.4g}"
            yield fact(f"{name}: verdict, dimension", "orbit", (orbits.verdict, orbits.family.dimension), ("family", dimension))
            yield image(f"{name}: basis, its own image after a period", scene, pattern[0], n, orbits.family.basis)
        verdict = vi.periodic_orbits(scene, pattern, n, phase=1.0).verdict
        yield fact(f"kind {kind} at phase 1: verdict", "orbit", verdict, "none")


def image(name: str, scene: vi.Scene, hit: int | tuple[int, ...], n_periods: int, basis: np.ndarray) -> Finding:
    """A basis of the family beside R e^(A T) times itself."""
    stops = (hit,) if isinstance(hit, int) else hit
    system = scene.system
    matrices = np.concatenate([np.ravel(m) for m in (system.mass, system.stiffness)])

    def function(*inputs: mpf) -> Parts:
        rows = [[list(inputs[k : k + 2]), list(inputs[k + 2 : k + 4])] for k in (0, 4)]
        rate = state_matrix(rows[0], [[mpf(0)] * 2] * 2, rows[1])
        moved = recovery([mpf(1) if i in stops else None for i in range(2)]) * flow(rate, 2 * mp.pi * n_periods / inputs[8])
        return [list(moved * mp.matrix(basis.tolist()))]

    return measured(name, "orbit", [basis], truth(function, *matrices, scene.forcing.frequency), ROUNDING)


FOLD = (0.2, 1.0, 2.8, 0.8)  # damping, force, frequency, restitution


@case("fold |d| = |alpha| +- 1e-12")
def fold() -> Iterator[Finding]:
    damping, force, frequency, restitution = FOLD
    largest = reach(*(mpf(x) for x in (damping, 1.0, force, frequency, restitution)))
    for factor, count in ((1 - mpf(10) ** -12, 2), (1 + mpf(10) ** -12, 0)):
        clearance = float(largest * factor)
        name = "inside" if count else "outside"
        orbits = vi.periodic_orbits(oscillator(*FOLD, clearance), [0])
        yield fact(f"{name}: number of orbits", "orbit", len(orbits), count)
        expected = truth(
            lambda c, k, f, w, e, d: [[1 - d / reach(c, k, f, w, e)]], damping, 1.0, force, frequency, restitution, clearance
        )
        yield measured(f"{name}: margin 1 - |d|/|alpha|", "orbit", [[orbits.margin]], expected, ROUNDING)
    yield from both_orbits("inside", 1, *FOLD, float(largest * (1 - mpf(10) ** -12)))


TOUCH = (0.2, 1.0, 1.7, 0.7, 0.1)  # and the clearance of the stop that is hit


def lowest(damping: mpf, stiffness: mpf, force: mpf, frequency: mpf, restitution: mpf, clearance: mpf) -> Parts:
    """Where and when the orbit of the smaller phase turns back, below."""
    start = driven_state(damping, stiffness, force, frequency, restitution, clearance)
    rate = driven_rate(damping, stiffness, force, frequency)
    time = mpf(2.27)
    for _ in range(7):  # Newton on the velocity
        now = flow(rate, time) * start
        time -= now[1] / (rate * now)[1]
    return [[time], [-(flow(rate, time) * start)[0]]]


@case("orbit that grazes a second stop")
def grazing() -> Iterator[Finding]:
    damping, *others = TOUCH
    expected = truth(lowest, damping, 1.0, *others)
    depth = float(expected.parts[1][0])
    for name, lower, outcome in (("touched", depth, (True, 1, True)), ("1e-6 out of reach", depth + 1e-6, (True, 0, False))):
        orbit = smallest_phase(lower)
        told = (orbit.is_admissible, len(orbit.grazes), orbit.floquet_multipliers is None)
        yield fact(f"{name}: admissible, touches, without multipliers", "orbit", told, outcome)
        if len(orbit.grazes):
            values = [orbit.grazes["time"], [lower - orbit.grazes["depth"][0]]]
            yield measured(f"{name}: time, reach", "orbit", values, expected, ROUNDING)
    orbit = smallest_phase(depth - 1e-6)
    yield fact("1e-6 too near: admissible, stop passed", "orbit", (orbit.is_admissible, orbit.violation.stop), (False, 1))
    values = [[orbit.violation.time], [depth - 1e-6 + orbit.violation.depth]]
    yield measured("1e-6 too near: time, reach", "orbit", values, expected, ROUNDING)


def smallest_phase(lower: float) -> vi.Orbit:
    """The orbit on the upper stop beside a lower one."""
    return min(vi.periodic_orbits(oscillator(*TOUCH, lower), [0]), key=lambda orbit: orbit.phase)


@case("orbit that is a shorter one repeated")
def repeated() -> Iterator[Finding]:
    """Two impacts in two periods: the orbit of one impact a period, gone through twice, is no answer but may be a guess."""
    scene = oscillator(*TOUCH)
    twice = vi.periodic_orbits(scene, [0, 0], 2)
    halves = [o for o in twice if abs(o.impacts["time"][1] - scene.period) < 1e-6 * scene.period]
    yield fact("repeated orbits among those of [0, 0] in two periods", "orbit", len(halves), 0)
    yield fact("said in the reason", "orbit", "gone through twice" in twice.reason, True)
    orbit = min(vi.periodic_orbits(scene, [0]), key=lambda o: o.phase)
    run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 5 * orbit.period))
    found = vi.find_orbit(orbit.scene, run, 2)
    damping, *others = TOUCH
    expected = truth(one_stop(1), damping, 1.0, *others)
    expected.parts[1] = expected.parts[1][:1]
    expected.parts[0] = [4 * mp.pi / mpf(others[1])]
    yield measured("from a guess: period, speed", "orbit", [[found.period], found.v0], expected, ROUNDING)
    # det of the flow over two periods, times e^2 for each of the two impacts.
    law = truth(lambda c, w, e: [[mp.exp(-c * 4 * mp.pi / w) * e**4]], damping, others[1], others[2])
    yield measured("from a guess: product of multipliers", "orbit", [[np.prod(found.floquet_multipliers).real]], law, ROUNDING)


@case("kind 1 with unequal clearances (none, with the mismatch)")
def unequal() -> Iterator[Finding]:
    for clearances in ([0.8, 0.5], [0.8, 0.8 + 1e-12]):
        scene = vi.paper_scene(kind=1, damping=0.05).replace(clearance=clearances)
        orbits = vi.periodic_orbits(scene, vi.KINDS[1], PERIODS[1])
        system, forcing = scene.system, scene.linearise().forcing
        force = np.real(forcing.amplitude) if isinstance(forcing, vi.Harmonic) else forces(system, forcing)
        arrays = (system.mass, system.damping, system.stiffness, force, forcing.frequency, [s.restitution for s in scene.stops])
        inputs = [float(x) for array in (*arrays, clearances) for x in np.ravel(array)]
        expected = truth(lambda *x: [[mismatch(x, 2, PERIODS[1])]], *inputs)
        yield fact(f"clearances {clearances}: verdict, orbits", "orbit", (orbits.verdict, len(orbits)), ("none", 0))
        yield measured(f"clearances {clearances}: mismatch 1 - |L^-1 d|", "orbit", [[orbits.margin]], expected, ROUNDING)


def forces(system: vi.LinearSystem, base: vi.BaseMotion) -> np.ndarray:
    """Amplitude of the force of a base motion: M r a w^2."""
    return system.mass @ system.influence * base.amplitude * base.frequency**2

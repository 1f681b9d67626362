"""Forcing at its extremes: resonance without damping, slow, fast and absent forces, starts a billion periods late."""

from __future__ import annotations

from collections.abc import Iterator

from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, Truth, truth
from report.extremes.finding import ROUNDING, Finding, fact, measured, refused
from report.extremes.motion import ATOL, RTOL, SMALL, Motion, final_states, rule_of, run, scene_of
from report.extremes.oscillator import oscillator
from report.extremes.registry import case
from report.extremes.systems import PAIR, states

START = {"q": 0.7, "v": -0.4}
OFF = 1e-12


def steady(damping: mpf, stiffness: mpf, force: mpf, frequency: mpf) -> Parts:
    """Position and velocity of the steady response at time 0."""
    response = force / (stiffness - frequency**2 + 1j * damping * frequency)
    return [[mp.re(response)], [mp.re(1j * frequency * response)]]


RANK = 1e-10  # theory: singular values below this part of the largest count as none


def steady_response(name: str, damping: float, frequency: float) -> Iterator[Finding]:
    """The orbit without impacts of a mode of unit frequency: none where its condition number is beyond the stated rank."""
    orbits = vi.periodic_orbits(vi.Scene(vi.LinearSystem(1, damping, 1), vi.Harmonic(1, frequency)), [])
    expected = truth(steady, damping, 1.0, 1.0, frequency)
    condition = max(expected.conditions)
    due = "none" if condition * RANK > 1 else "found"
    yield fact(
        f"{name}: steady response, condition number {condition:.0e} beside a rank of {1 / RANK:.0e}", "orbit", orbits.verdict, due
    )
    if orbits.verdict == "found":
        yield measured(f"{name}: steady q, v", "orbit", [orbits[0].q0, orbits[0].v0], expected, ROUNDING)


@case("w = w_j exactly, undamped")
def resonance() -> Iterator[Finding]:
    yield from final_states("grows with time", Motion(0.0, 1.0, force=1.0, frequency=1.0, length=50.0, **START))
    yield from states("one of two coupled modes", [1, 1], [0, 0], PAIR, 50.0, force=([1, -2], 1.0))
    orbits = vi.periodic_orbits(vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic(1, 1)), [])
    yield fact("a steady response", "orbit", orbits.verdict, "none")
    yield from impacts_hold_it()


def impacts_hold_it() -> Iterator[Finding]:
    """One impact a period: the free motion repeats, the force adds F pi/w to the speed, the impact takes it away."""
    force, e = 0.8, 0.7
    scene = vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic(force, 1.0), vi.Stop(0, 0.3, e))
    orbit = vi.periodic_orbits(scene, [0])[0]
    expected = truth(lambda f, e: [[e * f * mp.pi / (1 + e)], [mpf(1)]], force, e)
    values = [[-orbit.v0[0]], [float(mp.cos(mpf(orbit.phase)))]]
    yield measured("an orbit with impacts: speed after, cos(phase)", "orbit", values, expected, ROUNDING)


@case("w off w_j by 1e-12")
def nearly_resonance() -> Iterator[Finding]:
    for frequency in (1 - OFF, 1 + OFF):
        side = "below" if frequency < 1 else "above"
        motion = Motion(0.0, 1.0, force=1.0, frequency=frequency, length=50.0, **START)
        yield from final_states(side, motion)
        yield from steady_response(f"{side}, undamped", 0.0, frequency)
        yield from steady_response(f"{side}, zeta = 1e-12", 2 * OFF, frequency)


@case("forcing frequency 1e-6")
def slow() -> Iterator[Finding]:
    force = {"force": 1.0, "frequency": 1e-6, "phase": 0.3}
    yield from final_states("a mode", Motion(0.2, 1.0, length=30.0, **START, **force))
    yield from final_states("a rigid body", Motion(length=30.0, **START, **force))
    yield from final_states("a rigid body for long", Motion(length=1e7, **START, **force), small=2.0**-80)


@case("forcing frequency 1e6")
def fast() -> Iterator[Finding]:
    force = {"force": 1e6, "frequency": 1e6, "phase": 0.3}
    yield from final_states("a mode", Motion(0.2, 1.0, length=0.002, **START, **force))
    yield from final_states("a rigid body", Motion(length=0.002, **START, **force))
    yield exact_alone("a mode for 5e6 periods of the force", Motion(0.2, 1.0, length=30.0, **START, **force))


def exact_alone(name: str, motion: Motion) -> Finding:
    """What would take steps minutes."""
    return next(final_states(name, motion))


@case("zero forcing amplitude")
def absent() -> Iterator[Finding]:
    """A force that is none: the free motion, whatever its frequency."""
    motion = Motion(0.2, 1.0, length=20.0, **START)
    for method in motion.methods:
        unit = SMALL if method == "taylor" else 1.0
        none = vi.BaseMotion(0, 1.7) if method == "taylor" else vi.Harmonic(0, 1.7)
        scene = scene_of(motion, (), method, unit).replace(forcing=none)
        options = {"rtol": RTOL, "atol": ATOL * RTOL * unit, "keep": "final"}
        end = vi.simulate(scene, unit * motion.q, unit * motion.v, (0, motion.length), method=method, **options).final
        values = [x / unit for x in end]
        yield measured("q, v at t = 20 beside the free motion", method, values, motion.truth, rule_of(method))


@case("zero frequency")
def constant() -> Iterator[Finding]:
    """A constant force is a load; a harmonic one needs a frequency, which may be as small as doubles go."""
    for name, call in {"Harmonic": lambda: vi.Harmonic(1, 0), "BaseMotion": lambda: vi.BaseMotion(1, 0)}.items():
        yield refused(f"{name} of frequency 0", call, "frequency", "greater than zero")
    yield from final_states("a load instead", Motion(0.2, 1.0, load=0.8, length=20.0, **START))
    motion = Motion(0.2, 1.0, force=0.8, frequency=1e-300, length=20.0, **START)
    for finding in final_states("frequency 1e-300", motion):
        if finding.method != "taylor":  # the base would have to move by 1e600
            yield finding


@case("a start at t = 1e9 periods")
def late() -> Iterator[Finding]:
    """Start and frequency are exact doubles: the phase at the start, 1e10 times as sensitive to them, is not to lose a digit."""
    w = 1.7
    for periods in (1e9, -1e9, 12345678.9):
        start = periods * float(2 * mp.pi / mpf(w))
        length = (start + 8.0) - start
        motion = Motion(0.02, 1.0, force=0.8, frequency=w, phase=0.3, start=start, length=length, **START)
        whole, expected = motion.truth, fixed_start(motion)
        name = f"after {periods:.10g} periods: q, v ({max(whole.conditions):.0e} with start and frequency counted)"
        for method in motion.methods:
            end = run(motion, (), method, keep="final")
            yield measured(name, method, [end.q, end.v], expected, rule_of(method))


def fixed_start(motion: Motion) -> Truth:
    """The state at the end, conditioned for all inputs but the frequency and the start."""

    def function(damping: mpf, stiffness: mpf, force: mpf, phase: mpf, q: mpf, v: mpf, length: mpf) -> Parts:
        w, start = mpf(motion.frequency), mpf(motion.start)
        return oscillator(damping, stiffness, mpf(0), force, w, phase, q, v, start, length)

    m = motion
    return truth(function, m.damping, m.stiffness, m.force, m.phase, m.q, m.v, m.length)

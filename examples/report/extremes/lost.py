"""What is lost where the problem is ill conditioned: series of ever worse cases, and what they measure in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.bodies import final, simulated
from report.extremes.condition import Parts, Truth, truth
from report.extremes.finding import EPSILON, FACTOR, ROUNDING, Finding, measured
from report.extremes.motion import Motion, Side, rule_of, run
from report.extremes.registry import DIGITS
from report.extremes.several import END, METHODS, coupled_stops, outcome
from report.extremes.steady import steady
from report.page import table


@dataclass(frozen=True)
class Series:
    """A titled table and the words that its numbers choose."""

    title: str
    words: str
    header: tuple[str, ...]
    rows: list[tuple[str, ...]]

    @property
    def text(self) -> str:
        """As a part of the page."""
        return f"### {self.title}\n\n{self.words}\n\n{table(self.header, self.rows)}"


def short(number: float) -> str:
    """Two digits."""
    return f"{float(number):.1e}"


def explained(findings: Sequence[Finding]) -> str:
    """Whether the condition number explains the errors of exact answers."""
    worst = max(findings, key=lambda f: f.error / f.condition)
    times = worst.error / (worst.condition * EPSILON)
    largest = max(findings, key=lambda f: f.condition)
    digits = np.log10(largest.condition)
    loss = f"{digits:.0f} of 16 digits, no more than" if times <= FACTOR else "more than"
    return (
        f"At the worst condition number here, {short(largest.condition)}, the error is {short(largest.error)}; over all rows it is "
        f"at most {times:.2g} times condition number times {EPSILON:.1e}: what is lost is {loss} the problem itself loses when its "
        "data are rounded."
    )


def first_impact(clearance: mpf, speed: mpf) -> Parts:
    """Q = v sin t against a stop: time and speed of the first impact."""
    return [[mp.asin(clearance / speed)], [mp.sqrt(speed**2 - clearance**2)]]


def grazing() -> Series:
    """First impacts of an oscillator of unit amplitude, ever closer to a touch."""
    rows, exact = [], []
    for overshoot in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10):
        clearance = 1 - overshoot
        expected = truth(first_impact, clearance, 1.0)
        motion = Motion(0.0, 1.0, v=1.0, length=2.0)
        errors = []
        for method in motion.methods:
            found = run(motion, [Side(clearance, 0.5)], method)
            values = [found.times[:1], found.before[:1]]
            parts = [
                measured("", method, [v], Truth([p], [c]), rule_of(method))
                for v, p, c in zip(values, *vars(expected).values(), strict=True)
            ]
            exact += parts if method == "exact" else []
            errors += [short(each.error) if each.error is not None else "missed" for each in parts]
        rows.append((f"{overshoot:g}", *map(short, expected.conditions), *errors))
    words = (
        "An oscillator of amplitude 1 meets a stop at 1 - overshoot. The time of the impact is a root that becomes double, the speed "
        f"falls as its square root. {explained(exact)} The speed is measured relative to itself."
    )
    header = (
        "overshoot",
        "condition of the time",
        "of the speed",
        *(f"{what}, {m}" for m in METHODS for what in ("time", "speed")),
    )
    return Series("Grazing", words, header, rows)


def resonance() -> Series:
    """The steady response of an undamped mode, ever closer to resonance, beside the motion over a finite time."""
    rows, steadies, motions = [], [], []
    for off in (1e-2, 1e-4, 1e-6, 1e-8, 1e-9):
        frequency = 1 + off
        expected = truth(steady, 0.0, 1.0, 1.0, frequency)
        expected = Truth(expected.parts[:1], expected.conditions[:1])
        orbits = vi.periodic_orbits(vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic(1, frequency)), [])
        steadies.append(measured("", "orbit", [orbits[0].q0], expected, ROUNDING))
        motion = Motion(0.0, 1.0, force=1.0, frequency=frequency, q=0.7, v=-0.4, length=50.0)
        end = run(motion, (), "exact", keep="final")
        motions.append(measured("", "exact", [end.q, end.v], motion.truth, ROUNDING))
        numbers = [short(x) for f in (steadies[-1], motions[-1]) for x in (f.condition, f.error)]
        rows.append((f"{off:g}", f"{float(expected.parts[0][0]):.3g}", *numbers))
    words = (
        f"The steady response F/(k - m w^2) of an undamped mode is a difference in the denominator. {explained(steadies)} The motion "
        f"from a given state over a given time has condition numbers up to {short(max(f.condition for f in motions))} at every distance, "
        f"and errors up to {short(max(f.error for f in motions))}: resonance spoils the steady response, not the motion."
    )
    header = ("w - 1", "steady q", "condition", "error", "condition of the motion", "error of the motion")
    return Series("Resonance without damping", words, header, rows)


def coincidence() -> Series:
    """Two coupled bodies that meet their stops all but together."""
    rows, states, errors = [], [], []
    for delta in (1e-3, 1e-6, 1e-9, 1e-12, 0.0, -1e-12, -1e-9, -1e-6, -1e-3):
        expected = outcome(delta)
        states.append([float(x) for part in expected.parts for x in part])
        found = [
            measured("", m, final(simulated(coupled_stops(delta), [0, 0], [1, 1], END, m), m), expected, rule_of(m))
            for m in METHODS
        ]
        errors.append(found[0].error)
        rows.append(
            (f"{delta:g}", short(max(expected.conditions)), *(f"{x:.6f}" for x in states[-1]), *(short(f.error) for f in found))
        )
    first, middle, last = (np.array(states[i]) for i in (3, 4, 5))
    jump = min(np.abs(first - middle).max(), np.abs(last - middle).max(), np.abs(first - last).max())
    words = (
        "Two bodies coupled by inertia move towards a stop each, the second further by delta. Each outcome by itself is well "
        f"conditioned, and exact flights have it to {short(max(errors))}; but between delta = 1e-12, 0 and -1e-12 the states after the "
        f"impacts are at least {jump:.3f} apart. The order of the impacts decides, and where rounding decides the order no digit of the "
        "outcome is left: that is a property of Newton's law with coupled stops, and why such orbits have no multipliers."
    )
    header = ("delta", "condition", "q1", "q2", "v1", "v2", *(f"error, {m}" for m in METHODS))
    return Series("Coincident impacts of coupled stops", words, header, rows)


def all_series() -> list[Series]:
    """The three kinds of ill-conditioned problems."""
    with mp.workdps(DIGITS):
        return [grazing(), resonance(), coincidence()]

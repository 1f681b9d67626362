"""What is lost where the problem is ill conditioned: series of ever worse cases, and what they measure in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.bodies import final, simulated
from report.extremes.condition import Parts, truth
from report.extremes.finding import EPSILON, FACTOR, ROUNDING, Finding, measured, short
from report.extremes.motion import EVERY, Motion, Run, Side, rule_of, run
from report.extremes.orbits import FOLD, oscillator
from report.extremes.periodic import one_stop, reach
from report.extremes.registry import DIGITS
from report.extremes.several import END, coupled_stops, outcome
from report.extremes.steady import RANK, steady
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


def explained(findings: Sequence[Finding]) -> str:
    """Whether the condition number explains the errors of answers in closed form."""
    times = max(f.error / (f.condition * EPSILON) for f in findings)
    hardest = max(findings, key=lambda f: f.condition)
    digits = f"{np.log10(hardest.condition):.0f} of 16 digits"
    loss = f"{digits}, no more than" if times <= FACTOR else f"more than the {digits} that"
    return (
        f"At the worst condition number here, {short(hardest.condition)}, the error is {short(hardest.error)}; over all rows it "
        f"is at most {times:.2g} times condition number times {EPSILON:.1e}: what is lost is {loss} the problem itself loses "
        "when its data are rounded."
    )


def first_impact(clearance: mpf, speed: mpf) -> Parts:
    """Of q = v sin t against a stop: time and speed of the first impact."""
    return [[mp.asin(clearance / speed)], [mp.sqrt(speed**2 - clearance**2)]]


def grazing() -> Series:
    """First impacts of an oscillator of unit amplitude, ever closer to a touch."""
    motion = Motion(0.0, 1.0, v=1.0, length=2.0)
    rows, exact = [], []
    for overshoot in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10):
        clearance = 1 - overshoot
        expected = truth(first_impact, clearance, 1.0)
        cells = []
        for method in motion.methods:
            found = run(motion, [Side(clearance, 0.5)], method)
            if not len(found.times):
                cells += [unmet(found)] * 2
                continue
            values = found.times[:1], found.before[:1]
            each = [measured("", method, [x], expected.part(i), rule_of(method)) for i, x in enumerate(values)]
            exact += each if method == "exact" else []
            cells += [short(finding.error) for finding in each]
        rows.append((f"{overshoot:g}", *map(short, expected.conditions), *cells))
    words = (
        "An oscillator of amplitude 1 meets a stop at 1 - overshoot. The time of the impact is a root that becomes double, the "
        f"speed falls as its square root; the speed is measured relative to itself. {explained(exact)} An overshoot within the "
        "margin of contacts, 10 (atol + rtol), is a touch and no impact."
    )
    columns = (f"{what}, {method}" for method in motion.methods for what in ("time", "speed"))
    return Series("Grazing", words, ("overshoot", "condition of the time", "of the speed", *columns), rows)


def unmet(found: Run) -> str:
    """What a run without impacts recorded."""
    return "a touch" if len(found.trajectory.grazes) else "missed"


def resonance() -> Series:
    """The steady response of an undamped mode, ever closer to resonance, beside the motion over a finite time."""
    rows, steadies, motions = [], [], []
    for off in (1e-2, 1e-4, 1e-6, 1e-8, 1e-9):
        frequency = 1 + off
        expected = truth(steady, 0.0, 1.0, 1.0, frequency).part(0)
        orbits = vi.periodic_orbits(vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic(1, frequency)), [])
        steadies.append(measured("", "orbit", [orbits[0].q0], expected, ROUNDING))
        motion = Motion(0.0, 1.0, force=1.0, frequency=frequency, q=0.7, v=-0.4, length=50.0)
        end = run(motion, (), "exact", keep="final")
        motions.append(measured("", "exact", [end.q, end.v], motion.truth, ROUNDING))
        numbers = [short(x) for f in (steadies[-1], motions[-1]) for x in (f.condition, f.error)]
        rows.append((f"{off:g}", f"{float(expected.parts[0][0]):.3g}", *numbers))
    condition, error = max(f.condition for f in motions), max(f.error for f in motions)
    words = (
        f"The steady response F/(k - m w^2) of an undamped mode has a difference in the denominator. {explained(steadies)} "
        f"Where the condition number passes {1 / RANK:.0e} the response counts as none. The motion from a given state over a "
        f"given time has condition numbers up to {short(condition)} at every distance, and errors up to {short(error)}: "
        "resonance spoils the steady response, not the motion."
    )
    header = ("w - 1", "steady q", "condition", "error", "condition of the motion", "error of the motion")
    return Series("Resonance without damping", words, header, rows)


def coincidence() -> Series:
    """Two coupled bodies that meet their stops all but together."""
    rows, states, errors, conditions = [], {}, [], []
    for delta in (1e-3, 1e-6, 1e-9, 1e-12, 0.0, -1e-12, -1e-9, -1e-6, -1e-3):
        expected = outcome(delta)
        states[delta] = np.array([float(x) for part in expected.parts for x in part])
        ends = {m: final(simulated(coupled_stops(delta), [0, 0], [1, 1], END, m), m) for m in EVERY}
        found = [measured("", m, end, expected, rule_of(m)).error for m, end in ends.items()]
        errors.append(found[0])
        conditions.append(max(expected.conditions))
        rows.append((f"{delta:g}", f"{conditions[-1]:.1f}", *(f"{x:.6f}" for x in states[delta]), *map(short, found)))
    near = [states[delta] for delta in (1e-12, 0.0, -1e-12)]
    jump = min(np.abs(near[i] - near[j]).max() for i, j in ((0, 1), (1, 2), (0, 2)))
    words = (
        "Two bodies coupled by inertia move towards a stop each, the second further by delta. Each outcome by itself has a "
        f"condition number of at most {max(conditions):.1f}, and exact flights have it to {short(max(errors))}; but between "
        f"delta = 1e-12, 0 and -1e-12 the states after the impacts are at least {jump:.3f} apart. The order of the impacts "
        "decides, and where rounding decides the order no digit of the outcome is left: a property of Newton's law with coupled "
        "stops, and why such orbits have no multipliers."
    )
    header = ("delta", "condition", "q1", "q2", "v1", "v2", *(f"error, {m}" for m in EVERY))
    return Series("Coincident impacts of coupled stops", words, header, rows)


def folds() -> Series:
    """Orbits of one impact a period, ever closer to the largest clearance that has one."""
    damping, force, frequency, restitution = FOLD
    largest = reach(*(mpf(x) for x in (damping, 1.0, force, frequency, restitution)))
    rows, findings = [], []
    for off in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        clearance = float(largest * (1 - mpf(off)))
        phases = sorted(orbit.phase for orbit in vi.periodic_orbits(oscillator(*FOLD, clearance), [0]))
        expected = truth(one_stop(1), damping, 1.0, force, frequency, restitution, clearance).part(0)
        findings.append(measured("", "orbit", [phases], expected, ROUNDING))
        numbers = short(findings[-1].condition), short(findings[-1].error)
        rows.append((f"{off:g}", *(f"{float(x):.9f}" for x in expected.parts[0]), *numbers))
    words = (
        "An oscillator hits a stop once a period, with the clearance a little below the largest that allows it: two orbits are "
        f"about to meet, and their phases are roots that become double. {explained(findings)}"
    )
    return Series("Folds", words, ("1 - |d|/|alpha|", "first phase", "second phase", "condition", "error"), rows)


def all_series() -> list[Series]:
    """The kinds of ill-conditioned problems."""
    with mp.workdps(DIGITS):
        return [grazing(), resonance(), coincidence(), folds()]

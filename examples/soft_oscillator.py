"""The soft impact oscillator: a driven mass before a stop that gives way, from its graze to chaos.

`x'' + 0.02 x' + x = 0.7 w^2 cos(w t)`, a base that is shaken, before a stop at x = 1.26 with a spring 29 times as stiff as the
oscillator's own and a dashpot, in parallel: the bilinear oscillator of most papers on soft impacts (`release="gap"`). Below the
frequency of the graze, which has a closed form, the mass swings freely. Behind it nothing jumps: the contact begins with a
duration like the square root of the distance, and the multipliers go on from those of the free motion by the same root, so
steeply that the motion doubles its period within 3e-4 of the frequency. What follows is chaos, which goes on a little below the
graze where the frequency comes down, a motion of period two with one contact, chaos again, and one contact in each period.

You will see, as two pictures: the bifurcation diagram above the Lyapunov exponents; and the force of the stop over how far it
is pressed, for a periodic and a chaotic motion, beside the multipliers behind the graze. Printed are the graze beside its closed
form, the orbits that are born there, and the exponents beside the sum that the dampers make.

Run: python examples/soft_oscillator.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

DAMPING, AMPLITUDE, CLEARANCE = 0.02, 0.7, 1.26
STIFFNESS, DASHPOT = 29.0, 0.3
FREQUENCIES = np.linspace(0.79, 0.93, 281)
BEHIND = 10.0 ** np.arange(-9.0, -3.0, 0.5)  # distances from the graze
CHAOS, ONCE = 0.905, 0.92  # frequencies of the loops


def oscillator(frequency: float) -> vi.Scene:
    """Return the scene at a frequency."""
    system = vi.LinearSystem(1.0, DAMPING, 1.0, influence=[1.0])
    stop = vi.Stop(0, CLEARANCE, contact=vi.Spring(STIFFNESS, DASHPOT, release="gap"))
    return vi.Scene(system, vi.BaseMotion(AMPLITUDE, frequency), stop)


def graze() -> float:
    """Return the lowest frequency at which the free motion touches the stop.

    Its amplitude is `a w^2 / sqrt((1 - w^2)^2 + (c w)^2)`: a quadratic in w^2.
    """
    d, a, c = CLEARANCE, AMPLITUDE, DAMPING
    return float(np.sqrt(min(np.roots([d**2 - a**2, d**2 * (c**2 - 2.0), d**2]))))


def born() -> list[vi.Orbit]:
    """Return the orbits with one short contact behind the graze, and check what theory says of them.

    The determinant over a period T is `exp(-(c T + c_d tau))`, tau the duration of the contact.
    """
    orbits = []
    print("behind the graze   duration   / its root   multipliers                         stable")
    for distance in BEHIND.tolist():
        found = vi.periodic_orbits(oscillator(graze() + distance), [0])
        orbit = next(each for each in found if each.is_admissible)
        lasts = (orbit.contacts["end"] - orbit.contacts["start"])[0]
        one, other = orbit.floquet_multipliers
        print(f"{distance:<16.1e}   {lasts:.6f}   {lasts / distance**0.5:.4f}       {one:.4f}, {other:.4f}   {orbit.is_stable}")
        assert abs(one * other - np.exp(-DAMPING * orbit.period - DASHPOT * lasts)) < 1e-9
        orbits.append(orbit)
    free = np.exp((-0.5 * DAMPING + 1j * np.sqrt(1.0 - 0.25 * DAMPING**2)) * 2.0 * np.pi / graze())
    assert abs(orbits[0].floquet_multipliers[0].real - free.real) < 2e-2, "multipliers go on through the touch"
    assert [orbit.is_stable for orbit in orbits] == [True] * (len(orbits) - 1) + [False], "a doubling before the last of them"
    assert not vi.periodic_orbits(oscillator(graze() - BEHIND[0]), [0])[0].is_admissible
    return orbits


def follow() -> tuple[vi.BifurcationDiagram, list[vi.LyapunovExponents]]:
    """Return the diagram and the exponents, and check where the first contact is and what the exponents add up to."""
    diagram = vi.bifurcation_diagram(oscillator(ONCE), ("frequency", FREQUENCIES), direction="both")
    is_met = diagram.n_impacts > 0
    touched, left = (diagram.parameter[is_met & (diagram.direction == way)].min() for way in (1, -1))
    print(f"\nthe stop is met from w = {touched:.4f} on, closed form {graze():.6f}; on the way down it is to w = {left:.4f}")
    assert abs(touched - graze()) <= FREQUENCIES[1] - FREQUENCIES[0]
    exponents = []
    for frequency in FREQUENCIES[::2]:
        scene = oscillator(frequency)
        span = (0.0, 2000.0 * scene.period)
        exponents.append(vi.lyapunov_exponents(scene, 0.0, 0.0, span, skip=0.25 * span[1]))
        assert abs(exponents[-1].sum - exponents[-1].expected_sum) < 1e-9
    print(f"exponents at {len(exponents)} frequencies add up to what the dampers take to 1e-9")
    chaos = vi.lyapunov_exponents(oscillator(CHAOS), 0.0, 0.0, (0.0, 10_000.0 * oscillator(CHAOS).period), skip=5000.0)
    print(f"at w = {CHAOS}: {chaos.exponents[0]:.4f} +- {chaos.errors[0]:.4f}, {chaos.verdict}")
    assert chaos.verdict == "chaotic"
    return diagram, exponents


def loop(ax: plt.Axes, frequency: float, color: str) -> None:
    """Draw the force of the stop over how far it is pressed, along contacts of a motion that has settled."""
    scene = oscillator(frequency)
    run = vi.simulate(scene, 0.0, 0.0, (0.0, 500.0 * scene.period))
    for k, contact in enumerate(run.contacts[-20:-1]):
        t = np.linspace(contact["start"], contact["end"], 80)
        pressed, speed = run.along(0, t) - CLEARANCE, run.velocity(t)[:, 0]
        force = STIFFNESS * pressed + DASHPOT * speed
        ax.plot(pressed, force, color=color, linewidth=0.9, label=None if k else f"w = {frequency:g}")
        # The area of the loop is what the dashpot takes, which the table of contacts has by itself.
        area = np.trapezoid(force * speed, t)
        assert abs(area - contact["loss"]) < 1e-3 * contact["loss"]


def draw(diagram: vi.BifurcationDiagram, exponents: list[vi.LyapunovExponents], orbits: list[vi.Orbit], output: Path) -> None:
    """Draw the diagram above the exponents, and the loops beside the multipliers."""
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7.0, 6.0), layout="constrained", height_ratios=(3, 2))
    vi.plot.bifurcation_diagram(diagram, above)
    vi.plot.lyapunov((FREQUENCIES[::2], exponents), below, name="frequency w")
    for ax in (above, below):
        ax.axvline(graze(), color="0.7", linewidth=0.8, zorder=0)
    above.set_xlabel("")
    figure.savefig(output / "soft_oscillator_diagram.png", dpi=150)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
    loop(left, CHAOS, "#b8503f")
    loop(left, ONCE, "#1d3a66")
    left.axhline(0.0, color="0.7", linewidth=0.8)
    left.set(xlabel="approach p", ylabel="force k p + c p'", title="Force of the stop")
    left.legend()
    right.semilogx(BEHIND, [orbit.floquet_multipliers.real for orbit in orbits], "o", color="#1d3a66")
    right.set(xlabel="distance from the graze", ylabel="real parts of the multipliers", title="The orbit that is born there")
    right.axhline(-1.0, color="0.7", linewidth=0.8)
    figure.savefig(output / "soft_oscillator_loops.png", dpi=150)


def main() -> None:
    """Follow, check and draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    orbits = born()
    diagram, exponents = follow()
    draw(diagram, exponents, orbits, output)
    print(f"figures in {output}/")


if __name__ == "__main__":
    main()

"""An oscillator between two stops: symmetric motions, and the pair of unsymmetric ones that they give way to.

A unit mass on a unit spring, undamped, driven by a harmonic force, hits a stop on each side once in each forcing period; the
impacts are where the energy goes. In a symmetric motion the second half of the period mirrors the first, and there is a
closed form for its speed (docs of the functions below). Over a range of frequencies, whose ends have a closed form too,
the symmetric motion is unstable and there are two others, each the mirror image of the other.

You will see the symmetric motion beside its closed form, the pair and how well one mirrors the other, and the ends of the range.
The figure has the speed at the upper stop over the frequency, with the closed form as a line, above phase portraits of
all three motions at one frequency. The pair ends at a frequency of 1.29, below which it would cross a stop.

Run: python examples/two_sided.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

FORCE = 1.0
CLEARANCE = 0.5
RESTITUTION = 0.7
FREQUENCY = 1.4  # of the portraits; the natural frequency is 1
SWEEP = (1.02, 1.7)  # of frequency, on the upper figure
BOTH = [0, 1]  # the pattern: upper stop, lower stop


def oscillator(frequency: float = FREQUENCY) -> vi.Scene:
    """The oscillator between its stops."""
    stops = [vi.Stop(0, CLEARANCE, RESTITUTION), vi.Stop(0, CLEARANCE, RESTITUTION, side="lower")]
    return vi.Scene(vi.LinearSystem([1.0], [0.0], [1.0]), vi.Harmonic([FORCE], frequency), stops)


def symmetric_speed(frequency: float) -> float:
    """Speed after each impact of the symmetric motion, by the closed form; the frequency is not 1.

    With X = F / (1 - w^2), k = tan(pi / (2 w)) (1 + e) / (2 e) and n = (1 - e) / (2 e w), the free motion over half a period,
    a rotation by pi / w, joins the impacts where `(d - k v)^2 + (n v)^2 = X^2`; v is the larger root.
    """
    e, w = RESTITUTION, frequency
    response = FORCE / (1.0 - w**2)
    k = math.tan(0.5 * math.pi / w) * (1.0 + e) / (2.0 * e)
    n = (1.0 - e) / (2.0 * e * w)
    square = k**2 + n**2
    return (CLEARANCE * k + math.sqrt((CLEARANCE * k) ** 2 - square * (CLEARANCE**2 - response**2))) / square


def symmetry_breaking(frequency: float) -> float:
    """Zero where the symmetric motion turns into the pair, positive in between.

    Half a period, mirrored, maps deviations with determinant e^2 and trace `2 e cos h - (1 + e) e a sin(h) / v`; h = pi / w,
    and a is the acceleration at the upper stop. The pair branches off where an eigenvalue is -1.
    """
    e, h, v = RESTITUTION, math.pi / frequency, symmetric_speed(frequency)
    force = (1.0 - frequency**2) * (CLEARANCE - math.tan(0.5 * h) * (1.0 + e) / (2.0 * e) * v)
    trace = 2.0 * e * math.cos(h) - (1.0 + e) * e * (force - CLEARANCE) * math.sin(h) / v
    return -(1.0 + trace + e**2)


def root(function, low: float, high: float) -> float:
    """Bisect a sign change."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if function(low) * function(middle) <= 0.0 else (middle, high)
    return 0.5 * (low + high)


def is_symmetric(orbit: vi.Orbit) -> bool:
    """Whether both stops are hit at the same speed."""
    first, second = orbit.impacts["speed_before"]
    return abs(first - second) < 1e-6


def check_orbits() -> tuple[vi.Orbit, vi.Orbit, vi.Orbit]:
    """Compare the symmetric motion with its closed form, and each of the pair with the mirror image of the other."""
    admissible = [orbit for orbit in vi.periodic_orbits(oscillator(), BOTH) if orbit.is_admissible]
    (symmetric,) = [orbit for orbit in admissible if is_symmetric(orbit)]
    first, second = [orbit for orbit in admissible if not is_symmetric(orbit)]
    speed = symmetric_speed(FREQUENCY)
    print(f"frequency {FREQUENCY}: symmetric motion, speed after impact {-symmetric.v0[0]:.12f}, closed form {speed:.12f}")
    assert abs(-symmetric.v0[0] - speed) < 1e-12
    assert (symmetric.is_stable, first.is_stable, second.is_stable) == (False, True, True)
    t = np.linspace(0.0, first.period, 101)
    mismatch = np.max(np.abs(second.position(t) + first.position(t + first.impacts["time"][1])))
    print(f"the pair: speeds {first.impacts['speed_after']} and {second.impacts['speed_after']}, mirrored to {mismatch:.1e}")
    assert mismatch < 1e-9
    return symmetric, first, second


def check_range() -> tuple[float, float]:
    """Compare the frequencies at which the symmetric motion loses and regains stability with the closed form."""
    ends = root(symmetry_breaking, 1.02, 1.2), root(symmetry_breaking, 1.45, 1.8)
    print("the symmetric motion is unstable from w = {:.9f} to {:.9f}".format(*ends))
    for end, inwards in zip(ends, (1e-6, -1e-6), strict=True):
        for frequency, is_stable in ((end - inwards, True), (end + inwards, False)):
            orbits = vi.periodic_orbits(oscillator(frequency), BOTH)
            (symmetric,) = [o for o in orbits if abs(-o.v0[0] - symmetric_speed(frequency)) < 1e-9]
            assert symmetric.is_stable is is_stable
    return ends


def diagram(ax: plt.Axes, ends: tuple[float, float]) -> None:
    """Draw the speeds at the upper stop of every admissible motion, and the closed form."""
    found = {True: [], False: []}
    for frequency in np.linspace(*SWEEP, 131):
        for orbit in vi.periodic_orbits(oscillator(frequency), BOTH):
            if orbit.is_admissible and orbit.is_stable is not None:
                found[orbit.is_stable].append((frequency, orbit.impacts["speed_after"][0]))
    line = np.linspace(*SWEEP, 400)
    ax.plot(*np.transpose(found[True]), "o", color="#1d3a66", markersize=5, label="stable")
    ax.plot(*np.transpose(found[False]), "o", color="#b8503f", markersize=5, markerfacecolor="white", label="unstable")
    ax.plot(line, [symmetric_speed(w) for w in line], color="black", linewidth=1.0, label="symmetric, closed form")
    for end in ends:
        ax.axvline(end, color="0.4", linestyle=":", label="symmetry breaking, closed form" if end == ends[0] else None)
    ax.set(
        xlabel="forcing frequency [-]",
        ylabel="speed after the upper stop [-]",
        title="Admissible motions, one impact on each stop",
    )
    ax.legend()


def figure(orbits: tuple[vi.Orbit, ...], ends: tuple[float, float]) -> plt.Figure:
    """The diagram above the portraits."""
    fig = plt.figure(figsize=(9, 8), layout="constrained")
    above, below = fig.subfigures(2, 1)
    diagram(above.subplots(), ends)
    names = ("symmetric, unstable", "first of the pair, stable", "second of the pair, stable")
    for ax, orbit, name in zip(below.subplots(1, 3, sharex=True, sharey=True), orbits, names, strict=True):
        vi.plot.phase_portrait(orbit, ax)
        ax.set(title=name, xlabel="position [-]", ylabel="velocity [-]" if orbit is orbits[0] else "")
    below.suptitle(f"forcing frequency {FREQUENCY}")
    return fig


def main() -> None:
    """Compare orbits and range with the closed form; write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    fig = figure(check_orbits(), check_range())
    fig.savefig(output / "two_sided.png", dpi=120)
    plt.close(fig)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()

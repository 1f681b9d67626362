"""A cantilever with a mass at its tip between two stops, by forty modes of a finite-element model.

An engineer's case: a steel strip, 0.5 m by 20 mm by 3 mm, of twenty Euler-Bernoulli elements carries twice its own mass at the
tip, which a harmonic force shakes and a stop on each side holds within 2 mm. The modes of the model are all that goes into the
scene: unit modal masses, 2 % damping, squared frequencies, and the mode shapes at the tip, along which force and stops act.

You will see the first frequencies beside the roots of the beam's frequency equation, and the tip's stiffness beside
3 E I / L^3; then where, over the forcing frequency and the clearance, the tip has a motion that hits each stop once in each
period, and a simulation from rest that settles on one. The figure has the map above the displacement of the tip.

Run: python examples/frame_modes.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

LENGTH, WIDTH, HEIGHT = 0.5, 0.02, 0.003  # [m]
YOUNG, DENSITY = 210e9, 7850.0  # [Pa], [kg/m^3]
BENDING = YOUNG * WIDTH * HEIGHT**3 / 12.0  # E I [N m^2]
LINE_MASS = DENSITY * WIDTH * HEIGHT  # [kg/m]
TIP_MASS = 2.0  # in masses of the beam
N_ELEMENTS = 20
DAMPING = 0.02  # of every mode
FORCE = 0.3  # at the tip [N]
CLEARANCE = 2e-3  # on each side of the tip [m]
RESTITUTION = 0.6
FREQUENCY = 4.5  # of the simulation [Hz]
N_PERIODS = 60  # of the simulation


def beam() -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of the clamped beam with its tip mass; coordinates: deflection and slope at each node."""
    h = LENGTH / N_ELEMENTS
    mass = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    size = 2 * (N_ELEMENTS + 1)
    m, k = np.zeros((size, size)), np.zeros((size, size))
    for element in range(N_ELEMENTS):
        nodes = slice(2 * element, 2 * element + 4)
        m[nodes, nodes] += LINE_MASS * h / 420.0 * (mass + np.triu(mass, 1).T)
        k[nodes, nodes] += BENDING / h**3 * (stiffness + np.triu(stiffness, 1).T)
    m[-2, -2] += TIP_MASS * LINE_MASS * LENGTH
    return m[2:, 2:], k[2:, 2:]


def frequency_equation(b: float) -> float:
    """Zero at `b = L (rho A w^2 / E I)^(1/4)` of a clamped beam with a tip mass."""
    bending = math.cos(b) * math.sinh(b) - math.sin(b) * math.cosh(b)
    return 1.0 + math.cos(b) * math.cosh(b) + TIP_MASS * b * bending


def root(function, low: float, high: float) -> float:
    """Bisect a sign change."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if function(low) * function(middle) <= 0.0 else (middle, high)
    return 0.5 * (low + high)


def check_modes(frequencies: np.ndarray, tip: np.ndarray) -> None:
    """Compare the model with the continuous beam.

    Elements with cubic shapes are too stiff, by less than `(b / n)^4 / 720` in a frequency; a static force at the tip they carry
    exactly. The rounding of a lowest mode is that of the highest squared frequency.
    """
    rounding = np.finfo(float).eps * (frequencies[-1] / frequencies[0]) ** 2
    print("frequency [Hz]   closed form")
    for j, (low, high) in enumerate([(0.5, 2.0), (3.0, 4.7), (6.0, 7.8)]):
        b = root(frequency_equation, low, high)
        exact = b**2 * math.sqrt(BENDING / (LINE_MASS * LENGTH**4))
        print(f"{frequencies[j] / (2.0 * math.pi):<14.7f}   {exact / (2.0 * math.pi):.7f}")
        assert -rounding < frequencies[j] / exact - 1.0 < (b / N_ELEMENTS) ** 4 / 720.0 + rounding
    stiffness = 1.0 / np.sum(tip**2 / frequencies**2)
    exact = 3.0 * BENDING / LENGTH**3
    print(f"stiffness of the tip {stiffness:.6f} N/m, closed form {exact:.6f} N/m")
    assert abs(stiffness - exact) < rounding * exact


def tip_between_stops(frequencies: np.ndarray, tip: np.ndarray) -> vi.Scene:
    """The scene in modal coordinates: `q` are the modes' amplitudes, `tip @ q` is the tip's deflection."""
    system = vi.LinearSystem(np.ones(len(frequencies)), 2.0 * DAMPING * frequencies, frequencies**2)
    stops = [vi.Stop(tip, CLEARANCE, RESTITUTION), vi.Stop(tip, CLEARANCE, RESTITUTION, side="lower")]
    return vi.Scene(system, vi.Harmonic(FORCE * tip, 2.0 * math.pi * FREQUENCY), stops)


def existence(scene: vi.Scene) -> vi.ExistenceMap:
    """Where the tip can hit each stop once in each period, in Hz and mm."""
    hertz, millimetres = np.linspace(2.0, 8.0, 41), np.linspace(0.25, 6.0, 24)
    frequency, clearance = ("frequency", 2.0 * math.pi * hertz), ("clearance", 1e-3 * millimetres)
    found = vi.existence_map(scene, [0, 1], frequency, clearance)
    print(found)
    return dataclasses.replace(found, x=hertz, y=millimetres, x_name="forcing frequency [Hz]", y_name="clearance [mm]")


def check_run(scene: vi.Scene) -> vi.Trajectory:
    """Simulate from rest; the last impacts have the speed of the stable orbit."""
    orbit = vi.periodic_orbits(scene, [0, 1])[0]
    assert orbit.is_stable
    assert orbit.is_admissible
    rest = np.zeros(scene.n_dof)
    run = vi.simulate(scene, rest, rest, (0.0, N_PERIODS * scene.period))
    print(run)
    speeds = run.impacts["speed_before"][-2:]
    print(f"speeds of the last two impacts {speeds} m/s, of the orbit {orbit.impacts['speed_before']} m/s")
    assert np.allclose(speeds, orbit.impacts["speed_before"], rtol=1e-6)
    return run


def figure(run: vi.Trajectory, found: vi.ExistenceMap, tip: np.ndarray) -> plt.Figure:
    """The map, and the tip's displacement in the first and last periods."""
    fig = plt.figure(figsize=(9, 8), layout="constrained")
    above, below = fig.subfigures(2, 1, height_ratios=(1.2, 1.0))
    ax = above.subplots()
    vi.plot.existence_map(found, ax)
    ax.plot(FREQUENCY, 1e3 * CLEARANCE, "o", markerfacecolor="white", markeredgecolor="black", label="simulated below")
    ax.set_title("One impact on each stop in each forcing period")
    ax.legend()
    period = run.scene.period
    for ax, start in zip(below.subplots(1, 2, sharey=True), (0.0, (N_PERIODS - 5) * period), strict=True):
        vi.plot.time_history(run, ax, along=1e3 * tip, t_span=(start, start + 5.0 * period))
        ax.set(xlabel="time [s]", ylabel="tip [mm]" if start == 0.0 else "", title="from rest" if start == 0.0 else "settled")
    return fig


def main() -> None:
    """Check the modes, draw the map and the simulation."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    mass, stiffness = beam()
    modes = vi.modes(vi.LinearSystem(mass, np.zeros_like(mass), stiffness))
    frequencies, tip = modes.natural_frequencies, modes.shapes[-2]
    check_modes(frequencies, tip)
    scene = tip_between_stops(frequencies, tip)
    run = check_run(scene)
    fig = figure(run, existence(scene), tip)
    fig.savefig(output / "frame_modes.png", dpi=120)
    plt.close(fig)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()

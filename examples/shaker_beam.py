"""A beam between two stops on a shaker: swept up and down, it jumps at different frequencies.

The strip of `measured_shaker`, 0.5 m by 20 mm by 3 mm with its first frequency at 10 Hz, is meshed by 40 elements and reduced to
six modes and the static answer to a force at the tip, with 2 % damping. The shaker moves by 1.2 mm and is swept from 5 to 50 Hz
and back, a fourth of a hertz in a second; a stop on each side holds the tip within 8 mm. Once the tip hits, the stops make the
beam stiffer: on the way up the large motion goes on beyond the free resonance until it falls, on the way down the small one
stays until the tip reaches a stop again.

You will see the swing of the tip over the frequency, up and down, with the range in which both motions are possible, and the
spectrum of its acceleration while it hits. The script compares the tip before its first impact with that of the beam without
stops, and the angle of the shaker with its sweep.

Run: python examples/shaker_beam.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse import lil_array

import vibroimpact as vi

LENGTH, WIDTH, HEIGHT = 0.5, 0.02, 0.003  # [m]
YOUNG, DENSITY = 210e9, 7850.0  # [Pa], [kg/m^3]
BENDING = YOUNG * WIDTH * HEIGHT**3 / 12.0  # E I [N m^2]
LINE_MASS = DENSITY * WIDTH * HEIGHT  # [kg/m]
N_ELEMENTS = 40
SHAKER, ROOM = 1.2e-3, 8e-3  # displacement of the shaker, and of the tip to its stops [m]
LOW, HIGH = 2 * np.pi * 5.0, 2 * np.pi * 50.0  # [rad/s]
RATE = 2 * np.pi * 0.25  # [rad/s^2]


def reduced_beam() -> tuple[vi.Reduction, int]:
    """Mesh the strip (deflection and slope at each node but the clamped one) and reduce it; the unknown of the tip."""
    h = LENGTH / N_ELEMENTS
    mass = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    whole = []
    for upper in (LINE_MASS * h / 420.0 * mass, BENDING / h**3 * stiffness):
        full = lil_array((2 * N_ELEMENTS + 2, 2 * N_ELEMENTS + 2))
        for node in range(0, 2 * N_ELEMENTS, 2):
            full[node : node + 4, node : node + 4] += upper + np.triu(upper, 1).T
        whole.append(full.tocsc()[2:, 2:])
    tip = 2 * N_ELEMENTS - 2
    sideways = np.arange(2 * N_ELEMENTS) % 2 == 0
    return vi.reduce(whole[0], 0.02, whole[1], n_modes=6, directions=[tip], influence=sideways), tip


def swept(scene: vi.Scene, first: float, last: float) -> vi.Trajectory:
    """Sweep the shaker from rest, from one frequency to another."""
    rest = np.zeros(scene.n_dof)
    start = scene.replace(frequency=first)
    return vi.simulate(start, rest, rest, (0.0, (HIGH - LOW) / RATE), ramp=vi.Ramp("frequency", last, rate=RATE))


def main() -> None:
    """Sweep up and down, draw, check."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    folder: Path = parser.parse_args().output
    beam, tip_unknown = reduced_beam()
    tip = beam.direction(tip_unknown)
    stops = [vi.Stop(tip, ROOM, 0.6, side=side) for side in ("upper", "lower")]
    scene = vi.Scene(beam.system, vi.BaseMotion(SHAKER, LOW), stops)
    up, down = swept(scene, LOW, HIGH), swept(scene, HIGH, LOW)

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    for run in (up, down):
        vi.plot.sweep(run, along=tip, ax=left, linewidth=0.8)
    left.set(xlabel="angular frequency [rad/s]", ylabel="swing of the tip [m]", xlim=(LOW, 2 * np.pi * 20))
    left.legend()
    hits = up.impacts["time"]
    middle = 0.5 * (hits[0] + hits[-1])
    vi.plot.spectrum(up, along=tip, ax=right, quantity="acceleration", t_span=(middle - 1.0, middle + 1.0), samples=1 << 14)
    right.set(xlabel="angular frequency [rad/s]", ylabel="acceleration of the tip [m/s\u00b2]", xlim=(0, 4000))
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "shaker_beam.png", dpi=120)

    falls = float(up.parameter(hits[-1])) / (2 * np.pi)
    climbs = float(down.parameter(down.impacts["time"][0])) / (2 * np.pi)
    alone = float(np.sqrt(beam.system.stiffness[0])) / (2 * np.pi)
    print(f"{len(up.impacts)} impacts on the way up, {len(down.impacts)} down; the beam alone resonates at {alone:.2f} Hz")
    print(f"the large motion falls at {falls:.2f} Hz on the way up, the small one ends at {climbs:.2f} Hz on the way down")
    assert falls > climbs + 1.0 > alone
    assert max(np.abs(run.along(tip)).max() for run in (up, down)) < ROOM * (1.0 + 1e-9)
    # Until its first impact it is the beam without stops.
    t = np.linspace(0.0, hits[0], 200)
    free = swept(scene.replace(stops=()), LOW, HIGH)
    np.testing.assert_allclose(up.along(tip, t), free.along(tip, t), atol=1e-13)
    np.testing.assert_allclose(np.cos(up.phase(t)), np.cos(LOW * t + 0.5 * RATE * t**2), atol=1e-12)
    print(f"figure in {folder}/shaker_beam.png")


if __name__ == "__main__":
    main()

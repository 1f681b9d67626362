"""A finite-element beam between two stops on a shaker whose acceleration was measured: from files to files.

The strip of `frame_modes`, 0.5 m by 20 mm by 3 mm, without a mass at its tip, is clamped to a shaker. Its mass and stiffness
come from Matrix Market files, as finite-element programs write them, the acceleration of the shaker from a table of time and
value; `write_inputs` makes both, and `run` is what an engineer writes. Twelve modes and the static answer to a force at the tip
are kept, with 2 % damping; a stop on each side holds the tip within 0.5 mm.

You will get the acceleration of the tip relative to the shaker and the forces of lasting contact as a table, the impacts with
their impulses as another, and the spectrum of the tip as a figure. The script compares the first frequency with the beam's,
and the tip with its stops.

Run: python examples/measured_shaker.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from scipy.io import mmread, mmwrite
from scipy.sparse import lil_array

import vibroimpact as vi

LENGTH, WIDTH, HEIGHT = 0.5, 0.02, 0.003  # [m]
YOUNG, DENSITY = 210e9, 7850.0  # [Pa], [kg/m^3]
BENDING = YOUNG * WIDTH * HEIGHT**3 / 12.0  # E I [N m^2]
LINE_MASS = DENSITY * WIDTH * HEIGHT  # [kg/m]
N_ELEMENTS = 50
DURATION, RATE = 2.0, 2000  # of the record [s], [samples/s]


def write_inputs(folder: Path) -> None:
    """Write `mass.mtx`, `stiffness.mtx` (deflection and slope at each node but the clamped one) and `acceleration.csv`."""
    h = LENGTH / N_ELEMENTS
    mass = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    elements = {"mass": LINE_MASS * h / 420.0 * mass, "stiffness": BENDING / h**3 * stiffness}
    for name, upper in elements.items():
        full = lil_array((2 * N_ELEMENTS + 2, 2 * N_ELEMENTS + 2))
        for node in range(0, 2 * N_ELEMENTS, 2):
            full[node : node + 4, node : node + 4] += upper + np.triu(upper, 1).T
        mmwrite(folder / f"{name}.mtx", full.tocsr()[2:, 2:], symmetry="symmetric", precision=17)
    time = np.arange(int(DURATION * RATE) + 1) / RATE
    noise = np.random.default_rng(16).normal(size=time.size)
    band = np.fft.rfftfreq(time.size, 1.0 / RATE)
    shaped = np.fft.irfft(np.fft.rfft(noise) * ((band > 5.0) & (band < 120.0)), time.size)
    record = 15.0 * np.sin(np.pi * time / DURATION) ** 2 * shaped / shaped.std()  # [m/s^2]
    np.savetxt(folder / "acceleration.csv", np.column_stack([time, record]), delimiter=",", header="t [s],a [m/s^2]")


def read_scene(folder: Path) -> tuple[vi.Scene, vi.Reduction]:
    """Beam, shaker and stops from the files, and the reduction that has the directions."""
    mass, stiffness = (mmread(folder / f"{name}.mtx") for name in ("mass", "stiffness"))
    time, acceleration = np.loadtxt(folder / "acceleration.csv", delimiter=",", unpack=True)
    tip = mass.shape[0] - 2
    sideways = np.arange(mass.shape[0]) % 2 == 0  # what a shift of the base does to deflections and slopes
    beam = vi.reduce(mass, 0.02, stiffness, n_modes=12, directions=[tip], influence=sideways)
    stops = [vi.Stop(beam.direction(tip), 5e-4, 0.6, side=side) for side in ("upper", "lower")]
    return vi.Scene(beam.system, vi.BaseAcceleration((time, acceleration)), stops), beam


def run(folder: Path) -> tuple[vi.Trajectory, vi.Reduction]:
    """Simulate the record; write tables of the tip and of the impacts, and the spectrum."""
    scene, beam = read_scene(folder)
    rest = np.zeros(scene.n_dof)
    motion = vi.simulate(scene, rest, rest, (0.0, DURATION), method="exact")
    tip = beam.direction(len(beam.basis) - 2)
    t = np.arange(0.0, DURATION, 1.0 / 20_000)
    forces = [motion.contact_force(stop, t) for stop in (0, 1)]
    table = np.column_stack([t, motion.along(tip, t, derivative=2), *forces])
    np.savetxt(folder / "tip.csv", table, delimiter=",", fmt="%.9g", header="t [s],a [m/s^2],upper [N],lower [N]")
    impacts = np.column_stack([motion.impacts[name] for name in ("time", "stop", "speed_before", "impulse")])
    np.savetxt(folder / "impacts.csv", impacts, delimiter=",", fmt="%.12g", header="t [s],stop,speed [m/s],impulse [N s]")
    ax = vi.plot.spectrum(motion, along=tip)
    ax.set(xlim=(0.0, 2000.0), xlabel="angular frequency [rad/s]", ylabel="deflection of the tip [m]")
    ax.figure.savefig(folder / "measured_shaker.png", dpi=120)
    return motion, beam


def check(motion: vi.Trajectory, beam: vi.Reduction) -> None:
    """Compare the first frequency with the closed form, and the tip with its stops."""
    first = 1.8751040687119611**2 * np.sqrt(BENDING / LINE_MASS) / LENGTH**2
    found = float(np.sqrt(beam.system.stiffness[0]))
    print(f"first frequency {found:.6f} rad/s, closed form {first:.6f}")
    assert abs(found / first - 1.0) < 1e-6
    tip = motion.along(beam.direction(len(beam.basis) - 2))
    print(f"{len(motion.impacts)} impacts; the tip stays within {np.abs(tip).max():.6e} m of its 5e-4 m")
    assert len(motion.impacts) > 20
    assert np.abs(tip).max() < 5e-4 * (1.0 + 1e-9)


def main() -> None:
    """Make the files, run the beam on them, check."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the files")
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    write_inputs(folder)
    check(*run(folder))
    print(f"tables and figure in {folder}/")


if __name__ == "__main__":
    main()

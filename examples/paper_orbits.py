"""The source paper's three kinds of periodic impact motion: table and figures like its 3 to 8.

A double pendulum on a shaken base hits a wall with both pendulums at once (kind 1), with the upper one (kind 2) or with the
lower one (kind 3). The paper does not print its damping zeta, its wall angle theta0 or its forcing phase; those used here give
admissible, stable motions and stand in the table and above each figure. You will see, for each kind and each pendulum, the
phase portrait with the wall and the Poincare points, and the angle and the velocity over time; a velocity that jumps belongs to
a pendulum that hits the wall.

Run: python examples/paper_orbits.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

import vibroimpact as vi

#: Forcing periods in one period of the paper's orbit of each kind.
N_PERIODS = {1: 3, 2: 2, 3: 2}
#: zeta in C = 2 zeta K of the default scenes, as `paper_scene` documents them.
ZETA = {1: 0.05, 2: 0.01, 3: 0.05}
NAMES = ("upper pendulum", "lower pendulum")


def paper_orbit(kind: int) -> vi.Orbit:
    """The stable admissible orbit of a kind; for kind 1 the wall angle is found together with the phase."""
    free = "clearance" if kind == 1 else None
    orbits = vi.periodic_orbits(vi.paper_scene(kind), vi.KINDS[kind], N_PERIODS[kind], free=free)
    return orbits[0]


def row(kind: int, orbit: vi.Orbit) -> str:
    """One line of the table."""
    theta0 = orbit.scene.stops[vi.KINDS[kind][0] if kind > 1 else 0].clearance
    speeds = ", ".join(f"{v:+.6f}" for v in orbit.v0)
    radius = max(abs(orbit.floquet_multipliers))
    return (
        f"{kind:>4}  {ZETA[kind]:<6} {theta0:<10.6f} {math.degrees(orbit.phase):>10.4f}  {speeds:<22} "
        f"{orbit.is_admissible!s:<11} {orbit.is_stable!s:<7} {radius:.5f}"
    )


def figure(kind: int, orbit: vi.Orbit) -> plt.Figure:
    """Phase portrait, angle and velocity of both pendulums over two periods."""
    fig, axes = plt.subplots(2, 3, figsize=(12, 6.4), layout="constrained")
    for i, name in enumerate(NAMES):
        vi.plot.phase_portrait(orbit, axes[i, 0], along=i)
        vi.plot.time_history(orbit, axes[i, 1], along=i, periods=2)
        vi.plot.time_history(orbit, axes[i, 2], along=i, periods=2, quantity="velocity", jumps=True)
        axes[i, 0].set(title=name, xlabel=f"angle $\\theta_{i + 1}$ [rad]", ylabel=f"velocity $\\theta_{i + 1}'$ [-]")
        axes[i, 1].set(xlabel="time $\\tau$ [-]", ylabel=f"angle $\\theta_{i + 1}$ [rad]")
        axes[i, 2].set(xlabel="time $\\tau$ [-]", ylabel=f"velocity $\\theta_{i + 1}'$ [-]")
    theta0 = orbit.scene.stops[0].clearance
    fig.suptitle(
        f"Kind {kind}: $\\zeta$ = {ZETA[kind]}, $\\theta_0$ = {theta0:.6f} rad, "
        f"phase = {math.degrees(orbit.phase):.4f}$\\degree$, {N_PERIODS[kind]} forcing periods"
    )
    return fig


def main() -> None:
    """Print the table, write the figures, check the published numbers of kind 1."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    print("kind  zeta   theta0     phase[deg]  velocity after impact  admissible  stable  largest multiplier")
    for kind in (1, 2, 3):
        orbit = paper_orbit(kind)
        print(row(kind, orbit))
        fig = figure(kind, orbit)
        path = output / f"paper_kind_{kind}.png"
        fig.savefig(path, dpi=120)
        plt.close(fig)
        assert orbit.is_admissible
        assert orbit.is_stable
        if kind == 1:
            assert abs(math.degrees(orbit.phase) - 73.0915) < 5e-5
            assert abs(orbit.q0[0] - 0.806286) < 5e-7
    print(f"figures in {output}/")


if __name__ == "__main__":
    main()

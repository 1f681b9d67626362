"""A double pendulum that swings into a wall: from the linear orbit to the one with large angles.

Two links hang from a base that moves to and fro; a vertical wall, which moves with the base, stops the lower bob. The
linearised pendulum has its periodic motions in closed form; from one of them `find_orbit` goes on to the motion of the real
one. A run from rest settles on it, and its energy ledger says where the work of the base goes.

You will see the linear orbit beside the one of the real pendulum, and that the difference is of second order in the size
of the motion; the run from rest; the balance of work and losses over one period; and the multipliers beside those of the
simulated return map. The figure has phase portraits, energies, impact speeds and multipliers; the moving picture two periods.

Run: python examples/wall_pendulum.py [--output DIRECTORY]
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

MASSES = [1.0, 0.5]  # [kg]
LENGTHS = [0.5, 0.3]  # [m]
DAMPING = 0.02  # of each joint [N m s]
PERIOD = 1.25  # of the base [s]
AMPLITUDE = 0.03  # of the base [m]
POSITION = 0.12  # of the wall, to the right of the base [m]
RESTITUTION = 0.7
LOWER = 1  # the bob that hits, and the coordinate that is drawn


def pendulum(size: float = 1.0) -> vi.Scene:
    """Pendulum and wall; `size` scales the motion of the base and the way to the wall alike."""
    chain = vi.PendulumChain(MASSES, LENGTHS, DAMPING)
    base = vi.BaseMotion(size * AMPLITUDE, 2.0 * math.pi / PERIOD)
    return vi.Scene(chain, base, vi.Wall(LOWER, size * POSITION, RESTITUTION))


def linear_and_real(size: float = 1.0) -> tuple[vi.Orbit, vi.Orbit]:
    """The orbit of the linearised pendulum that hits the wall once in each period, and the real one near it."""
    scene = pendulum(size)
    guess = vi.periodic_orbits(scene.linearise(), [0])[0]
    return guess, vi.find_orbit(scene, guess)


def difference(size: float) -> float:
    """By how much the linear orbit's speed at the wall is wrong, relatively."""
    linear, real = (orbit.impacts["speed_before"][0] for orbit in linear_and_real(size))
    return abs(linear / real - 1.0)


def check_orbits() -> tuple[vi.Orbit, vi.Orbit]:
    """Print both orbits; the smaller the motion, the better the linear one, by the square."""
    linear, real = linear_and_real()
    print(linear, real, sep="\n")
    assert real.is_admissible
    assert real.is_stable
    errors = [difference(size) for size in (1.0, 0.1, 0.01)]
    print(
        "the linear speed at the wall is wrong by {:.1e}, in a motion a tenth as large by {:.1e}, a hundredth {:.1e}".format(
            *errors
        )
    )
    assert 95.0 < errors[1] / errors[2] < 105.0
    return linear, real


def check_rest(real: vi.Orbit) -> vi.Trajectory:
    """From rest the pendulum settles on the orbit; the ledger of the run balances."""
    run = vi.simulate(pendulum(), [0.0, 0.0], [0.0, 0.0], (0.0, 40.0 * PERIOD))
    last, orbit = run.impacts[-1], real.impacts[0]
    print(
        f"from rest: {len(run.impacts)} impacts, the last at {last['speed_before']:.9f}, the orbit's {orbit['speed_before']:.9f}"
    )
    assert abs(last["speed_before"] - orbit["speed_before"]) < 1e-6
    energy = run.energy
    largest = np.max(energy.forcing_work)
    print(f"its energy ledger balances to {np.max(np.abs(energy.balance)) / largest:.1e} of the work")
    assert np.max(np.abs(energy.balance)) < 1e-8 * largest
    return run


def check_period(real: vi.Orbit) -> None:
    """Over a period of the orbit the work of the base is what dampers and wall take."""
    t = np.array([0.5, 1.5]) * real.period
    run = vi.simulate(real.scene, real.q0, real.v0, (0.0, 2.0 * real.period), t_eval=t, rtol=1e-11)
    work, dampers, wall = (np.ptp(getattr(run.energy, name)) for name in ("forcing_work", "damping_loss", "impact_loss"))
    print(f"in a period the base does {work:.6f} J, dampers take {dampers:.6f} J, the wall {wall:.6f} J")
    assert abs(work - dampers - wall) < 1e-8 * work


def check_multipliers(real: vi.Orbit) -> None:
    """Compare the multipliers with the eigenvalues of the simulated map from one half period to the next."""
    start = np.concatenate([real.position([0.5 * real.period])[0], real.velocity([0.5 * real.period])[0]])
    step = 1e-5

    def after_a_period(x: np.ndarray) -> np.ndarray:
        span = (0.5 * real.period, 1.5 * real.period)
        return np.concatenate(vi.simulate(real.scene, x[:2], x[2:], span, rtol=1e-12, atol=1e-14, keep="final").final)

    columns = [(after_a_period(start + d) - after_a_period(start - d)) / (2.0 * step) for d in step * np.eye(4)]
    simulated = np.sort_complex(np.linalg.eigvals(np.column_stack(columns)))
    mismatch = np.max(np.abs(simulated - np.sort_complex(real.floquet_multipliers)))
    print(f"multipliers agree with the simulated return map to {mismatch:.1e}")
    assert mismatch < 1e-6


def figure(linear: vi.Orbit, real: vi.Orbit, run: vi.Trajectory) -> plt.Figure:
    """Portraits, energies, speeds and multipliers."""
    fig, ((portrait, energies), (speeds, multipliers)) = plt.subplots(2, 2, figsize=(12, 9), layout="constrained")
    vi.plot.phase_portrait(real, portrait, along=LOWER, label="pendulum", section=False)
    vi.plot.phase_portrait(linear, portrait, along=LOWER, label="linearised", section=False, walls=False)
    portrait.set(xlabel="angle of the lower link [rad]", ylabel="its velocity [rad/s]", title="One impact in each period")
    portrait.legend()
    vi.plot.energy(run, energies)
    exchanged = fig.axes[-1]
    energies.set(ylabel="energy [J]", title="From rest: where the work of the base goes", xlim=(0.0, 12.0 * PERIOD))
    most = np.max(run.energy.forcing_work[run.t < 12.0 * PERIOD])
    exchanged.set(xlabel="time [s]", ylabel="exchanged [J]", ylim=(0.0, 1.1 * most))
    vi.plot.impact_speeds(run, speeds)
    speeds.axhline(real.impacts["speed_before"][0], color="black", linestyle="--", linewidth=1.0, label="the orbit")
    speeds.set(xlabel="time [s]", ylabel="speed before impact [m/s]", title="From rest: it settles on the orbit")
    speeds.legend()
    vi.plot.multipliers(real, multipliers)
    multipliers.set_title("Floquet multipliers")
    return fig


def main() -> None:
    """Compare orbits, runs and multipliers; write the figure and the moving picture."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    linear, real = check_orbits()
    run = check_rest(real)
    check_period(real)
    check_multipliers(real)
    fig = figure(linear, real, run)
    fig.savefig(output / "wall_pendulum.png", dpi=120)
    animation = vi.plot.animate(real, t_span=(0.0, 2.0 * PERIOD - 0.05), fps=20)  # the next frame would be the first
    animation.save(output / "wall_pendulum.gif", writer="pillow", dpi=70)
    plt.close("all")
    print(f"figures in {output}/")


if __name__ == "__main__":
    main()

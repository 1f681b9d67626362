"""A ball that bounces on a shaken table, once in each period of the table.

The ball is a rigid body under gravity: a linear system without stiffness, with its height above the table as coordinate. The
table, which the ball may not cross, is a stop; its motion is the base motion. There is a closed form (docs of the functions
below): the ball leaves the table at the relative speed `e g T / (1 + e)`, whatever the amplitude, and the amplitude decides
the phase of the table at which it does, and whether it does so stably.

You will see the table of both orbits beside the closed form, a ball that is dropped and settles on the stable one, and the map of
existence and stability over table acceleration and restitution, every cell of which agrees with the closed form. The
figure has the ball's motion above the map; the lines on the map are the closed form.

Run: python examples/bouncing_ball.py [--output DIRECTORY]
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

GRAVITY = 9.81  # [m/s^2]
FREQUENCY = 2.0 * math.pi * 20.0  # of the table [rad/s]
PERIOD = 2.0 * math.pi / FREQUENCY  # [s]
RESTITUTION = 0.8
ACCELERATION = 0.6  # amplitude of the table's acceleration [g]
DROP = 5e-3  # height from which the ball is dropped [m]


def ball(acceleration: float, restitution: float = RESTITUTION) -> vi.Scene:
    """Ball and table; `acceleration` is the amplitude of the table's, in g."""
    system = vi.LinearSystem([1.0], [0.0], [0.0], load=[-GRAVITY], influence=[1.0])
    table = vi.BaseMotion(acceleration * GRAVITY / FREQUENCY**2, FREQUENCY)
    return vi.Scene(system, table, vi.Stop(0, 0.0, restitution, side="lower"))


def launch_speed(restitution: float) -> float:
    """Relative speed `e g T / (1 + e)` with which the ball leaves the table [m/s]."""
    return restitution * GRAVITY * PERIOD / (1.0 + restitution)


def launch_phases(acceleration: float, restitution: float) -> list[float]:
    """Both phases with `sin(phase) = (v - g T / 2) / (a w)` [rad]; the first is the stable one's.

    In one period gravity takes `g T^2 / 2` from the ball's way and the table's speed at launch, `-a w sin(phase)`, adds to it.
    """
    sine = (launch_speed(restitution) - 0.5 * GRAVITY * PERIOD) / (acceleration * GRAVITY / FREQUENCY)
    return [math.asin(sine) % (2.0 * math.pi), math.pi - math.asin(sine)]


def stability_range(restitution):
    """Accelerations of the table between which the stable orbit is, in g.

    The return map has determinant e^2 and trace `1 + e^2 - (1 + e)^2 (a w^2 / g) cos(phase)`: the orbit is born in a fold
    at cos(phase) = 0 and doubles its period where `cos(phase) = 2 (1 + e^2) / (1 + e)^2 / (a w^2 / g)`.
    """
    fold = math.pi * (1.0 - restitution) / (1.0 + restitution)
    return fold, np.hypot(fold, 2.0 * (1.0 + restitution**2) / (1.0 + restitution) ** 2)


def check_orbits() -> vi.Orbit:
    """Print both orbits beside the closed form, return the stable one."""
    orbits = vi.periodic_orbits(ball(ACCELERATION), [0])
    assert len(orbits) == 2
    speed = launch_speed(RESTITUTION)
    print("speed [m/s]  closed form   phase [rad]  closed form   stable")
    for orbit, phase in zip(orbits, launch_phases(ACCELERATION, RESTITUTION), strict=True):
        print(f"{orbit.v0[0]:<11.9f}  {speed:.9f}   {orbit.phase:.9f}  {phase:.9f}   {orbit.is_stable}")
        assert abs(orbit.v0[0] - speed) < 1e-12 * speed
        assert abs(orbit.phase - phase) < 1e-12
        assert orbit.is_admissible
    assert (orbits[0].is_stable, orbits[1].is_stable) == (True, False)
    return orbits[0]


def check_drop(orbit: vi.Orbit) -> vi.Trajectory:
    """Drop the ball; after 200 periods it leaves the table with the orbit's speed and at its phase."""
    run = vi.simulate(orbit.scene.replace(phase=0.0), [DROP], [0.0], (0.0, 200.0 * PERIOD))
    last = run.impacts[-1]
    print(f"dropped: after {len(run.impacts)} impacts the speed is {last['speed_after']:.9f}, the phase {last['phase']:.9f}")
    assert abs(last["speed_after"] - orbit.v0[0]) < 1e-9
    assert abs(last["phase"] - orbit.phase) < 1e-9
    return run


def check_map() -> vi.ExistenceMap:
    """Compute the map over acceleration and restitution and compare every cell with the closed form."""
    accelerations, restitutions = np.linspace(0.01, 2.0, 200), np.linspace(0.2, 1.0, 161)[:-1]
    existence = vi.existence_map(ball(1.0), [0], ("forcing_scale", accelerations), ("restitution", restitutions))
    fold, flip = stability_range(restitutions[:, None])
    np.testing.assert_array_equal(existence.n_orbits, np.where(accelerations > fold, 2, 0))
    np.testing.assert_array_equal(existence.is_stable, (accelerations > fold) & (accelerations < flip))
    print(f"map: {existence.n_orbits.size} cells, each as in the closed form")
    return existence


def figure(run: vi.Trajectory, existence: vi.ExistenceMap) -> plt.Figure:
    """Heights of ball and table in the first periods, and the map with the closed form on it."""
    fig, (above, below) = plt.subplots(2, 1, figsize=(8, 8), layout="constrained")
    t = np.linspace(0.0, 12.0 * PERIOD, 2000)
    table = run.scene.forcing.amplitude * np.cos(FREQUENCY * t)
    above.plot(t, 1e3 * (table + run.position(t)[:, 0]), label="ball")
    above.fill_between(t, 1e3 * table, -1.0, color="0.75", label="table")
    above.set(xlabel="time [s]", ylabel="height [mm]", ylim=(-1.0, None), xlim=(0.0, t[-1]), title="Ball dropped on the table")
    above.legend()
    vi.plot.existence_map(existence, below)
    restitution = existence.y
    fold, flip = stability_range(restitution)
    below.plot(fold, restitution, color="black", linestyle="--", label="fold, closed form")
    below.plot(flip, restitution, color="black", linestyle=":", label="period doubling, closed form")
    below.plot(ACCELERATION, RESTITUTION, "o", markerfacecolor="white", markeredgecolor="black", label="the ball above")
    below.set(
        xlabel="acceleration of the table [g]", ylabel="restitution [-]", title="One bounce in each period", xlim=(0.0, 2.0)
    )
    below.legend(loc="upper right")
    return fig


def main() -> None:
    """Compare orbits, simulation and map with the closed form; write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    orbit = check_orbits()
    fig = figure(check_drop(orbit), check_map())
    fig.savefig(output / "bouncing_ball.png", dpi=120)
    plt.close(fig)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()

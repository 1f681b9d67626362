"""An impact damper: a ball in a box that takes energy from whatever shakes the box.

The ball of mass m is free between two walls a room g apart. Where the box moves by `a cos(w t)`, a motion with one impact on
each wall in a period has a closed form: the ball flies at the speed `V = rho a w sin(theta)`, `rho = (1 + e)/(1 - e)`, theta
the phase of the box at an impact with the wall ahead, and `g/a = pi rho sin(theta) - 2 cos(theta)`. Each impact has the
relative speed `2 V/(1 + e)`, so that a period takes `4 m V^2/rho`. The second half of a period is the first one mirrored; by
the multipliers of that half the motion is stable from the pitchfork `g/a = (pi^2/2 - 2)/sqrt(1 + (pi/(2 rho))^2)` to the fold
`sqrt(pi^2 rho^2 + 4)`.

You will see the energy that a period takes over the room, every orbit beside the closed form, and a structure at its resonance
with a ball of 3 % of its mass beside it, at rest in its box or not: the ball takes most of the swing away. The script checks the
energies, that the ledgers close, and that the damper damps.

Run: python examples/impact_damper.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import vibroimpact as vi

MASS, RESTITUTION = 0.03, 0.6  # of the ball
RHO = (1.0 + RESTITUTION) / (1.0 - RESTITUTION)
PITCHFORK = (np.pi**2 / 2.0 - 2.0) / np.hypot(1.0, np.pi / (2.0 * RHO))
FOLD = np.hypot(np.pi * RHO, 2.0)


def box(room: float) -> vi.Scene:
    """A ball in a box that moves by cos t."""
    walls = [
        vi.Stop(0, 0.5 * room, RESTITUTION, motion=vi.Harmonic([1.0], 1.0)),
        vi.Stop(0, 0.5 * room, RESTITUTION, side="lower", motion=vi.Harmonic([-1.0], 1.0)),
    ]
    return vi.Scene(vi.LinearSystem(MASS, 0.0, 0.0), None, walls)


def closed_form(room: float) -> tuple[float, float]:
    """Return phase and speed of the motion that may be stable, for a box that moves by cos t."""
    theta = brentq(lambda x: np.pi * RHO * np.sin(x) - 2.0 * np.cos(x) - room, 0.0, np.pi - np.arctan(np.pi * RHO / 2.0))
    return theta, RHO * np.sin(theta)


def energy_per_period(room: float) -> float:
    """Return what the impacts of the orbit of a box take in a period, found by shooting from near it."""
    theta, speed = closed_form(room)
    # Just after an impact with the upper wall, on its way down, and a little off.
    start, end = theta, theta + 4.0 * np.pi
    scene = box(room)
    run = vi.simulate(scene, [0.5 * room + np.cos(theta) - 1e-9], [-1.001 * speed], (start, end))
    orbit = vi.find_orbit(scene, run, 1)
    assert orbit.is_stable
    return float(orbit.energy.impact_loss[-1])


def structure(with_ball: bool) -> vi.Scene:
    """A structure at its resonance, with a box on it; without the ball's walls it is alone."""
    both = vi.LinearSystem([1.0, MASS], [0.01, 0.0], [1.0, 0.0])
    walls = [vi.Stop([-1.0, 1.0], 0.3, RESTITUTION, side=side) for side in ("upper", "lower")]
    return vi.Scene(both, vi.Harmonic([0.01, 0.0], 1.0), walls if with_ball else ())


def main() -> None:
    """Check the energies, run the structure, draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    folder: Path = parser.parse_args().output

    rooms = np.linspace(1.02 * PITCHFORK, 0.98 * FOLD, 25)
    exact = np.array([4.0 * MASS * closed_form(room)[1] ** 2 / RHO for room in rooms])
    found = np.array([energy_per_period(room) for room in rooms])
    print(
        f"energy per period at {rooms.size} rooms: off the closed form by {np.abs(found / exact - 1.0).max():.1e} of it at most"
    )
    np.testing.assert_allclose(found, exact, rtol=1e-9)

    span = (0.0, 200.0 * 2.0 * np.pi)
    damped, alone = (vi.simulate(structure(ball), [0.0, 0.0], [0.0, 0.0], span) for ball in (True, False))
    late = np.linspace(150.0, 200.0, 5001) * 2.0 * np.pi
    swings = [float(np.abs(run.along(0, late)).max()) for run in (damped, alone)]
    print(f"largest swing late in the run: {swings[0]:.3f} with the ball, {swings[1]:.3f} without; {len(damped.impacts)} impacts")
    assert swings[0] < 0.7 * swings[1]
    energy = damped.energy
    closes = np.abs(energy.balance).max() / energy.forcing_work.max()
    taken = energy.impact_loss[-1] / energy.forcing_work[-1]
    print(f"the ball took {100.0 * taken:.0f} % of the work; the ledger closes to {closes:.0e} of it")
    assert closes < 1e-11

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    left.plot(rooms, exact, color="0.4", label="closed form")
    left.plot(rooms, found, "o", markersize=4, label="orbits")
    left.set(xlabel="room of the box over its amplitude", ylabel="energy taken in a period")
    left.legend()
    t = np.linspace(*span, 8001)
    for run, name, style in ((alone, "alone", "0.7"), (damped, "with the ball", "C0")):
        right.plot(t / (2.0 * np.pi), run.along(0, t), color=style, linewidth=0.6, label=name)
    right.set(xlabel="forcing periods", ylabel="structure")
    right.legend(loc="upper left")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "impact_damper.png", dpi=120)
    print(f"figure in {folder}/impact_damper.png")


if __name__ == "__main__":
    main()

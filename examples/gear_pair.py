"""A gear pair with elastic teeth: where it loses contact, and the two motions that it then has.

The coordinate is the dynamic transmission error over half the backlash: teeth touch at 1 and at -1, where a spring and a dashpot
give way (the unit of time is that of the mesh's own frequency). A torque presses the teeth together with 0.1, and an error of
the wheels with amplitude 0.05 shakes them. As long as they stay together the pair is linear, and its closed form says from
which frequency the dynamic force is larger than the torque: there the teeth separate, the mesh becomes softer, and the motion
jumps. On the way down the large motion goes on far below that frequency; between the two jumps there are both.

You will see the response over the frequency, up and down, beside the linear one, and both motions at one frequency with the
force of their teeth. Whatever the motion, over a period the teeth carry the torque.

Run: python examples/gear_pair.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

TORQUE, ERROR = 0.1, 0.05  # over half the backlash: static deflection of the mesh, amplitude of the error
STIFFNESS, DASHPOT, DRAG = 1.0, 0.1, 0.01
FREQUENCIES = np.linspace(0.4, 1.3, 91)
BOTH = 0.72  # a frequency with both motions


def gears(frequency: float) -> vi.Scene:
    """Return the pair at a frequency of the error."""
    relative = vi.LinearSystem([1.0], [DRAG], [0.0], load=[TORQUE], influence=[1.0])
    tooth = vi.Spring(STIFFNESS, DASHPOT, release="gap")
    flanks = [vi.Stop(0, 1.0, contact=tooth), vi.Stop(0, 1.0, side="lower", contact=tooth)]
    return vi.Scene(relative, vi.BaseMotion(ERROR, frequency), flanks)


def linear(frequency: np.ndarray | float) -> np.ndarray:
    """Return the amplitude of teeth that stay together."""
    return ERROR * frequency**2 / np.abs(STIFFNESS - frequency**2 + 1j * (DASHPOT + DRAG) * frequency)


def separation() -> float:
    """Return the frequency from which they do not: the amplitude is then the static deflection. A quadratic in its square."""
    share = (ERROR * STIFFNESS / TORQUE) ** 2
    roots = np.roots([1.0 - share, (DASHPOT + DRAG) ** 2 - 2.0 * STIFFNESS, STIFFNESS**2])
    return float(np.sqrt(min(roots.real)))


@dataclass(frozen=True)
class Response:
    """Of each frequency the amplitude, whether the teeth separate, and the state at the end."""

    amplitude: np.ndarray
    separates: np.ndarray
    states: list[tuple[np.ndarray, np.ndarray]]


def swept(frequencies: np.ndarray) -> Response:
    """Follow the motion from frequency to frequency."""
    q, v = np.array([1.0 + TORQUE / STIFFNESS]), np.zeros(1)
    amplitude, separates, states = [], [], []
    for frequency in frequencies:
        scene = gears(frequency)
        settling = vi.simulate(scene, q, v, (0.0, 200.0 * scene.period), keep="final")
        run = vi.simulate(scene, *settling.final, (0.0, 10.0 * scene.period))
        x = run.along(0, np.linspace(0.0, run.t_end, 2001))
        amplitude.append(np.ptp(x) / 2.0)
        separates.append(len(run.regimes) > 1)
        q, v = run.final
        states.append((q, v))
    return Response(np.array(amplitude), np.array(separates), states)


def check_sweeps(up: Response, down: Response) -> None:
    """Print and check where the teeth separate and where they come together again."""
    together = ~up.separates & (FREQUENCIES < 1.0)
    last = FREQUENCIES[together].max()
    back = FREQUENCIES[down.separates & (FREQUENCIES < 1.0)].min()
    print(
        f"on the way up they stay together to w = {last:.2f}, closed form {separation():.4f}; "
        f"on the way down they separate to w = {back:.2f}"
    )
    assert abs(last - separation()) <= FREQUENCIES[1] - FREQUENCIES[0]
    assert back < separation() - 0.05, "between the jumps there are two motions"
    np.testing.assert_allclose(up.amplitude[together], linear(FREQUENCIES[together]), rtol=1e-3)


def orbits(up: Response, down: Response) -> list[vi.Orbit]:
    """Return both motions at one frequency, closed, and check them."""
    k = int(np.abs(FREQUENCIES - BOTH).argmin())
    scene = gears(FREQUENCIES[k])
    found = []
    print("\namplitude  contacts in a period  largest force  largest multiplier  force over torque, mean")
    for response in (up, down):
        start = response.states[k]
        orbit = vi.find_orbit(scene, vi.simulate(scene, *start, (0.0, 50.0 * scene.period)))
        x = orbit.along(0, np.linspace(0.0, orbit.period, 2001))
        force = tooth_force(orbit, np.linspace(0.0, orbit.period, 2001))
        mean = (orbit.impulse(0) - orbit.impulse(1)) / (TORQUE * orbit.period)
        largest = np.abs(orbit.floquet_multipliers).max()
        counts = f"{np.ptp(x) / 2.0:.6f}   {len(orbit.contacts):<20}  {force.max():.4f}"
        print(f"{counts}         {largest:.4f}              {mean:.12f}")
        assert orbit.is_stable
        assert orbit.is_admissible
        assert abs(mean - 1.0) < 1e-9
        found.append(orbit)
    return found


def tooth_force(motion: vi.Orbit, t: np.ndarray) -> np.ndarray:
    """Return the force on the pressed flank."""
    approach = motion.along(0, t) - 1.0
    return np.where(approach > 0.0, STIFFNESS * approach + DASHPOT * motion.velocity(t)[:, 0], 0.0)


def draw(up: Response, down: Response, found: list[vi.Orbit], output: Path) -> None:
    """Draw the response above both motions and their forces."""
    figure, axes = plt.subplots(3, 1, figsize=(7.0, 8.0), layout="constrained", height_ratios=(3, 2, 2))
    axes[0].plot(FREQUENCIES, linear(FREQUENCIES), color="0.6", label="teeth that stay together")
    axes[0].plot(FREQUENCIES, up.amplitude, ".-", color="#1d3a66", markersize=4, label="up")
    axes[0].plot(FREQUENCIES, down.amplitude, ".-", color="#b8503f", markersize=4, label="down")
    axes[0].axvline(separation(), color="0.7", linewidth=0.8)
    axes[0].set(xlabel="frequency w", ylabel="amplitude / half the backlash", ylim=(0.0, 0.65))
    axes[0].legend()
    for orbit, color, name in zip(found, ("#1d3a66", "#b8503f"), ("together", "apart in each period"), strict=True):
        t = np.linspace(0.0, 3.0 * orbit.period, 1500)
        inside = t % orbit.period
        axes[1].plot(t / orbit.period, orbit.along(0, inside), color=color, label=name)
        axes[2].plot(t / orbit.period, tooth_force(orbit, inside), color=color)
    axes[1].axhspan(-0.2, 1.0, color="0.93", zorder=0)
    axes[1].set(ylabel="transmission error", ylim=(0.3, 1.7), title=f"Both motions at w = {BOTH:g}; grey: in the backlash")
    axes[1].legend()
    axes[2].axhline(TORQUE, color="0.7", linewidth=0.8)
    axes[2].axhline(0.0, color="0.7", linewidth=0.8)
    axes[2].set(xlabel="periods", ylabel="force of the teeth")
    figure.savefig(output / "gear_pair.png", dpi=130)


def main() -> None:
    """Sweep, check and draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    up, back = swept(FREQUENCIES), swept(FREQUENCIES[::-1])
    down = Response(back.amplitude[::-1], back.separates[::-1], back.states[::-1])
    check_sweeps(up, down)
    draw(up, down, orbits(up, down), output)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()
